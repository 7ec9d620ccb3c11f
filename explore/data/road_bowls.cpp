#include "data/road_bowls.h"

#include "data/resolution.h"

#include <algorithm>
#include <map>

namespace explore::data {
namespace {

constexpr std::size_t least_groups = 5;
constexpr std::size_t least_of_sensor = 8;

using StationOutcomes = std::vector<pave::Outcome<StationBowls>>;

// Of each station: what its file is rounded to, or its own readings are where the file's are not.
std::vector<double> resolutions_of(const std::vector<const FwdStation*>& stations) {
    std::map<std::string, std::vector<const FwdStation*>> files;
    for (const FwdStation* s : stations) {
        files[s->file].push_back(s);
    }
    std::map<std::string, double> of_file;
    for (const auto& [file, own] : files) {
        of_file[file] = resolution_um(own);
    }
    std::vector<double> resolutions;
    resolutions.reserve(stations.size());
    for (const FwdStation* s : stations) {
        resolutions.push_back(std::max(of_file.at(s->file), own_resolution_um(*s)));
    }
    return resolutions;
}

StationOutcomes made(const std::vector<const FwdStation*>& stations, DropChoice choice,
                     const std::vector<double>& resolutions) {
    StationOutcomes bowls;
    bowls.reserve(stations.size());
    for (std::size_t i = 0; i < stations.size(); ++i) {
        choice.resolution_um = resolutions[i];
        bowls.push_back(bowls_of(*stations[i], choice));
    }
    return bowls;
}

// Whether at most of the stations where it can be told the first drop seats the plate.
bool first_drops_seat(const std::vector<const FwdStation*>& stations, const StationOutcomes& bowls) {
    std::size_t told = 0;
    std::size_t seating = 0;
    for (std::size_t i = 0; i < bowls.size(); ++i) {
        if (bowls[i] && stations[i]->drops.size() >= 3) {
            ++told;
            seating += std::any_of(bowls[i]->left_out.begin(), bowls[i]->left_out.end(),
                                   [](const auto& drop) { return drop.why == LeftOut::seating; })
                           ? 1
                           : 0;
        }
    }
    return 2 * seating > told;
}

} // namespace

std::optional<RepeatScatter> scatter_of(const StationOutcomes& stations) {
    std::map<double, std::vector<ScatterSample>> of_sensor;
    std::vector<ScatterSample> all;
    std::size_t groups = 0;
    for (const auto& station : stations) {
        if (!station) {
            continue;
        }
        for (const DeflectionBowl& bowl : station->levels) {
            groups += bowl.drops.size() > 1 ? 1 : 0;
            for (const BowlReading& r : bowl.readings) {
                if (r.scatter && *r.scatter > 0.0) { // to the last digit alike: copied, or rounded
                    of_sensor[r.offset_mm].push_back({*r.scatter, r.drops});
                    all.push_back(of_sensor[r.offset_mm].back());
                }
            }
        }
    }
    if (groups < least_groups || all.empty()) {
        return std::nullopt;
    }
    RepeatScatter scatter{.overall = middle_scatter(all)};
    for (const auto& [offset, samples] : of_sensor) {
        if (samples.size() >= least_of_sensor) {
            scatter.of_sensor[offset] = middle_scatter(samples);
        }
    }
    return scatter;
}

std::vector<pave::Outcome<StationBowls>> bowls_of_road(const std::vector<const FwdStation*>& stations,
                                                       DropChoice choice) {
    choice.keeps_contradicted = true; // what is far off does not rule the middle
    const std::vector<double> resolutions = resolutions_of(stations);
    const StationOutcomes all = made(stations, choice, resolutions);
    choice.keeps_contradicted = false;
    choice.first_of_two_seats = choice.first_of_two_seats || first_drops_seat(stations, all);
    choice.scatter = scatter_of(all);
    return made(stations, choice, resolutions);
}

} // namespace explore::data

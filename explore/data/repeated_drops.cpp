#include "data/repeated_drops.h"

#include "base/error.h"
#include "data/road_bowls.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::data {
namespace {

using Eigen::Index;

// ln(deflection / pressure) of the sensor there; nothing: it did not read.
std::optional<double> reading_at(const FwdDrop& drop, double offset_mm) {
    const auto at = std::find_if(drop.readings.begin(), drop.readings.end(), [&](const FwdReading& r) {
        return r.offset_mm == offset_mm && r.deflection_um > 0.0;
    });
    return at == drop.readings.end() ? std::nullopt : std::optional(std::log(at->deflection_um / drop.pressure_kPa));
}

std::optional<RepeatedDrops> repeats_of(const std::vector<const FwdDrop*>& drops, const DeflectionBowl& bowl) {
    RepeatedDrops group;
    group.drops = static_cast<int>(drops.size());
    std::vector<std::vector<double>> readings; // of a sensor, one a drop
    for (const BowlReading& sensor : bowl.readings) {
        std::vector<double> values;
        for (const FwdDrop* drop : drops) {
            if (const auto value = reading_at(*drop, sensor.offset_mm)) {
                values.push_back(*value);
            }
        }
        if (values.size() == drops.size()) {
            group.offsets_mm.push_back(sensor.offset_mm);
            group.deflections_um.push_back(sensor.deflection_um);
            readings.push_back(std::move(values));
        }
    }
    if (drops.size() < 2 || readings.empty()) {
        return std::nullopt;
    }
    Eigen::MatrixXd e(static_cast<Index>(readings.size()), static_cast<Index>(drops.size()));
    for (std::size_t i = 0; i < readings.size(); ++i) {
        e.row(static_cast<Index>(i)) = Eigen::RowVectorXd::Map(readings[i].data(), e.cols());
    }
    e.colwise() -= Eigen::VectorXd(e.rowwise().mean());
    group.scatter = e * e.transpose();
    return group;
}

} // namespace

std::vector<RepeatedDrops> repeated_drops(const std::vector<FwdStation>& stations, std::vector<std::string>& left_out) {
    std::vector<const FwdStation*> road;
    road.reserve(stations.size());
    for (const FwdStation& station : stations) {
        road.push_back(&station);
    }
    const auto all = bowls_of_road(road);
    std::vector<RepeatedDrops> groups;
    for (std::size_t s = 0; s < stations.size(); ++s) {
        const auto& bowls = all[s];
        if (!bowls) {
            continue;
        }
        std::map<int, std::vector<std::string>> without; // drops with readings that the others contradict: which
        for (const ContradictedReading& r : bowls->readings_left_out) {
            without[r.drop].push_back(
                fmt::format("{:.1f} um at {:g} mm, its repeats {:.1f} um", r.read_um, r.offset_mm, r.repeats_um));
        }
        for (const auto& [drop, readings] : without) {
            left_out.push_back(fmt::format("{}: drop {}, all its sensors, for it reads {}", stations[s].name, drop,
                                           pave::join(readings, " and ")));
        }
        for (const DropLeftOut& drop : bowls->left_out) {
            if (drop.why == LeftOut::contradicted) {
                left_out.push_back(fmt::format("{}: drop {}, {}", stations[s].name, drop.number, drop.words));
            }
        }
        for (const DeflectionBowl& bowl : bowls->levels) {
            std::vector<const FwdDrop*> drops;
            for (const FwdDrop& drop : stations[s].drops) {
                if (std::find(bowl.drops.begin(), bowl.drops.end(), drop.number) != bowl.drops.end() &&
                    !without.contains(drop.number)) {
                    drops.push_back(&drop);
                }
            }
            if (auto group = repeats_of(drops, bowl)) {
                groups.push_back(std::move(*group));
            }
        }
    }
    return groups;
}

} // namespace explore::data

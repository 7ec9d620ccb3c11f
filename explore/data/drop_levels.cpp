#include "data/drop_levels.h"

#include "data/drop_agreement.h"
#include "data/median.h"

#include <algorithm>
#include <cmath>

namespace explore::data {
namespace {

constexpr double same_level = 0.9;       // of the highest pressure of a level
constexpr double seating_differs = 0.05; // deflection of a seating drop from the repeats, and
constexpr double seating_scatter = 4.0;  // standard deviations of a drop
constexpr double repeats_agree = 0.025;  // deflections of the repeats from each other
constexpr double centre_tolerance_mm = 0.5;

const FwdReading* centre_of(const FwdDrop& drop) {
    const auto at = std::find_if(drop.readings.begin(), drop.readings.end(),
                                 [](const FwdReading& r) { return std::abs(r.offset_mm) < centre_tolerance_mm; });
    return at == drop.readings.end() ? nullptr : &*at;
}

// Deflection at the centre over pressure; not a number without one.
double compliance(const FwdDrop& drop) {
    const FwdReading* centre = centre_of(drop);
    return centre == nullptr || centre->deflection_um <= 0.0 ? NAN : centre->deflection_um / drop.pressure_kPa;
}

bool are_one_level(double a, double b) {
    return std::min(a, b) >= same_level * std::max(a, b);
}

void add(std::vector<LevelReading>& readings, const LevelReading& r) {
    if (!readings.empty() && readings.back().drop == r.drop) {
        readings.back().um = (readings.back().um + r.um) / 2.0;
        readings.back().read_um = (readings.back().read_um + r.read_um) / 2.0;
    } else {
        readings.push_back(r);
    }
}

bool read_the_same(const Level& a, const Level& b) {
    constexpr double same = 0.05;   // of the middle sensor's logarithm, and
    constexpr double as_well = 0.1; // of all others'
    const LevelCompliance of_a = compliance_of(readings_of(a), 1.0);
    const LevelCompliance of_b = compliance_of(readings_of(b), 1.0);
    std::vector<double> apart;
    for (const auto& [offset, value] : of_a) {
        if (const auto at = of_b.find(offset); at != of_b.end()) {
            apart.push_back(std::abs(value - at->second));
        }
    }
    constexpr std::size_t sensors = 3;
    return apart.size() >= sensors && median(apart) < same &&
           std::all_of(apart.begin(), apart.end(), [&](double d) { return d < as_well; });
}

} // namespace

LevelReadings readings_of(const Level& level) {
    const double pressure_kPa = pressure_of(level);
    LevelReadings read;
    for (const FwdDrop* d : level) {
        for (const FwdReading& r : d->readings) {
            if (std::isfinite(r.deflection_um)) {
                add(read[place_of(r)],
                    {d->number, r.deflection_um * (pressure_kPa / d->pressure_kPa), r.deflection_um});
            }
        }
    }
    return read;
}

std::vector<MisreadLoad> take_out_misread_loads(std::vector<Level>& levels) {
    constexpr double other = 0.2; // of the pressure's logarithm
    std::vector<MisreadLoad> out;
    for (auto level = levels.begin(); level != levels.end();) {
        const auto twin = std::find_if(levels.begin(), levels.end(), [&](const Level& known) {
            return known.size() > level->size() && known.size() >= 2 &&
                   std::abs(std::log(pressure_of(known) / pressure_of(*level))) > other && read_the_same(*level, known);
        });
        if (twin == levels.end()) {
            ++level;
            continue;
        }
        out.push_back({*level, *twin});
        level = levels.erase(level);
    }
    return out;
}

double place_of(const FwdReading& reading) {
    return std::abs(reading.offset_mm) < centre_tolerance_mm ? 0.0 : reading.offset_mm;
}

bool first_is_seating(const std::vector<const FwdDrop*>& drops, bool first_of_two_seats, double scatter,
                      double resolution_um) {
    if (drops.size() < 3) {
        return drops.size() == 2 && first_of_two_seats &&
               !are_one_level(drops[0]->pressure_kPa, drops[1]->pressure_kPa);
    }
    const double first = drops[0]->pressure_kPa;
    const auto rest = std::vector<const FwdDrop*>(drops.begin() + 1, drops.end());
    const bool alone =
        std::none_of(rest.begin(), rest.end(), [&](const FwdDrop* d) { return are_one_level(first, d->pressure_kPa); });
    if (alone) {
        for (std::size_t i = 0; i < rest.size(); ++i) {
            for (std::size_t k = i + 1; k < rest.size(); ++k) {
                if (are_one_level(rest[i]->pressure_kPa, rest[k]->pressure_kPa)) {
                    return true;
                }
            }
        }
        return false;
    }
    std::vector<double> repeats;
    for (const FwdDrop* d : rest) {
        if (are_one_level(first, d->pressure_kPa)) {
            repeats.push_back(compliance(*d));
        }
    }
    if (repeats.size() < 2 || std::any_of(repeats.begin(), repeats.end(), [](double c) { return std::isnan(c); })) {
        return false;
    }
    const double middle = median(repeats);
    const bool agree = std::all_of(repeats.begin(), repeats.end(),
                                   [&](double c) { return std::abs(c / middle - 1.0) <= repeats_agree; });
    const double rounding = rounded_apart * resolution_um / (middle * first);
    const double differs = std::max(seating_differs, seating_scatter * scatter) + rounding;
    return agree && std::abs(compliance(*drops[0]) / middle - 1.0) > differs;
}

std::vector<Level> levels_of(std::vector<const FwdDrop*> drops) {
    std::stable_sort(drops.begin(), drops.end(),
                     [](const FwdDrop* a, const FwdDrop* b) { return a->pressure_kPa > b->pressure_kPa; });
    std::vector<Level> levels;
    for (const FwdDrop* d : drops) {
        if (levels.empty() || d->pressure_kPa < same_level * levels.back()[0]->pressure_kPa) {
            levels.emplace_back();
        }
        levels.back().push_back(d);
    }
    for (Level& level : levels) {
        std::sort(level.begin(), level.end()); // addresses in one vector
    }
    std::reverse(levels.begin(), levels.end());
    return levels;
}

double pressure_of(const Level& level) {
    std::vector<double> pressures;
    for (const FwdDrop* d : level) {
        pressures.push_back(d->pressure_kPa);
    }
    return median(pressures);
}

} // namespace explore::data

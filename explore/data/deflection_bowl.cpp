#include "data/deflection_bowl.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>

namespace explore::data {
namespace {

constexpr double same_level = 0.9; // of the highest pressure
constexpr double resolution_um = 2.0;

// What is wrong with the station or with the load of a drop, or "".
std::string complaint_of(const FwdStation& station) {
    if (!station.unusable.empty()) {
        return station.unusable;
    }
    std::set<int> numbers;
    for (const FwdDrop& d : station.drops) {
        if (!(d.pressure_kPa > 0.0 && std::isfinite(d.pressure_kPa))) {
            return fmt::format("drop {}: a pressure of {:g} kPa", d.number, d.pressure_kPa);
        }
        if (!(d.radius_mm > 0.0 && std::isfinite(d.radius_mm))) {
            return fmt::format("drop {}: a plate of radius {:g} mm", d.number, d.radius_mm);
        }
        if (d.radius_mm != station.drops[0].radius_mm) {
            return fmt::format("plates of radius {:g} and {:g} mm", station.drops[0].radius_mm, d.radius_mm);
        }
        if (!numbers.insert(d.number).second) {
            return fmt::format("drop {} stands twice", d.number);
        }
    }
    return {};
}

void add_d250(DeflectionBowl& bowl) {
    const auto& r = bowl.readings;
    const auto above =
        std::find_if(r.begin(), r.end(), [](const FwdReading& x) { return x.offset_mm >= ratio_offset_mm; });
    if (above == r.end() || above == r.begin()) {
        return;
    }
    if (above->offset_mm == ratio_offset_mm) {
        bowl.d250_um = above->deflection_um;
        return;
    }
    const FwdReading& below = *(above - 1);
    if (below.offset_mm <= bowl.radius_mm) {
        return;
    }
    const double t = (ratio_offset_mm - below.offset_mm) / (above->offset_mm - below.offset_mm);
    bowl.d250_um = below.deflection_um * std::pow(above->deflection_um / below.deflection_um, t);
    bowl.d250_is_interpolated = true;
}

} // namespace

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2.0;
}

pave::Outcome<DeflectionBowl> bowl_of(const FwdStation& station) {
    const auto rejected = [](std::string reason) { return pave::Failure{.reason = std::move(reason)}; };
    if (const std::string complaint = complaint_of(station); !complaint.empty()) {
        return rejected(complaint);
    }
    double highest = 0.0;
    for (const FwdDrop& d : station.drops) {
        highest = std::max(highest, d.pressure_kPa);
    }
    std::vector<const FwdDrop*> counted;
    std::vector<double> pressures;
    DeflectionBowl bowl;
    for (const FwdDrop& d : station.drops) {
        if (d.pressure_kPa >= same_level * highest) {
            counted.push_back(&d);
            pressures.push_back(d.pressure_kPa);
            bowl.drops.push_back(d.number);
        }
    }
    bowl.radius_mm = station.drops[0].radius_mm;
    bowl.pressure_kPa = median(pressures);
    std::map<double, std::vector<double>> scaled; // by offset
    for (const FwdDrop* d : counted) {
        for (const FwdReading& r : d->readings) {
            if (!(r.deflection_um > 0.0 && std::isfinite(r.deflection_um))) {
                return rejected(fmt::format("drop {}: a deflection of {:g} um at {:g} mm", d->number, r.deflection_um,
                                            r.offset_mm));
            }
            scaled[r.offset_mm].push_back(r.deflection_um * (bowl.pressure_kPa / d->pressure_kPa));
        }
    }
    for (const auto& [offset, deflections] : scaled) {
        bowl.readings.push_back({offset, median(deflections)});
    }
    if (bowl.readings.empty() || bowl.readings[0].offset_mm != 0.0) {
        return rejected("no reading at the centre of the load (D0)");
    }
    for (std::size_t i = 1; i < bowl.readings.size(); ++i) {
        const FwdReading& inner = bowl.readings[i - 1];
        const FwdReading& outer = bowl.readings[i];
        if (outer.deflection_um > inner.deflection_um + resolution_um) {
            return rejected(fmt::format("the deflection rises from {:.0f} um at {:g} mm to {:.0f} um at {:g} mm",
                                        inner.deflection_um, inner.offset_mm, outer.deflection_um, outer.offset_mm));
        }
    }
    add_d250(bowl);
    return bowl;
}

} // namespace explore::data

#include "data/plausibility.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace explore::data {
namespace {

struct Range {
    double low, high;
    bool holds(double value) const { return value >= low && value <= high; }
};
// What can be, and what is common: a slip is named when it leads to the latter.
constexpr Range radius_mm{40.0, 250.0}, common_radius_mm{90.0, 230.0};
constexpr Range pressure_kPa{20.0, 4000.0}, common_pressure_kPa{200.0, 2000.0};
constexpr Range centre_um{5.0, 1e4}, common_centre_um{50.0, 3000.0};
constexpr Range surface_modulus_MPa{1.0, 1e5};
constexpr Range farthest_mm{0.0, 4000.0}, common_farthest_mm{600.0, 3000.0};
constexpr double nearest_farthest_mm = 250.0; // of four sensors or more

struct Slip {
    std::string_view words;
    double factor; // what was meant over what stands there
};

// "kgf or lbf in a kN column?": those that lead to a common value, the nearest to the middle of the range first.
std::string question(double value, std::vector<Slip> slips, Range common, std::string_view place) {
    slips.erase(
        std::remove_if(slips.begin(), slips.end(), [&](const Slip& s) { return !common.holds(value * s.factor); }),
        slips.end());
    const double middle = std::sqrt(common.low * common.high);
    const auto distance = [&](const Slip& s) { return std::abs(std::log(value * s.factor / middle)); };
    std::stable_sort(slips.begin(), slips.end(),
                     [&](const Slip& a, const Slip& b) { return distance(a) < distance(b); });
    std::vector<std::string> words;
    words.reserve(slips.size());
    for (const Slip& slip : slips) {
        words.emplace_back(slip.words);
    }
    return words.empty() ? "" : fmt::format(": {}{}?", pave::join(words, " or "), place);
}

std::string implausible_plate(const FwdDrop& drop) {
    if (radius_mm.holds(drop.radius_mm)) {
        return {};
    }
    if (!std::isfinite(drop.radius_mm)) {
        return "the radius of the plate is not stated";
    }
    return fmt::format("a plate of radius {:g} mm{}", drop.radius_mm,
                       question(drop.radius_mm,
                                {{"radius in m", 1e3},
                                 {"radius (or diameter) in m", 0.5e3},
                                 {"radius in cm", 10.0},
                                 {"diameter in cm", 5.0},
                                 {"radius in inches", 25.4},
                                 {"diameter in inches", 12.7},
                                 {"the diameter in place of the radius", 0.5}},
                                common_radius_mm, ""));
}

std::string implausible_pressure(const FwdDrop& drop) {
    const double kPa = drop.pressure_kPa;
    if (pressure_kPa.holds(kPa)) {
        return {};
    }
    if (!std::isfinite(kPa)) {
        return "its load was not measured";
    }
    if (drop.force_kN) {
        // The number itself may be a pressure.
        const double as_pressure = std::numbers::pi * drop.radius_mm * drop.radius_mm * 1e-6;
        return fmt::format("a pressure of {:g} kPa ({:g} kN on this plate){}", kPa, *drop.force_kN,
                           question(kPa,
                                    {{"kgf", 9.80665e-3},
                                     {"lbf", 4.4482216e-3},
                                     {"N", 1e-3},
                                     {"kPa", as_pressure},
                                     {"kips", 4.4482216},
                                     {"tonnes", 9.80665}},
                                    common_pressure_kPa, " in a kN column"));
    }
    const double as_force = 1e6 / (std::numbers::pi * drop.radius_mm * drop.radius_mm);
    return fmt::format(
        "a pressure of {:g} kPa{}", kPa,
        question(
            kPa,
            {{"MPa", 1e3}, {"psi", 6.894757}, {"bar", 100.0}, {"kgf/cm2", 98.0665}, {"Pa", 1e-3}, {"kN", as_force}},
            common_pressure_kPa, " in a kPa column"));
}

std::string implausible_deflection(double um, std::string_view where) {
    if (centre_um.holds(um)) {
        return {};
    }
    return fmt::format(
        "a deflection of {:g} um {}{}", um, where,
        um > centre_um.high
            ? question(um, {{"micrometres", 1e-3}, {"mils", 0.0254}, {"hundredths of a mm", 0.01}}, common_centre_um,
                       " in a _mm column")
            : question(um, {{"millimetres", 1e3}, {"mils", 25.4}}, common_centre_um, " in a _um column"));
}

} // namespace

std::string implausible(const FwdDrop& drop) {
    if (auto words = implausible_plate(drop); !words.empty()) {
        return words;
    }
    if (auto words = implausible_pressure(drop); !words.empty()) {
        return words;
    }
    double farthest = 0.0;
    for (const FwdReading& r : drop.readings) {
        farthest = std::max(farthest, std::abs(r.offset_mm));
    }
    if (!farthest_mm.holds(farthest) || (drop.readings.size() >= 4 && farthest < nearest_farthest_mm)) {
        return fmt::format("the farthest sensor at {:g} mm{}", farthest,
                           question(farthest,
                                    {{"offsets in cm", 10.0}, {"offsets in inches", 25.4}, {"offsets in m", 1e3}},
                                    common_farthest_mm, ""));
    }
    for (const FwdReading& r : drop.readings) {
        // A sensor that reads nothing is dead, which costs that reading alone: deflection_bowl.h.
        if (r.offset_mm == 0.0 && r.deflection_um >= 0.1) {
            if (auto words = implausible_deflection(r.deflection_um, "at the centre"); !words.empty()) {
                return words;
            }
            const double modulus_MPa = 2.0 * (1.0 - 0.35 * 0.35) * drop.pressure_kPa * drop.radius_mm / r.deflection_um;
            if (!surface_modulus_MPa.holds(modulus_MPa)) {
                return fmt::format("{:g} um at the centre under {:g} kPa: the ground as a whole would have {:.3g} MPa",
                                   r.deflection_um, drop.pressure_kPa, modulus_MPa);
            }
        }
    }
    return {};
}

} // namespace explore::data

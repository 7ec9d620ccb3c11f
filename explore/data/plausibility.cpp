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
// Possible and common values: a slip is named when it leads to the latter.
constexpr Range radius_mm{40.0, 250.0}, common_radius_mm{90.0, 230.0};
constexpr Range pressure_kPa{20.0, 4000.0}, common_pressure_kPa{200.0, 2000.0};
constexpr Range centre_um{5.0, 1e4}, common_centre_um{50.0, 3000.0};
constexpr Range surface_modulus_MPa{1.0, 1e5};
constexpr Range farthest_mm{0.0, 4000.0}, common_farthest_mm{600.0, 3000.0};
constexpr double nearest_farthest_mm = 250.0; // of four sensors or more
constexpr double common_force_kN = 20.0;
constexpr double common_ground_MPa = 1000.0;
constexpr double live_um = 1.0; // what a live sensor reads

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

// The pressure with the slips that lead to a common one.
std::string pressure_words(const FwdDrop& drop) {
    const double kPa = drop.pressure_kPa;
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

std::string implausible_pressure(const FwdDrop& drop) {
    if (pressure_kPa.holds(drop.pressure_kPa)) {
        return {};
    }
    return std::isfinite(drop.pressure_kPa) ? pressure_words(drop) : "its load was not measured";
}

// The slips that make a small deflection, or a large one, a common one.
std::string deflection_question(double um, Range common) {
    return um > std::sqrt(common.low * common.high)
               ? question(um, {{"micrometres", 1e-3}, {"mils", 0.0254}, {"hundredths of a mm", 0.01}}, common,
                          " in a _mm column")
               : question(um,
                          {{"millimetres in a _um column", 1e3},
                           {"mils in a _um column or inches in a _mm column", 25.4},
                           {"hundredths of a mm in a _um column", 10.0}},
                          common, "");
}

std::string implausible_deflection(double um, std::string_view where) {
    if (centre_um.holds(um)) {
        return {};
    }
    return fmt::format("a deflection of {:g} um {}{}", um, where, deflection_question(um, common_centre_um));
}

// Away from the centre one reading that cannot be is a sensor's, several are a slip.
std::string implausible_others(const FwdDrop& drop) {
    double largest = 0.0;
    double live = 0.0; // the largest of those that are no more than what dead sensors read
    std::size_t others = 0;
    std::size_t beyond = 0;
    std::size_t faint = 0;
    double centre = 0.0;
    for (const FwdReading& r : drop.readings) {
        if (r.offset_mm == 0.0) {
            centre = r.deflection_um;
            continue;
        }
        ++others;
        beyond += r.deflection_um > centre_um.high ? 1 : 0;
        largest = std::max(largest, r.deflection_um);
        if (r.deflection_um < live_um && r.deflection_um > 0.0) {
            ++faint;
            live = std::max(live, r.deflection_um);
        }
    }
    if (beyond >= 2) {
        return fmt::format("{} deflections beyond 10 mm, {:g} um the largest{}", beyond, largest,
                           deflection_question(largest, common_centre_um));
    }
    if (faint >= 2 && faint == others && centre_um.holds(centre) && live * 1e3 <= centre) {
        return fmt::format("{:g} um at the centre and no more than {:g} um at {} other sensors{}", centre, live, faint,
                           deflection_question(live, common_centre_um));
    }
    return {};
}

// The lowest surface modulus from two radii on, in MPa: that of the ground far down. Infinite without readings there.
double ground_modulus_MPa(const FwdDrop& drop) {
    double lowest = INFINITY;
    for (const FwdReading& r : drop.readings) {
        if (r.offset_mm >= 2.0 * drop.radius_mm && r.deflection_um >= live_um) {
            lowest = std::min(lowest, (1.0 - 0.35 * 0.35) * drop.pressure_kPa * drop.radius_mm * drop.radius_mm /
                                          (r.offset_mm * r.deflection_um));
        }
    }
    return lowest;
}

// A light deflectometer: little load (7.07 kN on 300 mm are 100 kPa, its standard) and no sensor but the centre.
bool is_light(const FwdDrop& drop) {
    constexpr Range light_kPa{40.0, 200.0};
    return light_kPa.holds(drop.pressure_kPa) && std::all_of(drop.readings.begin(), drop.readings.end(),
                                                             [](const FwdReading& r) { return r.offset_mm == 0.0; });
}

std::string offsets_question(double farthest_mm) {
    return question(farthest_mm, {{"offsets in cm", 10.0}, {"offsets in inches", 25.4}, {"offsets in m", 1e3}},
                    common_farthest_mm, "");
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
        return fmt::format("the farthest sensor at {:g} mm{}", farthest, offsets_question(farthest));
    }
    for (const FwdReading& r : drop.readings) {
        // A sensor that reads nothing is dead, which costs that reading alone: deflection_bowl.h.
        const bool is_alone = std::any_of(drop.readings.begin(), drop.readings.end(), [&](const FwdReading& other) {
            return other.deflection_um > 4.0 * std::max(r.deflection_um, centre_um.low) &&
                   other.deflection_um <= centre_um.high;
        });
        if (r.offset_mm == 0.0 && r.deflection_um >= 0.1 && !is_alone) {
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
    return implausible_others(drop);
}

std::string doubtful(const FwdDrop& drop) {
    // A question ends it: without a slip that explains it there is nothing to ask.
    const auto asked = [](const std::string& words) { return words.ends_with('?') ? words : std::string(); };
    const double kPa = drop.pressure_kPa;
    if (!common_radius_mm.holds(drop.radius_mm)) {
        // A light deflectometer has a small plate and little pressure.
        const double as_radius = kPa / 4.0;
        if (drop.force_kN && *drop.force_kN >= common_force_kN && common_pressure_kPa.holds(as_radius)) {
            return fmt::format("a plate of radius {:g} mm under {:g} kN ({:.0f} kPa): the radius in place of the "
                               "diameter?",
                               drop.radius_mm, *drop.force_kN, kPa);
        }
    } else if (!common_pressure_kPa.holds(kPa) && !is_light(drop) &&
               (kPa > common_pressure_kPa.high ||
                kPa * std::numbers::pi * drop.radius_mm * drop.radius_mm * 1e-6 < common_force_kN)) {
        if (auto words = asked(pressure_words(drop)); !words.empty()) {
            return words;
        }
    }
    double farthest = 0.0;
    for (const FwdReading& r : drop.readings) {
        farthest = std::max(farthest, std::abs(r.offset_mm));
    }
    if (drop.readings.size() >= 3 && farthest < nearest_farthest_mm) {
        if (auto words = asked(fmt::format("the farthest sensor at {:g} mm{}", farthest, offsets_question(farthest)));
            !words.empty()) {
            return words;
        }
    }
    const auto centre = std::find_if(drop.readings.begin(), drop.readings.end(),
                                     [](const FwdReading& r) { return r.offset_mm == 0.0; });
    if (centre == drop.readings.end()) {
        return {};
    }
    const double um = centre->deflection_um;
    if (um > common_centre_um.high) {
        return asked(
            fmt::format("a deflection of {:g} um at the centre{}", um, deflection_question(um, common_centre_um)));
    }
    const double ground = ground_modulus_MPa(drop);
    return std::isfinite(ground) && ground > common_ground_MPa
               ? asked(fmt::format("{:g} um at the centre under {:.0f} kPa, ground of {:.0f} MPa or more{}", um, kPa,
                                   ground, deflection_question(um, {60.0, common_centre_um.high})))
               : "";
}

} // namespace explore::data

#include "data/structural_number.h"

#include <cmath>
#include <numbers>

namespace explore::data {
namespace {

constexpr double mm_per_inch = 25.4;
constexpr double MPa_per_psi = 0.0068947572931683613;

// um, for moduli in MPa, lengths in mm and a pressure in kPa.
double deflection_um(double pavement, double subgrade, double pressure_kPa, double a, double h) {
    const double ratio = h / a;
    const double below =
        1.0 / (subgrade * std::sqrt(1.0 + ratio * ratio * std::cbrt(std::pow(pavement / subgrade, 2))));
    const double within = (1.0 - 1.0 / std::sqrt(1.0 + ratio * ratio)) / pavement;
    return 1.5 * pressure_kPa * a * (below + within);
}

// D0 falls as E_p rises: by bisection of its logarithm.
std::optional<double> pavement_modulus(double measured_um, double subgrade, double pressure_kPa, double a, double h) {
    double low = std::log(1.0);
    double high = std::log(1e6);
    const auto excess = [&](double log_modulus) {
        return deflection_um(std::exp(log_modulus), subgrade, pressure_kPa, a, h) - measured_um;
    };
    if (!(excess(low) > 0.0 && excess(high) < 0.0)) {
        return std::nullopt;
    }
    while (high - low > 1e-12) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0.0 ? low : high) = middle;
    }
    return std::exp(0.5 * (low + high));
}

} // namespace

std::optional<StructuralNumber> structural_number(const DeflectionBowl& bowl, double thickness_mm,
                                                  std::optional<double> d0_um) {
    constexpr double far_enough = 0.7; // of a_e
    const double a = bowl.radius_mm;
    const double force_N = bowl.pressure_kPa * std::numbers::pi * a * a / 1e3;
    for (const BowlReading& r : bowl.readings) {
        if (!(r.offset_mm > 0.0 && r.deflection_um > 0.0)) {
            continue;
        }
        const double subgrade = 0.24 * force_N / (r.offset_mm * r.deflection_um / 1e3);
        const auto pavement =
            pavement_modulus(d0_um.value_or(bowl.d0_um()), subgrade, bowl.pressure_kPa, a, thickness_mm);
        if (pavement && r.offset_mm >= far_enough * std::hypot(a, thickness_mm * std::cbrt(*pavement / subgrade))) {
            return StructuralNumber{.subgrade_MPa = subgrade,
                                    .pavement_MPa = *pavement,
                                    .sn_eff = 0.0045 * thickness_mm / mm_per_inch * std::cbrt(*pavement / MPa_per_psi),
                                    .offset_mm = r.offset_mm};
        }
    }
    return std::nullopt;
}

} // namespace explore::data

// Criteria of design guides: how many repetitions of an axle a pavement stands, by a strain under it. One entry each.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace pave::pavement {

// Where a criterion looks, and what for.
enum class CriticalPlace {
    asphalt_bottom, // largest horizontal tension at the bottom of a bound layer
    subgrade_top,   // largest vertical compression at the top of a layer
    plate           // deflections of the surface under a plate
};
inline constexpr std::string_view critical_place_names[] = {"asphalt-bottom", "subgrade-top", "plate"};

// A number of a criterion as it stands in a study.
struct CriterionOption {
    std::string_view key;
    double low = 0.0, high = 0.0;
    std::optional<double> default_value; // none: must be given
    std::string_view meaning;
};

// The arguments of a criterion.
struct CriterionState {
    double strain = 0.0;               // microstrain, positive as its place says
    double modulus_MPa = 0.0;          // of the bound layer
    std::span<const double> options{}; // in the order of the criterion's
    // Of a plate:
    double centre_mm = 0.0, far_mm = 0.0; // deflections at the centre and at the distance
    double distance_mm = 0.0;
    double pressure_kPa = 0.0, radius_mm = 0.0;
    double cover_mm = 0.0; // thickness above the subgrade
};

struct CriterionLaw {
    std::string_view name;
    std::string_view failure; // that it counts to
    CriticalPlace place = CriticalPlace::subgrade_top;
    std::string_view formula; // N repetitions, e microstrain, E MPa
    std::string_view source;
    double least = 0.0, most = 0.0; // repetitions between which the guide uses it; beyond, it is extrapolated
    bool reads_modulus = false;
    std::span<const CriterionOption> options{};
    // Natural logarithm of the allowable repetitions; infinity where the strain is none of this sign.
    double (*log_repetitions)(const CriterionState&) = nullptr;
};

std::span<const CriterionLaw> criterion_laws();

// Of a flexible pavement by AASHTO 1993 (part II, 2.3.1): log10 of the 80 kN axles.
// deviate: of the normal distribution at the reliability, negative; modulus_psi: of the roadbed soil.
double aashto_log10_axles(double structural_number, double modulus_psi, double deviate, double deviation,
                          double serviceability_loss);

} // namespace pave::pavement

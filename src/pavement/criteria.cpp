#include "pavement/criteria.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace pave::pavement {
namespace {

constexpr double psi_a_MPa = 145.0377377;
constexpr double mm_an_inch = 25.4;
constexpr double never = std::numeric_limits<double>::infinity();

// ln(factor * (e 1e-6)^-power), e in microstrain.
double power_law(double strain, double log_factor, double power) {
    return strain > 0.0 ? log_factor - power * std::log(strain * 1e-6) : never;
}

constexpr CriterionOption binder{.key = "binder_volume_percent",
                                 .low = 1.0,
                                 .high = 40.0,
                                 .default_value = 11.0,
                                 .meaning = "volume of the binder in the mix"};
constexpr CriterionOption voids{
    .key = "air_voids_percent", .low = 0.1, .high = 30.0, .default_value = 4.5, .meaning = "air voids of the mix"};
constexpr std::array binder_alone{binder};
constexpr std::array binder_and_voids{binder, voids};

// Shell Pavement Design Manual (1978): e = (0.856 Vb + 1.08) E^-0.36 N^-0.2, e as a ratio, E in Pa.
double shell_fatigue(const CriterionState& s) {
    if (!(s.strain > 0.0)) {
        return never;
    }
    return 5.0 *
           (std::log(0.856 * s.options[0] + 1.08) - 0.36 * std::log(s.modulus_MPa * 1e6) - std::log(s.strain * 1e-6));
}

// Its subgrade: e = c N^-0.25.
template <int c_in_1000>
double shell_subgrade(const CriterionState& s) {
    return power_law(s.strain, 4.0 * std::log(1e-3 * c_in_1000), 4.0);
}

// No worked example of the guide is openly printed: tested against Shell's law, which it is, and by hand.
// AGPT02-17 table of reliability factors for asphalt fatigue, and a shift factor of 6 from laboratory to road.
double austroads_reliability_factor(double percent) {
    constexpr std::array<std::pair<double, double>, 6> table{
        {{50.0, 1.0}, {80.0, 2.4}, {85.0, 3.0}, {90.0, 3.9}, {95.0, 6.0}, {97.5, 9.0}}};
    for (std::size_t i = 1; i < table.size(); ++i) {
        if (percent <= table[i].first) {
            const double t = (percent - table[i - 1].first) / (table[i].first - table[i - 1].first);
            return std::exp((1.0 - t) * std::log(table[i - 1].second) + t * std::log(table[i].second));
        }
    }
    return table.back().second;
}

double austroads_fatigue(const CriterionState& s) {
    constexpr double shift = 6.0;
    if (!(s.strain > 0.0)) {
        return never;
    }
    return std::log(shift / austroads_reliability_factor(s.options[1])) +
           5.0 *
               (std::log(6918.0 * (0.856 * s.options[0] + 1.08)) - 0.36 * std::log(s.modulus_MPa) - std::log(s.strain));
}

double austroads_subgrade(const CriterionState& s) {
    return s.strain > 0.0 ? 7.0 * std::log(9150.0 / s.strain) : never;
}

// ln C of C = 10^M, M = 4.84 (Vb/(Va + Vb) - 0.69).
double log_volumetric(double binder_percent, double voids_percent) {
    return std::log(10.0) * 4.84 * (binder_percent / (voids_percent + binder_percent) - 0.69);
}

double asphalt_institute_fatigue(const CriterionState& s) {
    return power_law(s.strain, std::log(18.4 * 0.004325) + log_volumetric(s.options[0], s.options[1]), 3.291) -
           0.854 * std::log(s.modulus_MPa * psi_a_MPa);
}

double asphalt_institute_rutting(const CriterionState& s) {
    return power_law(s.strain, std::log(1.365e-9), 4.477);
}

double irc_fatigue(const CriterionState& s, double factor) {
    return power_law(s.strain, std::log(factor) + log_volumetric(s.options[0], s.options[1]), 3.89) -
           0.854 * std::log(s.modulus_MPa);
}

// e = factor eps6 (N/10^6)^-slope. No worked example of the standard is openly printed: tested by hand.
double french_fatigue(const CriterionState& s) {
    return s.strain > 0.0 ? std::log(1e6) - (std::log(s.strain) - std::log(s.options[0] * s.options[2])) / s.options[1]
                          : never;
}

double french_subgrade(const CriterionState& s) {
    return s.strain > 0.0 ? std::log(s.options[0] / s.strain) / 0.222 : never;
}

// Inverse of the normal distribution by bisection.
double normal_deviate(double probability) {
    double low = -8.0;
    double high = 8.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2.0;
        (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
    }
    return (low + high) / 2.0;
}

// AASHTO 1993, part III, 5.4.5: the modulus of the soil from a far deflection, that of all above it from the centre's,
// SN = 0.0045 D Ep^(1/3).
double aashto_by_plate(const CriterionState& s) {
    if (!(s.centre_mm > 0.0 && s.far_mm > 0.0)) {
        return never;
    }
    const double radius = s.radius_mm;
    const double force = s.pressure_kPa * 1e-3 * 3.14159265358979 * radius * radius; // N
    const double soil = 0.24 * force / (s.far_mm * s.distance_mm);                   // MPa
    const double ratio = s.cover_mm / radius;
    const auto centre = [&](double above) { // mm
        const double stiff = ratio * std::cbrt(above / soil);
        return 1.5e-3 * s.pressure_kPa * radius *
               (1.0 / (soil * std::sqrt(1.0 + stiff * stiff)) + (1.0 - 1.0 / std::sqrt(1.0 + ratio * ratio)) / above);
    };
    double low = std::log(1e-1);
    double high = std::log(1e6);
    for (int i = 0; i < 80; ++i) {
        const double middle = (low + high) / 2.0;
        (centre(std::exp(middle)) > s.centre_mm ? low : high) = middle;
    }
    const double above_psi = std::exp((low + high) / 2.0) * psi_a_MPa;
    const double number = 0.0045 * s.cover_mm / mm_an_inch * std::cbrt(above_psi);
    return std::log(10.0) * aashto_log10_axles(number, s.options[3] * soil * psi_a_MPa,
                                               normal_deviate(1.0 - 0.01 * s.options[0]), s.options[1], s.options[2]);
}

constexpr CriterionOption reliability{.key = "reliability_percent",
                                      .low = 50.0,
                                      .high = 97.5,
                                      .default_value = 95.0,
                                      .meaning = "of the guide's own law"};
constexpr std::array binder_and_reliability{binder, reliability};
constexpr std::array french_mix{
    CriterionOption{.key = "epsilon_6_microstrain",
                    .low = 10.0,
                    .high = 1000.0,
                    .default_value = {},
                    .meaning = "strain that the mix stands a million times, at the temperature and frequency meant"},
    CriterionOption{
        .key = "slope", .low = 0.05, .high = 0.5, .default_value = 0.2, .meaning = "-b of the fatigue line"},
    CriterionOption{.key = "factor",
                    .low = 0.1,
                    .high = 10.0,
                    .default_value = 1.0,
                    .meaning = "kr kc ks (E(10)/E(T))^0.5 of the standard"}};
constexpr std::array french_soil{CriterionOption{.key = "constant_microstrain",
                                                 .low = 1000.0,
                                                 .high = 100000.0,
                                                 .default_value = 12000.0,
                                                 .meaning = "A; 16000 for light traffic"}};
constexpr std::array aashto_design{
    CriterionOption{.key = "reliability_percent",
                    .low = 50.0,
                    .high = 99.99,
                    .default_value = 95.0,
                    .meaning = "of the guide's own law"},
    CriterionOption{.key = "overall_deviation", .low = 0.0, .high = 1.0, .default_value = 0.45, .meaning = "S0"},
    CriterionOption{.key = "serviceability_loss",
                    .low = 0.1,
                    .high = 4.0,
                    .default_value = 1.7,
                    .meaning = "loss of PSI at the end"},
    CriterionOption{.key = "soil_factor",
                    .low = 0.05,
                    .high = 1.0,
                    .default_value = 0.33,
                    .meaning = "design modulus of the soil over the one of the deflections"},
    CriterionOption{.key = "distance_mm",
                    .low = 100.0,
                    .high = 5000.0,
                    .default_value = 900.0,
                    .meaning = "from the centre of the plate, where the deflection tells the soil"}};

constexpr double fewest = 1e4; // of fatigue and rutting lines as they are drawn, where a guide says no more
constexpr double most = 1e9;

} // namespace

double aashto_log10_axles(double structural_number, double modulus_psi, double deviate, double deviation,
                          double serviceability_loss) {
    return deviate * deviation + 9.36 * std::log10(structural_number + 1.0) - 0.20 +
           std::log10(serviceability_loss / 2.7) / (0.40 + 1094.0 / std::pow(structural_number + 1.0, 5.19)) +
           2.32 * std::log10(modulus_psi) - 8.07;
}

std::span<const CriterionLaw> criterion_laws() {
    using enum CriticalPlace;
    static const std::array laws{
        CriterionLaw{"austroads-fatigue", "fatigue of the asphalt", asphalt_bottom,
                     "N = 6/RF (6918 (0.856 Vb + 1.08) / (E^0.36 e))^5",
                     "Austroads, Guide to Pavement Technology Part 2 (AGPT02-17)", 1e5, most, true,
                     binder_and_reliability, austroads_fatigue},
        CriterionLaw{"austroads-subgrade",
                     "permanent deformation of the subgrade",
                     subgrade_top,
                     "N = (9150 / e)^7",
                     "Austroads, Guide to Pavement Technology Part 2 (AGPT02-17)",
                     1e5,
                     most,
                     false,
                     {},
                     austroads_subgrade},
        CriterionLaw{"asphalt-institute-fatigue", "fatigue of the asphalt (20 % cracked)", asphalt_bottom,
                     "N = 18.4 C 0.004325 (e 1e-6)^-3.291 (145.04 E)^-0.854, C = 10^(4.84 (Vb/(Va + Vb) - 0.69))",
                     "Asphalt Institute, MS-1, 9th edition (1982)", fewest, most, true, binder_and_voids,
                     asphalt_institute_fatigue},
        CriterionLaw{"asphalt-institute-rutting",
                     "rut of 12.7 mm",
                     subgrade_top,
                     "N = 1.365e-9 (e 1e-6)^-4.477",
                     "Asphalt Institute, MS-1, 9th edition (1982)",
                     fewest,
                     most,
                     false,
                     {},
                     asphalt_institute_rutting},
        CriterionLaw{"shell-fatigue", "fatigue of the asphalt", asphalt_bottom,
                     "N = ((0.856 Vb + 1.08) / ((1e6 E)^0.36 e 1e-6))^5", "Shell Pavement Design Manual (1978)", fewest,
                     most, true, binder_alone, shell_fatigue},
        CriterionLaw{"shell-subgrade-50",
                     "permanent deformation of the subgrade",
                     subgrade_top,
                     "N = (0.028 / (e 1e-6))^4",
                     "Shell Pavement Design Manual (1978), 50 % confidence",
                     fewest,
                     most,
                     false,
                     {},
                     shell_subgrade<28>},
        CriterionLaw{"shell-subgrade-85",
                     "permanent deformation of the subgrade",
                     subgrade_top,
                     "N = (0.021 / (e 1e-6))^4",
                     "Shell Pavement Design Manual, revision of 1985, 85 % confidence",
                     fewest,
                     most,
                     false,
                     {},
                     shell_subgrade<21>},
        CriterionLaw{"shell-subgrade-95",
                     "permanent deformation of the subgrade",
                     subgrade_top,
                     "N = (0.018 / (e 1e-6))^4",
                     "Shell Pavement Design Manual, revision of 1985, 95 % confidence",
                     fewest,
                     most,
                     false,
                     {},
                     shell_subgrade<18>},
        CriterionLaw{"irc37-fatigue-80", "fatigue of the bituminous layer (20 % cracked)", asphalt_bottom,
                     "N = 1.6064e-4 C (e 1e-6)^-3.89 E^-0.854, C = 10^(4.84 (Vb/(Va + Vb) - 0.69))",
                     "IRC:37-2018, 80 % reliability", 2e6, most, true, binder_and_voids,
                     [](const CriterionState& s) { return irc_fatigue(s, 1.6064e-4); }},
        CriterionLaw{"irc37-fatigue-90", "fatigue of the bituminous layer (20 % cracked)", asphalt_bottom,
                     "N = 0.5161e-4 C (e 1e-6)^-3.89 E^-0.854, C = 10^(4.84 (Vb/(Va + Vb) - 0.69))",
                     "IRC:37-2018, 90 % reliability", 2e6, most, true, binder_and_voids,
                     [](const CriterionState& s) { return irc_fatigue(s, 0.5161e-4); }},
        CriterionLaw{"irc37-rutting-80",
                     "rut of 20 mm",
                     subgrade_top,
                     "N = 4.1656e-8 (e 1e-6)^-4.5337",
                     "IRC:37-2018, 80 % reliability",
                     2e6,
                     most,
                     false,
                     {},
                     [](const CriterionState& s) { return power_law(s.strain, std::log(4.1656e-8), 4.5337); }},
        CriterionLaw{"irc37-rutting-90",
                     "rut of 20 mm",
                     subgrade_top,
                     "N = 1.41e-8 (e 1e-6)^-4.5337",
                     "IRC:37-2018, 90 % reliability",
                     2e6,
                     most,
                     false,
                     {},
                     [](const CriterionState& s) { return power_law(s.strain, std::log(1.41e-8), 4.5337); }},
        CriterionLaw{"french-fatigue", "fatigue of the asphalt", asphalt_bottom,
                     "N = 1e6 (e / (factor epsilon6))^(-1/slope)", "NF P98-086", fewest, most, false, french_mix,
                     french_fatigue},
        CriterionLaw{"french-subgrade", "permanent deformation of the subgrade", subgrade_top, "e = A N^-0.222",
                     "NF P98-086", fewest, most, false, french_soil, french_subgrade},
        CriterionLaw{"aashto-sn", "loss of serviceability", plate,
                     "log10 N = ZR S0 + 9.36 log10(SN + 1) - 0.20 + log10(dPSI/2.7) / (0.40 + 1094/(SN + 1)^5.19) + "
                     "2.32 log10 MR - 8.07; SN, MR from deflections",
                     "AASHTO Guide for Design of Pavement Structures (1993), II 2.3.1 and III 5.4.5", 5e4, 5e7, false,
                     aashto_design, aashto_by_plate},
    };
    return laws;
}

} // namespace pave::pavement

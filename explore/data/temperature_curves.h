// Deflections, their indices and the modulus of the asphalt, taken to another temperature of the asphalt by published
// curves. T and T_ref in degrees Celsius in the middle of the asphalt, d = D at 900 mm (36 in) in um under
// 40 kN on a plate of 150 mm, h: asphalt in mm, phi: latitude in degrees.
//
// fhwa   Lukanen, Stubstad and Briggs (2000), FHWA-RD-98-085, regressions of 40 sites of LTPP in North America:
//            lg dl_12 = 3.45 - 1.59 lg h + 0.489 lg phi + 0.449 lg d - 0.0275 T + 0.012 T lg h lg phi
//            lg dl_24 = 3.30 - 1.32 lg h + 0.514 lg phi lg d - 0.00622 T lg phi lg d + 0.00838 T lg h lg phi
//            lg dl_36 = 3.05 - 1.13 lg h + 0.502 lg phi lg d - 0.00487 T lg phi lg d + 0.00677 T lg h lg phi
//        of the differences dl of D0 and D at 12, 24 and 36 in (here 300, 600, 900 mm). A difference changes by
//        dl(T_ref)/dl(T), D0 by (d + dl_36(T_ref)) / (d + dl_36(T)). The modulus: modulus_factor().
// rws    what Rijkswaterstaat's reports of deflections use, for 20 C (the polynomials at T_ref over those at T
// elsewhere):
//            D0 / (1 + 0.013926 t + 0.0002298 t^2),  (D0 - D300) / (1 + 0.043535 t + 0.00098467 t^2),  t = T - 20
// irc    IRC:115-2014, 6.4, the modulus alone: E(T_ref) / E(T) = (1 - 0.238 ln T_ref) / (1 - 0.238 ln T)
#pragma once

#include "data/bowl_indices.h"

#include <array>
#include <string>
#include <string_view>

namespace explore::data {

enum class TemperatureCurve { fhwa, rws, irc };
struct TemperatureCurveWords {
    std::string_view name, source;
    double coldest_C, hottest_C; // that it is used for
};
inline constexpr std::array<TemperatureCurveWords, 3> temperature_curves = {{
    {"fhwa", "FHWA-RD-98-085", 0.0, 40.0},
    {"rws", "Rijkswaterstaat's polynomials", 0.0, 40.0},
    {"irc", "IRC:115-2014", 20.0, 45.0},
}};
constexpr const TemperatureCurveWords& words_of(TemperatureCurve curve) {
    return temperature_curves[static_cast<std::size_t>(curve)];
}

// Latitudes, north or south, of the sites of fhwa; the thickness that irc wants at least.
inline constexpr double fhwa_lowest_latitude = 25.0, fhwa_highest_latitude = 55.0;
inline constexpr double irc_thinnest_mm = 40.0;

struct WhereMeasured {
    double asphalt_C = 0.0;
    std::optional<double> asphalt_mm{}, latitude_deg{}; // nothing: not known
    std::optional<double> d900_um{};                    // d
};

struct IndicesAtReference {
    std::optional<double> d0_um{}, sci_um{}, bdi_um{}, bci_um{};
    std::string why_not{};                   // where the curve cannot give what it gives; "": it can
    std::vector<std::string> out_of_range{}; // what the curve was not made for, in words
};

// indices: at whatever pressure, as are those that come back.
IndicesAtReference indices_at(TemperatureCurve curve, double reference_C, const WhereMeasured& where,
                              const BowlIndices& indices);

// E(reference_C) / E(asphalt_C). rws: by the slope of fhwa, it has none of its own. Nothing: beyond all sense, where
// irc has no logarithm or no modulus left.
std::optional<double> modulus_factor_by(TemperatureCurve curve, double asphalt_C, double reference_C);

} // namespace explore::data

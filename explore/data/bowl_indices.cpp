#include "data/bowl_indices.h"

namespace explore::data {

BowlIndices indices_of(const DeflectionBowl& bowl, double pressure_kPa) {
    const double scale = pressure_kPa / bowl.pressure_kPa;
    const auto scaled = [&](double offset_mm) {
        const auto value = bowl.at(offset_mm);
        return value ? std::optional(scale * *value) : std::nullopt;
    };
    const auto d200 = scaled(200.0);
    const auto d300 = scaled(300.0);
    const auto d600 = scaled(600.0);
    const auto d900 = scaled(900.0);
    BowlIndices indices{.d0_um = scale * bowl.d0_um()};
    const double d0 = indices.d0_um;
    if (d300) {
        indices.sci_um = d0 - *d300;
    }
    if (d300 && d600) {
        indices.bdi_um = *d300 - *d600;
    }
    if (d600 && d900) {
        indices.bci_um = *d600 - *d900;
    }
    if (d300 && d600 && d900) {
        indices.area_mm = 150.0 * (1.0 + 2.0 * *d300 / d0 + 2.0 * *d600 / d0 + *d900 / d0);
    }
    if (d200 && *d200 < d0) {
        indices.curvature_radius_m = 0.2 * 0.2 / (2.0 * d0 * 1e-6 * (1.0 - *d200 / d0));
    }
    // kPa mm / um = MPa
    const double plane = 1.0 - surface_modulus_poisson * surface_modulus_poisson;
    const double a = bowl.radius_mm;
    indices.surface_moduli.push_back({0.0, 2.0 * plane * pressure_kPa * a / d0});
    constexpr double heaviest_light_kN = 20.0; // of light deflectometers
    if (bowl.readings.size() == 1 && bowl.force_kN() <= heaviest_light_kN) {
        indices.evd_MPa = 1.5 * pressure_kPa * a / d0;
    }
    for (const BowlReading& r : bowl.readings) {
        if (r.offset_mm >= 2.0 * a) {
            indices.surface_moduli.push_back(
                {r.offset_mm, plane * pressure_kPa * a * a / (r.offset_mm * scale * r.deflection_um)});
        }
    }
    return indices;
}

} // namespace explore::data

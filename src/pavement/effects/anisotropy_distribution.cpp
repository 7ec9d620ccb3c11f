// The modulus ratio n rises to 1 away from the load: n(r, z) = n + size (1 - n) w, w = 1 - exp(-(d/(a + z/2))^2) with d
// the horizontal distance to the axis of the nearest patch and a its half width.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

// shape: x of the patch at x >= 0, its half width.
double distance_from_load(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    const double d = std::hypot(std::abs(at[0]) - shape[0], at[1]);
    const double reach = shape[1] + at[2] / 2.0; // the load spreads at 1 in 2
    return -std::expm1(-d * d / (reach * reach));
}

void apply(Case& c, const AppliedEffect& applied, int load) {
    const Load::Footprint patch = c.loads[load].footprint();
    for (const std::size_t l : layers_named(c, applied.layer)) {
        c.layers[l].fields.push_back({.parameter = c.layers[l].law->index_of("n"),
                                      .target = 1.0,
                                      .size = applied.size,
                                      .weight = distance_from_load,
                                      .shape = {patch.centre, patch.half_x}});
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    return c.layers[layers_named(c, applied.layer).front()].law->index_of("n")
               ? ""
               : "the law of the layer has no modulus ratio n";
}

} // namespace

const Effect& anisotropy_distribution() {
    static const Effect effect{
        .name = "anisotropy-distribution",
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 1.0,
        .high_is_limit = true,
        .typical = 0.5,
        .mechanism =
            "Granular material is most anisotropic where the wheel shears it: n(r, z) = n + size (1 - n) w with "
            "w = 1 - exp(-(d/(a + z/2))^2), d the horizontal distance to the load and a its half width. Under the load "
            "the layer keeps n, far from it (size 1) it is isotropic.",
        .source = "figure 5 of Kathirgamanathan and Vignarajah; Tutumluer and Thompson (1997), TRR 1577",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("away from the load n rises by {} % of the way to 1", figure(100.0 * a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

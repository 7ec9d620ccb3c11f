// The subgrade stiffens with depth: E(z) = E0 (1 + size (z - top)).
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

double depth_below(const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
    return at[2] - shape[0];
}

void apply(Case& c, const AppliedEffect& applied, int) {
    const auto layers = layers_named(c, applied.layer);
    const double top = top_of(c, layers.front());
    for (const std::size_t l : layers) {
        c.layers[l].fields.push_back(
            {.parameter = {}, .target = 0.0, .size = applied.size, .weight = depth_below, .shape = {top}});
    }
}

} // namespace

const Effect& subgrade_depth_gradient() {
    static const Effect effect{
        .name = "subgrade-depth-gradient",
        .unit = "1/m",
        .null = 0.0,
        .low = 0.0,
        .high = 5.0,
        .typical = 0.5,
        .mechanism =
            "The weight of what lies above stiffens soil with depth: E(z) = E0 (1 + size (z - top of the layer)), "
            "evaluated at every Gauss point. Far deflections and deep strains shrink against near ones.",
        .source = "Gibson (1967), elastic solids whose modulus grows linearly with depth",
        .acts_on = "the subgrade",
        .layer = LayerRole::subgrade,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("a metre deeper the subgrade is {} times as stiff", figure(1.0 + a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The base is thicker than the study says; what lies below is thinner by as much, the floor stays.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    const std::size_t base = layers_named(c, applied.layer).back();
    // The last part of the layer below, where that one was divided.
    const std::size_t below = layers_named(c, c.layers[base + 1].name).back();
    c.layers[base].thickness += applied.size * unit::mm;
    c.layers[below].thickness -= applied.size * unit::mm;
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const std::size_t base = layers_named(c, applied.layer).back();
    return base + 1 < c.layers.size() ? "" : "nothing but the floor lies below the layer";
}

} // namespace

const Effect& base_thickness() {
    static const Effect effect{
        .name = "base-thickness",
        .unit = "mm",
        .null = 0.0,
        .low = -100.0,
        .high = 100.0,
        .typical = 20.0,
        .mechanism =
            "As built the base is thicker than designed by the size, at the cost of the layer below; the floor stays "
            "where it is. Gauges near the interface change most, for they may then lie in the other layer.",
        .source = "construction tolerances, e.g. Selezneva et al. (2002) on layer thickness variation in LTPP",
        .acts_on = "the base and the layer below it",
        .layer = LayerRole::base,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the base is {} mm {} than stated", figure(std::abs(a.size), 2),
                               a.size > 0.0 ? "thicker" : "thinner");
        },
    };
    return effect;
}

} // namespace pave::pavement

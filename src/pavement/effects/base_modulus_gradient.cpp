// The base is stiffer below than above, or the other way round: ln E varies evenly with depth, its mean stays.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    add_modulus_gradient(c, applied.layer, applied.size);
}

} // namespace

const Effect& base_modulus_gradient() {
    static const Effect effect{
        .name = "base-modulus-gradient",
        .unit = "-",
        .null = 0.0,
        .low = -2.0,
        .high = 2.0,
        .typical = -0.7,
        .mechanism =
            "Compaction reaches less where a soft subgrade gives way below, and trafficking or crushing changes the "
            "top first: the modulus is the law's times exp(size (zeta - 1/2)), zeta from 0 at the top of the layer to "
            "1 "
            "at its bottom. Strains move from one end of the layer to the other, deflections hardly change.",
        .source = "Heukelom and Klomp (1962): the modulus that compaction reaches is limited to 2 to 4 times that of "
                  "what lies below",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the base's modulus at its bottom is {} times that at its top",
                               figure(std::exp(a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

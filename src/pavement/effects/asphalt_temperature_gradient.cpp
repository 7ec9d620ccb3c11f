// The asphalt is warmer at the top than below, or colder: ln E varies evenly with depth, its mean stays.
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

const Effect& asphalt_temperature_gradient() {
    static const Effect effect{
        .name = "asphalt-temperature-gradient",
        .unit = "-",
        .null = 0.0,
        .low = -1.5,
        .high = 1.5,
        .typical = 0.6,
        .mechanism =
            "Sun and night leave the surface warmer or colder than the bottom of the asphalt, whose modulus falls by 4 "
            "to 5 % a degree: it is the stated one times exp(size (zeta - 1/2)), zeta from 0 at the top of the layer "
            "to "
            "1 at its bottom. A hot surface (size > 0) shifts the neutral axis down.",
        .source = "Lukanen, Stubstad and Briggs (2000), FHWA-RD-98-085: log10 E falls by about 0.02 a degree Celsius; "
                  "20 degrees through the layer make 0.9",
        .acts_on = "the asphalt",
        .layer = LayerRole::asphalt,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the asphalt's modulus at its bottom is {} times that at its top: a {} surface",
                               figure(std::exp(a.size), 2), a.size > 0.0 ? "hotter" : "colder");
        },
    };
    return effect;
}

} // namespace pave::pavement

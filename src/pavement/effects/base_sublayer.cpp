// A sublayer in the middle of the base, a third of its thickness or what a case says (at most four fifths), has
// E exp(size).
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    const std::size_t l = layers_named(c, applied.layer).front();
    const double whole = c.layers[l].thickness;
    const double thickness = std::min(applied.thickness.value_or(whole / 3.0), 0.8 * whole);
    Layer above = c.layers[l];
    above.thickness = (whole - thickness) / 2.0;
    above.compliance.reset();
    Layer sublayer = above;
    sublayer.thickness = thickness;
    scale_modulus(sublayer, std::exp(applied.size));
    c.layers[l].thickness = above.thickness; // what lies below it keeps the interface
    const auto at = c.layers.begin() + static_cast<std::ptrdiff_t>(l);
    c.layers.insert(at, {std::move(above), std::move(sublayer)});
}

} // namespace

const Effect& base_sublayer() {
    static const Effect effect{
        .name = "base-sublayer",
        .unit = "-",
        .null = 0.0,
        .low = -2.0,
        .high = 2.5,
        .typical = 0.7,
        .mechanism =
            "Self-cementing aggregate, a lift that was compacted or stabilised apart, or one that holds water: a band "
            "in the middle of the base, a third of it or thickness_mm (at most four fifths), has the law's modulus "
            "times exp(size). Strains are small in the band and larger above and below it, deflections hardly change.",
        .source = "layered elasticity with a divided base; recemented crushed concrete and slag in FHWA-RD-97-148",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .takes_thickness = true,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            const std::string band =
                a.thickness ? fmt::format("{} mm in the middle", figure(1e3 * *a.thickness, 3)) : "the middle third";
            return fmt::format("{} of the base {} {}", band, a.thickness ? "have" : "has",
                               stiffness_words(std::exp(a.size)));
        },
    };
    return effect;
}

} // namespace pave::pavement

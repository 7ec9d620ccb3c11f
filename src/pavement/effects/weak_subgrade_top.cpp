// A soft sublayer at the top of the subgrade: the uppermost 200 mm, or what a case says (at most half of the layer),
// have E exp(-size).
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

constexpr double sublayer = 0.2; // m, unless a case says otherwise

void apply(Case& c, const AppliedEffect& applied, int) {
    const std::size_t l = layers_named(c, applied.layer).front();
    Layer top = c.layers[l];
    top.thickness = std::min(applied.thickness.value_or(sublayer), c.layers[l].thickness / 2.0);
    top.compliance.reset();
    scale_modulus(top, std::exp(-applied.size));
    c.layers[l].thickness -= top.thickness;
    c.layers.insert(c.layers.begin() + static_cast<std::ptrdiff_t>(l), std::move(top));
}

} // namespace

const Effect& weak_subgrade_top() {
    static const Effect effect{
        .name = "weak-subgrade-top",
        .unit = "-",
        .null = 0.0,
        .low = -1.0,
        .high = 2.5,
        .typical = 0.7,
        .mechanism =
            "Remoulding, frost or water leave the uppermost 200 mm of the subgrade, or thickness_mm (at most half of "
            "it), soft, or drying and compaction leave it stiff (a size below 0): its modulus is E exp(-size). In a "
            "soft "
            "top strains are high and drop sharply below it.",
        .source = "layered elasticity with a divided subgrade; Huang, Pavement Analysis and Design, chapter 2",
        .acts_on = "the subgrade",
        .layer = LayerRole::subgrade,
        .takes_thickness = true,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the top {} mm of the subgrade have {}", figure(1e3 * a.thickness.value_or(sublayer), 3),
                               stiffness_words(std::exp(-a.size)));
        },
    };
    return effect;
}

} // namespace pave::pavement

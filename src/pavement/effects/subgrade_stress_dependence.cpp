// The subgrade softens under shear: E = E0 (tau/pa + 1)^size, the law of equation 1 with k2 = 0 and k3 = size.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        Layer& layer = c.layers[l];
        make_uzan(layer);
        layer.parameters[*layer.law->index_of("k3")] += applied.size;
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const material::Law& law = *c.layers[layers_named(c, applied.layer).front()].law;
    const bool fits = law.index_of("k3") || (law.index_of("modulus_MPa") && law.index_of("poisson"));
    return fits ? "" : "the law of the layer has neither a modulus and Poisson's ratio nor k3";
}

} // namespace

const Effect& subgrade_stress_dependence() {
    static const Effect effect{
        .name = "subgrade-stress-dependence",
        .unit = "-",
        .null = 0.0,
        .low = -5.0,
        .high = 0.0,
        .typical = -1.5,
        .mechanism =
            "Fine-grained soil softens as shear stress rises: its modulus follows E0 (tau/pa + 1)^size with the total "
            "octahedral shear tau and pa = 100 kPa. Deflections grow faster than the load, and strains at the top of "
            "the subgrade grow most.",
        .source = "Uzan (1985) with octahedral shear; NCHRP 1-37A guide, resilient modulus of unbound soils",
        .acts_on = "the subgrade",
        .layer = LayerRole::subgrade,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format(
                "at an octahedral shear stress of 20 kPa the subgrade has {} % of its modulus without it",
                figure(100.0 * std::pow(1.2, a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

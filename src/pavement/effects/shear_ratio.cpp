// The shear modulus of the base differs: G13/E3 times the size.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        Layer& layer = c.layers[l];
        layer.parameters[*layer.law->index_of("shear_ratio")] = applied.size * shear_ratio_of(layer);
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    return c.layers[layers_named(c, applied.layer).front()].law->index_of("shear_ratio")
               ? ""
               : "the law of the layer has no shear_ratio";
}

} // namespace

const Effect& shear_ratio() {
    static const Effect effect{
        .name = "shear-ratio",
        .unit = "factor",
        .null = 1.0,
        .low = 0.2,
        .high = 5.0,
        .log_scale = true,
        .typical = 0.6,
        .mechanism =
            "The shear modulus of an anisotropic base is a number of its own: G13/E3 is the study's (or the one that "
            "follows from E1, E3 and nu31) times the size. A base that shears easily spreads the load less.",
        .source = "Tutumluer and Thompson (1997), TRR 1577: shear moduli of granular bases",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the base's shear modulus is {} times what is stated", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The subgrade is stiffer horizontally or vertically: E1/E3 times the size, by the form with one more parameter than
// isotropy (Graham and Houlsby 1983), a = sqrt(E1/E3): nu31 = nu/a, nu12 = nu, G13 = a E3/(2 (1 + nu)).
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        Layer& layer = c.layers[l];
        make_uzan(layer);
        const double a = std::sqrt(applied.size);
        const double shear = shear_ratio_of(layer);
        const auto number = [&](std::string_view key) -> double& {
            return layer.parameters[*layer.law->index_of(key)];
        };
        number("shear_ratio") = a * shear;
        number("n") *= applied.size;
        number("poisson_31") /= a; // n nu31^2 stays, so that the stiffness stays positive definite
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    Layer layer = c.layers[layers_named(c, applied.layer).front()];
    if (layer.law->relaxes()) {
        return "the layer relaxes";
    }
    make_uzan(layer);
    const bool fits = layer.law->index_of("n") && layer.law->index_of("shear_ratio");
    return fits ? "" : "the law of the layer has neither a modulus and Poisson's ratio nor a modulus ratio n";
}

} // namespace

const Effect& subgrade_anisotropy() {
    static const Effect effect{
        .name = "subgrade-anisotropy",
        .unit = "factor",
        .null = 1.0,
        .low = 0.25,
        .high = 4.0,
        .log_scale = true,
        .typical = 0.5,
        .mechanism =
            "Soil laid down or compacted in layers is not as stiff horizontally as vertically, and overconsolidated "
            "clay "
            "is stiffer: E1/E3 is the study's (1 of an isotropic layer, whose modulus is then the vertical one) times "
            "the size, with G13 and nu31 following as its root. The basin becomes narrower or wider at the same "
            "deflection under the load.",
        .source =
            "Graham and Houlsby (1983), Geotechnique 33, 165; Lings, Pennington and Nash (2000), Geotechnique 50, 109: "
            "about 4 in stiff overconsolidated clay",
        .acts_on = "the subgrade",
        .layer = LayerRole::subgrade,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("horizontally the subgrade has {}", stiffness_words(a.size));
        },
    };
    return effect;
}

} // namespace pave::pavement

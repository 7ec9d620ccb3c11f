// Imperfect bond between base and subgrade: a shear spring per area, 1/k = (1 mm/MPa) size/(1 - size).
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    c.layers[layers_named(c, applied.layer).back()].compliance = slip_compliance(applied.size);
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const std::size_t base =
        applied.layer.empty() ? *layer_of_role(c, LayerRole::base) : layers_named(c, applied.layer).back();
    return base + 1 < c.layers.size() ? "" : "nothing but the floor lies below the layer";
}

} // namespace

const Effect& interface_slip_base_subgrade() {
    static const Effect effect{
        .name = "interface-slip-base-subgrade",
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 0.999,
        .typical = 0.5,
        .mechanism =
            "The layers slide on each other against a shear spring per area of compliance 1/k = (1 mm/MPa) size/(1 - "
            "size), while the vertical displacement stays continuous; 0 is bonded, 1 frictionless. Strains jump at "
            "the interface: the layer above bends on its own.",
        .source = "Goodman, Taylor and Brekke (1968), joint elements; the shear spring compliance of BISAR (de Jong et "
                  "al. 1973)",
        .acts_on = "the interface below the base",
        .layer = LayerRole::base,
        .takes_layer = true,
        .apply = apply,
        .refuses = refuses,
    };
    return effect;
}

} // namespace pave::pavement

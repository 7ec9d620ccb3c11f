// Imperfect bond between base and subgrade: a shear spring per area, 1/k = (1 mm/MPa) size/(1 - size).
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    c.layers[layers_named(c, applied.layer).back()].compliance = slip_compliance(applied.size);
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const std::size_t base = layers_named(c, applied.layer).back();
    return base + 1 < c.layers.size() ? "" : "nothing but the floor lies below the layer";
}

} // namespace

const Effect& interface_slip_base_subgrade() {
    static const Effect effect = [] {
        Effect e = interface_slip();
        e.name = "interface-slip-base-subgrade";
        e.acts_on = "the interface below the base";
        e.apply = apply;
        e.refuses = refuses;
        return e;
    }();
    return effect;
}

} // namespace pave::pavement

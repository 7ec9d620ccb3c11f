// Imperfect bond between asphalt and base: a shear spring per area, 1/k = (1 mm/MPa) size/(1 - size).
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    c.layers[layers_named(c, applied.layer).front() - 1].compliance = slip_compliance(applied.size);
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const std::size_t base = layers_named(c, applied.layer).front();
    return base > 0 ? "" : "nothing lies above the layer";
}

} // namespace

const Effect& interface_slip_asphalt_base() {
    static const Effect effect = [] {
        Effect e = interface_slip();
        e.name = "interface-slip-asphalt-base";
        e.acts_on = "the interface above the base";
        e.apply = apply;
        e.refuses = refuses;
        return e;
    }();
    return effect;
}

} // namespace pave::pavement

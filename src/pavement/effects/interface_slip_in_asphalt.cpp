// Lifts of the asphalt that are not bonded: a shear spring per area at half its thickness, or as deep as a case says.
#include "pavement/effects/effect.h"

#include <algorithm>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    const std::size_t l = layers_named(c, applied.layer).front();
    Layer upper = c.layers[l];
    upper.thickness = std::min(applied.thickness.value_or(upper.thickness / 2.0), 0.9 * upper.thickness);
    upper.compliance = slip_compliance(applied.size);
    c.layers[l].thickness -= upper.thickness;
    c.layers.insert(c.layers.begin() + static_cast<std::ptrdiff_t>(l), std::move(upper));
}

} // namespace

const Effect& interface_slip_in_asphalt() {
    static const Effect effect = [] {
        Effect e = interface_slip();
        e.name = "interface-slip-in-asphalt";
        e.acts_on = "between two lifts of the asphalt, at half its thickness or thickness_mm below its top";
        e.layer = LayerRole::asphalt;
        e.takes_thickness = true;
        e.apply = apply;
        return e;
    }();
    return effect;
}

} // namespace pave::pavement

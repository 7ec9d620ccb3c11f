// The plate resists bending: a stiffness per area against deflections that differ from the mean one,
// (1 MPa/mm) size/(1 - size). 0: flexible, 1: rigid.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

constexpr double reference_stiffness = unit::MPa / unit::mm;

void apply(Case& c, const AppliedEffect& applied, int load) {
    if (c.loads[load].type == LoadType::plate && applied.load.value_or(load) == load) {
        c.loads[load].plate_stiffness = reference_stiffness * applied.size / (1.0 - applied.size);
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    return is_plate(c, applied.load) ? "" : "only a plate can be rigid: a load of type \"plate\" is needed";
}

} // namespace

const Effect& plate_rigidity() {
    static const Effect effect{
        .name = "plate-rigidity",
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 0.999,
        .high_is_limit = true,
        .typical = 0.7,
        .mechanism =
            "A plate that does not bend presses its edges into the ground and deflects evenly: differences from the "
            "mean deflection under it meet a stiffness per area of (1 MPa/mm) size/(1 - size). The deflection at the "
            "centre drops, those beyond a diameter stay.",
        .source = "Boussinesq's rigid punch; Uzan and Lytton (1990) on pressure under FWD plates",
        .acts_on = "every plate (axisymmetric)",
        .takes_load = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the plate's stiffness per area is {} MPa/mm", figure(a.size / (1.0 - a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The pulse of a deflectometer is dynamic: inertia, times the size, shifts and changes the peak at every sensor.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int load) {
    if (c.loads[load].type == LoadType::plate && applied.load.value_or(load) == load) {
        c.loads[load].inertia = applied.size;
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (c.relaxes()) {
        return "with a layer that relaxes, the answer to the pulse is followed without inertia";
    }
    if (c.half_space) {
        return "a half-space carries waves away, which the model of the pulse does not follow";
    }
    if (std::any_of(c.loads.begin(), c.loads.end(), [](const Load& load) { return load.is_pulse(); })) {
        return "under a load with a history the section moves as it is";
    }
    return is_plate(c, applied.load) ? "" : "only a plate falls: a load of type \"plate\" is needed";
}

} // namespace

const Effect& inertia() {
    static const Effect effect{
        .name = "inertia",
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 2.0,
        .typical = 1.0,
        .mechanism =
            "A falling weight presses for 30 milliseconds, and waves carry the deflection outwards: far sensors peak "
            "later than the centre, and not at their static value. Mass and damping of the section are multiplied by "
            "the "
            "size (1: the stated densities); the peak at each sensor is read.",
        .source = "Newmark (1959); Roesset and Shao (1985) on dynamic FWD interpretation",
        .acts_on = "every reading under a plate (axisymmetric)",
        .takes_load = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("mass and damping act with {} % of what the stated densities give",
                               figure(100.0 * a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The contact pressure is not uniform: heavy edges (size > 0) or a heavy centre (size < 0), the force kept.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int load) {
    if (applied.load.value_or(load) == load) {
        c.loads[load].pressure_shape += applied.size;
    }
}

} // namespace

const Effect& contact_pressure_shape() {
    static const Effect effect{
        .name = "contact-pressure-shape",
        .unit = "-",
        .null = 0.0,
        .low = -1.0,
        .high = 1.0,
        .typical = -0.5,
        .mechanism =
            "Tyre walls and plates load their edges or their centre more: the pressure is the mean times 1 + size (2 "
            "(r/a)^2 - 1) on a circle (3/2 (xi^2 + eta^2) - 1 in place of the bracket on a rectangle), at the same "
            "force. Only what lies within a radius of the load feels it.",
        .source = "de Beer, Fisher and Jooste (1997) on tyre contact stress; Casey et al. (2016)",
        .acts_on = "every load",
        .takes_load = true,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the pressure is higher {}: by {} % there",
                               a.size > 0.0 ? "at the edge" : "in the centre", figure(100.0 * std::abs(a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The rigid floor lies deeper (or shallower) than the study says.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    c.layers.back().thickness += applied.size * unit::mm;
}

std::string refuses(const Case& c, const AppliedEffect&) {
    return c.half_space ? "the lowest layer has no bottom" : "";
}

} // namespace

const Effect& floor_depth() {
    static const Effect effect{
        .name = "floor-depth",
        .unit = "mm",
        .null = 0.0,
        .low = -500.0,
        .high = 5000.0,
        .typical = 500.0,
        .mechanism =
            "Bedrock, a stiff stratum or the floor of a trough lies deeper than the study states by the size. It "
            "lifts all deflections by a like amount, so it shows most in the far ones.",
        .source = "Rohde and Scullion (1990), depth to a rigid layer from FWD; Burmister (1945)",
        .acts_on = "the lowest layer",
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the floor lies {} mm {} than stated", figure(std::abs(a.size), 2),
                               a.size > 0.0 ? "deeper" : "higher");
        },
    };
    return effect;
}

} // namespace pave::pavement

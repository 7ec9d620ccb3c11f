// The load differs from the stated one by a factor, on the same area of contact.
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int load) {
    if (load == applied.load.value_or(0)) {
        c.loads[load].factor *= applied.size;
    }
}

} // namespace

const Effect& load_magnitude() {
    static const Effect effect{
        .name = "load-magnitude",
        .unit = "factor",
        .null = 1.0,
        .low = 0.5,
        .high = 2.0,
        .log_scale = true,
        .typical = 1.1,
        .mechanism =
            "Dynamic wheel forces and load cell errors make the load differ from the stated one: its pressure is the "
            "stated one times the size, on the same area. All responses under it follow, by less than the factor where "
            "the base stiffens.",
        .source = "OECD DIVINE (1998) on dynamic wheel loads; FWD load cell calibration protocols",
        .acts_on = "the first load",
        .takes_load = true,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string { return "the load is " + share_words(a.size); },
    };
    return effect;
}

} // namespace pave::pavement

// A single reading is wrong by a share of itself.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    const auto reading = static_cast<std::size_t>(applied.reading.value_or(0));
    if (reading < c.sensors.size()) {
        c.sensors[reading].gain *= 1.0 + applied.size;
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const auto reading = static_cast<std::size_t>(applied.reading.value_or(0));
    return reading < c.sensors.size() && c.sensors[reading].measured ? "" : "no such reading";
}

} // namespace

const Effect& outlier() {
    static const Effect effect{
        .name = "outlier",
        .unit = "-",
        .null = 0.0,
        .low = -100.0, // of a place where next to nothing is to be read
        .high = 100.0,
        .typical = 0.3,
        .mechanism = "A loose contact, a stone under a sensor or a slip of the pen changes one reading, by the share "
                     "given. No other reading moves with it.",
        .source = "Huber (1981), Robust Statistics: gross errors",
        .acts_on = "the first reading",
        .takes_reading = true,
        .is_error_of_reading = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            constexpr double near = 0.03;
            if (std::abs(a.size + 1.0) < near) {
                return "the reading is next to nothing";
            }
            if (std::abs(a.size + 2.0) < near) {
                return "the reading has the wrong sign";
            }
            if (a.size < -1.0 || a.size > 2.0) {
                return fmt::format("the reading is {} times what it should be", figure(1.0 + a.size, 2));
            }
            return fmt::format("the reading is {} % too {}", figure(100.0 * std::abs(a.size), 2),
                               a.size > 0.0 ? "large" : "small");
        },
    };
    return effect;
}

} // namespace pave::pavement

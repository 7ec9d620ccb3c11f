// Readings drift from drop to drop: those of load k, counted from 0 in the order of the study, times 1 + k size.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (Sensor& sensor : c.sensors) {
        if (sensor.measured) {
            sensor.gain *= 1.0 + sensor.load * applied.size;
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect&) {
    const auto is_later = [](const Sensor& sensor) { return sensor.measured && sensor.load > 0; };
    return std::any_of(c.sensors.begin(), c.sensors.end(), is_later) ? "" : "no reading under a second load";
}

} // namespace

const Effect& drift() {
    static const Effect effect{
        .name = "drift",
        .unit = "1/load",
        .null = 0.0,
        .low = -0.05,
        .high = 0.05,
        .typical = 0.01,
        .mechanism =
            "Instruments warm up and feet settle in while drop follows drop: the readings under load number k (from 0, "
            "in the order of the study) are scaled by 1 + k size. The first load's stay, so that what all loads have "
            "in "
            "common is left to the gain.",
        .source =
            "FWD calibration protocols: repeated drops within 1 to 2 % of each other, and trends among them rejected",
        .acts_on = "every reading after the first load",
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("readings {} by {} % from load to load", a.size > 0.0 ? "rise" : "fall",
                               figure(100.0 * std::abs(a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

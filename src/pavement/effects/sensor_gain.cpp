// The readings of one load, of one kind or of one instrument are scaled by a factor.
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {
namespace {

bool is_scaled(const Case& c, const AppliedEffect& applied, const Sensor& sensor) {
    if (!sensor.measured) {
        return false;
    }
    if (applied.reading) { // what is stated at its place is the same instrument, on every drop
        const auto reading = static_cast<std::size_t>(*applied.reading);
        if (reading >= c.sensors.size()) {
            return false;
        }
        const Sensor& own = c.sensors[reading];
        const auto type_under = [&](const Sensor& s) { return c.loads[static_cast<std::size_t>(s.load)].type; };
        constexpr double same = 1e-6; // m
        const auto near = [](double a, double b) { return std::abs(a - b) < same; };
        return sensor.quantity == own.quantity && type_under(sensor) == type_under(own) && near(sensor.x, own.x) &&
               near(sensor.y, own.y) && near(sensor.depth, own.depth) && near(sensor.gauge, own.gauge);
    }
    if (!applied.load && !applied.quantity) { // the group of the first reading
        return sensor.load == c.sensors.front().load && sensor.quantity == c.sensors.front().quantity;
    }
    return sensor.load == applied.load.value_or(sensor.load) &&
           sensor.quantity == applied.quantity.value_or(sensor.quantity);
}

void apply(Case& c, const AppliedEffect& applied, int) {
    for (Sensor& sensor : c.sensors) {
        if (is_scaled(c, applied, sensor)) {
            sensor.gain *= applied.size;
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (applied.reading && (applied.load || applied.quantity)) {
        return "a reading says its load and quantity";
    }
    const bool any = std::any_of(c.sensors.begin(), c.sensors.end(),
                                 [&](const Sensor& sensor) { return is_scaled(c, applied, sensor); });
    return any ? "" : "no such reading";
}

} // namespace

const Effect& sensor_gain() {
    static const Effect effect{
        .name = "sensor-gain",
        .unit = "factor",
        .null = 1.0,
        .low = 0.5,
        .high = 2.0,
        .log_scale = true,
        .typical = 1.1,
        .mechanism = "A wrong calibration multiplies every reading of one kind of instrument under one load, or of one "
                     "instrument, by the size. "
                     "Everything else stays as it is.",
        .source = "FWD calibration protocols (relative and reference calibration)",
        .acts_on = "the load and quantity of the first reading",
        .takes_load = true,
        .takes_quantity = true,
        .takes_reading = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string { return "the instrument reads " + share_words(a.size); },
    };
    return effect;
}

} // namespace pave::pavement

// A deflection sensor stands farther from the load than stated, by the size, on every drop.
#include "base/text.h"
#include "base/units.h"
#include "pavement/buried.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

bool is_on_surface(const Sensor& sensor) {
    return sensor.measured && !is_buried(sensor);
}

// The sensor that is named, or the first beside the load.
const Sensor* named(const Case& c, const AppliedEffect& applied) {
    if (applied.reading) {
        const auto reading = static_cast<std::size_t>(*applied.reading);
        return reading < c.sensors.size() && is_on_surface(c.sensors[reading]) ? &c.sensors[reading] : nullptr;
    }
    const auto found = std::find_if(c.sensors.begin(), c.sensors.end(), [](const Sensor& sensor) {
        return is_on_surface(sensor) && (sensor.x != 0.0 || sensor.y != 0.0);
    });
    return found == c.sensors.end() ? nullptr : &*found;
}

// One bar carries the sensors of all drops: what is stated at the same place is the same sensor. One under the load
// moves along x.
void apply(Case& c, const AppliedEffect& applied, int) {
    const Sensor* own = named(c, applied);
    if (own == nullptr) {
        return;
    }
    const Sensor at = *own;
    const double distance = std::hypot(at.x, at.y);
    const double along_x = distance > 0.0 ? at.x / distance : 1.0;
    const double along_y = distance > 0.0 ? at.y / distance : 0.0;
    constexpr double same = 1e-6; // m
    for (Sensor& sensor : c.sensors) {
        if (is_on_surface(sensor) && std::abs(sensor.x - at.x) < same && std::abs(sensor.y - at.y) < same) {
            sensor.x += along_x * applied.size * unit::mm;
            sensor.y += along_y * applied.size * unit::mm;
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (named(c, applied) != nullptr) {
        return "";
    }
    return applied.reading ? "the reading is no deflection" : "no deflection is measured beside a load";
}

} // namespace

const Effect& sensor_position() {
    static const Effect effect{
        .name = "sensor-position",
        .unit = "mm",
        .null = 0.0,
        .low = -310.0,
        .high = 310.0,
        .typical = 50.0,
        .mechanism =
            "A sensor was mounted at another hole of the bar than the file says, or slipped: it stands farther from "
            "the "
            "load than stated by the size, under every load that it reads. Only its own readings change, by the slope "
            "of the basin there.",
        .source =
            "FHWA-RD-03-093 (2006), pavement deflections of LTPP: sensors found one holder off, by 150 to 305 mm, for "
            "days to years",
        .acts_on = "the deflections at the place of the first reading beside a load",
        .takes_reading = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the sensor stands {} mm {} the load than stated", figure(std::abs(a.size), 2),
                               a.size > 0.0 ? "farther from" : "nearer to");
        },
    };
    return effect;
}

} // namespace pave::pavement

// Gauges average vertical strain over more length than the study says, by the size.
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>

namespace pave::pavement {
namespace {

// Of a reading at a point: Gauss-Legendre over the length, with three points.
constexpr double points[] = {-0.7745966692414834, 0.0, 0.7745966692414834};
constexpr double weights[] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

void apply(Case& c, const AppliedEffect& applied, int load) {
    for (Sensor& sensor : c.sensors) {
        if (!sensor.measured || sensor.load != load || sensor.quantity != Quantity::strain_zz) {
            continue;
        }
        const double length = applied.size * unit::mm;
        if (sensor.gauge > 0.0) {
            sensor.gauge += length;
        } else {
            share_out(sensor, points, weights, [&](double at) { return Sensor::Share{.dz = at * length / 2.0}; });
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect&) {
    const bool any = std::any_of(c.sensors.begin(), c.sensors.end(), [](const Sensor& sensor) {
        return sensor.measured && sensor.quantity == Quantity::strain_zz;
    });
    return any ? "" : "no reading of strain_zz";
}

} // namespace

const Effect& gauge_length() {
    static const Effect effect{
        .name = "gauge-length",
        .unit = "mm",
        .null = 0.0,
        .low = 0.0,
        .high = 200.0,
        .typical = 50.0,
        .mechanism =
            "A gauge reads the mean strain between its ends, here farther apart than stated by the size. Peaks are "
            "flattened, most where strain bends or jumps with depth.",
        .source = "coil pairs read the change of their distance, e.g. Greenslade et al. (2012)",
        .acts_on = "every reading of strain_zz",
        .apply = apply,
        .refuses = refuses,
    };
    return effect;
}

} // namespace pave::pavement

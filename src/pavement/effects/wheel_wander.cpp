// Readings average over lateral positions of the wheel, normally distributed with a standard deviation of the size.
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>

namespace pave::pavement {
namespace {

// Gauss-Hermite with seven points for the standard normal distribution.
constexpr double points[] = {-3.750439717725742, -2.366759410734541, -1.154405394739968, 0.0,
                             1.154405394739968,  2.366759410734541,  3.750439717725742};
constexpr double weights[] = {0.0005482688559722, 0.0307571239675865, 0.2401231786050127, 0.4571428571428571,
                              0.2401231786050127, 0.0307571239675865, 0.0005482688559722};

bool wanders(const Case& c, const AppliedEffect& applied, int load) {
    return c.loads[load].type != LoadType::plate && applied.load.value_or(load) == load;
}

void apply(Case& c, const AppliedEffect& applied, int load) {
    for (Sensor& sensor : c.sensors) {
        if (sensor.measured && sensor.load == load && wanders(c, applied, load)) {
            const double deviation = applied.size * unit::mm;
            share_out(sensor, points, weights, [&](double at) { return Sensor::Share{.dx = at * deviation}; });
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const bool any = std::any_of(c.sensors.begin(), c.sensors.end(), [&](const Sensor& sensor) {
        return sensor.measured && wanders(c, applied, sensor.load);
    });
    return any ? "" : "no reading under a wheel";
}

} // namespace

const Effect& wheel_wander() {
    static const Effect effect{
        .name = "wheel-wander",
        .unit = "mm",
        .null = 0.0,
        .low = 0.0,
        .high = 150.0,
        .typical = 60.0,
        .mechanism =
            "Readings that are means of many passes average over the lateral positions of the wheel, normally "
            "distributed with the size as standard deviation. Peaks under a tyre are flattened, most near the surface.",
        .source = "NCHRP 1-37A guide: wheel wander, standard deviation 250 mm on roads, less on test tracks",
        .acts_on = "every reading under a wheel",
        .takes_load = true,
        .apply = apply,
        .refuses = refuses,
    };
    return effect;
}

} // namespace pave::pavement

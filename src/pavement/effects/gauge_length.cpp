// Gauges average vertical strain over more length than the study says, by the size: (u(top) - u(bottom))/length.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

// Of a reading at a point. A gauge too short to matter reads what the displacement of the mesh says, which is less
// accurate than the strain at the point (observation.h): their difference fades with the length.
constexpr double fading = 0.01;  // m
constexpr double nothing = 1e-6; // m

void apply(Case& c, const AppliedEffect& applied, int load) {
    const double length = applied.size * unit::mm;
    for (Sensor& sensor : c.sensors) {
        if (!sensor.measured || sensor.load != load || sensor.quantity != Quantity::strain_zz) {
            continue;
        }
        if (sensor.gauge > 0.0) {
            sensor.gauge += length;
            for (Sensor::Share& share : sensor.shares) {
                share.gauge += length;
            }
            continue;
        }
        if (!(length > 0.0)) {
            continue;
        }
        const double at_point = std::exp(-std::pow(length / fading, 2));
        std::vector<Sensor::Share> shares;
        for (const Sensor::Share& place : shares_of(sensor)) {
            shares.push_back({place.dx, length, place.weight});
            shares.push_back({place.dx, 0.0, place.weight * at_point});
            shares.push_back({place.dx, nothing, -place.weight * at_point});
        }
        sensor.shares = std::move(shares);
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
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("gauges are {} mm longer than stated", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

// The load runs beside the gauges: it stands at x = size.
#include "base/text.h"
#include "base/units.h"
#include "pavement/buried.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

// A deflectometer carries its own sensors along.
bool shifts(const Case& c, const AppliedEffect& applied, int load, const Sensor& sensor) {
    return sensor.measured && sensor.load == load && applied.load.value_or(load) == load &&
           !(c.loads[load].type == LoadType::plate && !is_buried(sensor));
}

void apply(Case& c, const AppliedEffect& applied, int load) {
    for (Sensor& sensor : c.sensors) {
        if (shifts(c, applied, load, sensor)) {
            sensor.x -= applied.size * unit::mm;
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    const bool any = std::any_of(c.sensors.begin(), c.sensors.end(),
                                 [&](const Sensor& sensor) { return shifts(c, applied, sensor.load, sensor); });
    return any ? "" : "no reading but the deflections of a plate, which carries its own sensors";
}

} // namespace

const Effect& load_offset() {
    static const Effect effect{
        .name = "load-offset",
        .unit = "mm",
        .null = 0.0,
        .low = -300.0,
        .high = 300.0,
        .typical = 60.0,
        .mechanism =
            "The wheel runs beside the line of the gauges, by the size across the traffic. Near the surface strains "
            "drop quickly with the offset, at depth slowly.",
        .source = "strain gauge surveys in accelerated testing; Al-Qadi et al. (2004), Virginia Smart Road",
        .acts_on = "every reading of a buried gauge, and deflections under wheels",
        .takes_load = true,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the wheel runs {} mm beside where it is stated", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

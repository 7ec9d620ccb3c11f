// Gauges sit deeper (or shallower) than the study says.
#include "base/text.h"
#include "base/units.h"
#include "pavement/buried.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int load) {
    for (Sensor& sensor : c.sensors) {
        if (sensor.measured && sensor.load == load && is_buried(sensor)) {
            sensor.depth += applied.size * unit::mm;
        }
    }
}

std::string refuses(const Case& c, const AppliedEffect&) {
    return has_gauges(c) ? "" : "no reading but deflections of the surface";
}

} // namespace

const Effect& gauge_depth() {
    static const Effect effect{
        .name = "gauge-depth",
        .unit = "mm",
        .null = 0.0,
        .low = -50.0,
        .high = 50.0,
        .typical = 10.0,
        .mechanism =
            "Gauges are set from a surface that is later trimmed or overlaid, so all of them sit deeper than stated by "
            "the size. The change alternates in sign where a gauge straddles an interface.",
        .source = "depth tolerances of buried strain coils, e.g. Greenslade et al. (2012) for CAPTIF",
        .acts_on = "every reading of a strain or a stress, and of a deflection at depth",
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("gauges sit {} mm {} than stated", figure(std::abs(a.size), 2),
                               a.size > 0.0 ? "deeper" : "higher");
        },
    };
    return effect;
}

} // namespace pave::pavement

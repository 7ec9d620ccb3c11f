// Readings average over lateral positions of the wheel, normally distributed with a standard deviation of the size.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace pave::pavement {
namespace {

// Readings under a tyre bend within some centimetres, so that the distribution is followed in small steps: its
// densities at even places up to four standard deviations. The sum is exact for what is smooth (trapezium rule).
constexpr int places = 161;
constexpr double farthest = 4.0; // standard deviations

std::vector<std::pair<double, double>> make_distribution() {
    std::vector<std::pair<double, double>> list; // place in standard deviations, weight
    double sum = 0.0;
    for (int i = 0; i < places; ++i) {
        const double at = farthest * (2.0 * i / (places - 1) - 1.0);
        list.emplace_back(at, std::exp(-at * at / 2.0));
        sum += list.back().second;
    }
    for (auto& [at, weight] : list) {
        weight /= sum;
    }
    return list;
}

bool wanders(const Case& c, const AppliedEffect& applied, int load) {
    return c.loads[load].type != LoadType::plate && applied.load.value_or(load) == load;
}

void apply(Case& c, const AppliedEffect& applied, int load) {
    for (Sensor& sensor : c.sensors) {
        if (!sensor.measured || sensor.load != load || !wanders(c, applied, load)) {
            continue;
        }
        static const auto distribution = make_distribution();
        std::vector<Sensor::Share> shares;
        for (const Sensor::Share& share : shares_of(sensor)) {
            for (const auto& [at, weight] : distribution) {
                shares.push_back({share.dx + at * applied.size * unit::mm, share.gauge, share.weight * weight});
            }
        }
        sensor.shares = std::move(shares);
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
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the wheel wanders with a standard deviation of {} mm", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

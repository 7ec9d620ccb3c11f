#include "pavement/pulse.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {
namespace {

// The integral of the share of the pressure from the first sample to a time [s].
double impulse_until(const Load& load, double time) {
    double sum = 0.0;
    for (std::size_t i = 1; i < load.history.size(); ++i) {
        const auto& [t0, s0] = load.history[i - 1];
        const auto& [t1, s1] = load.history[i];
        if (time <= t0) {
            break;
        }
        const double t = std::min(time, t1);
        const double s = s0 + (s1 - s0) * (t - t0) / (t1 - t0);
        sum += (s0 + s) / 2.0 * (t - t0);
    }
    return sum;
}

} // namespace

fe::Pulse pulse_of(const Case& c, int number) {
    const Load& load = c.loads[static_cast<std::size_t>(number)];
    const double start = load.history.front().time;
    double end = load.history.back().time;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load == number && sensor.time) {
            end = std::max(end, *sensor.time + load.time_shift);
        }
    }
    fe::Pulse pulse{.step = c.settings.time_step, .means = {}};
    const auto steps = static_cast<std::size_t>(std::ceil((end - start) / pulse.step - 1e-9));
    double before = 0.0;
    for (std::size_t i = 1; i <= steps; ++i) {
        const double until = impulse_until(load, start + static_cast<double>(i) * pulse.step);
        pulse.means.push_back((until - before) / pulse.step);
        before = until;
    }
    return pulse;
}

fe::Pulse coarser(const fe::Pulse& pulse) {
    fe::Pulse coarse{.step = 2.0 * pulse.step, .means = {}};
    for (std::size_t i = 0; i < pulse.means.size(); i += 2) {
        const double next = i + 1 < pulse.means.size() ? pulse.means[i + 1] : 0.0;
        coarse.means.push_back((pulse.means[i] + next) / 2.0);
    }
    return coarse;
}

fe::Followed read_pulse(const Sensor& sensor, const Load& load, const fe::Course& course, Eigen::Index row, double step,
                        const std::vector<fe::Variation>& variations) {
    if (!sensor.time) {
        const auto up = fe::peak(course, row, 1.0);
        if (sensor.quantity == Quantity::deflection) {
            return up;
        }
        const auto down = fe::peak(course, row, -1.0);
        return up.value >= -down.value ? up : down;
    }
    const double time = *sensor.time + load.time_shift - load.history.front().time;
    double slope = 0.0;
    fe::Followed reading = fe::at_time(course, row, time / step, slope);
    for (std::size_t k = 0; k < variations.size(); ++k) {
        if (variations[k].kind == fe::Variation::Kind::time_shift) {
            reading.rates[static_cast<Eigen::Index>(k)] += slope / step;
        }
    }
    return reading;
}

} // namespace pave::pavement

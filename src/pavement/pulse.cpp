#include "pavement/pulse.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {
std::size_t steps_of(const Case& c, int number) {
    const Load& load = c.loads[static_cast<std::size_t>(number)];
    double end = load.history.back().time;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load == number && sensor.time) {
            end = std::max(end, *sensor.time + load.time_shift);
        }
    }
    return static_cast<std::size_t>(std::ceil((end - load.history.front().time) / c.settings.time_step - 1e-9));
}

fe::Pulse pulse_of(const Case& c, int number) {
    const auto& samples = c.loads[static_cast<std::size_t>(number)].history;
    fe::Pulse pulse{.step = c.settings.time_step, .means = std::vector<double>(steps_of(c, number))};
    std::size_t i = 0; // of the sample before
    double impulse = 0.0;
    double before = 0.0;
    for (std::size_t step = 0; step < pulse.means.size(); ++step) {
        const double until = samples.front().time + static_cast<double>(step + 1) * pulse.step;
        const auto part = [&](double time) { // of the impulse after sample i
            const double share = (time - samples[i].time) / (samples[i + 1].time - samples[i].time);
            const double there = samples[i].share + share * (samples[i + 1].share - samples[i].share);
            return (samples[i].share + there) / 2.0 * (time - samples[i].time);
        };
        while (i + 1 < samples.size() && samples[i + 1].time <= until) {
            impulse += part(samples[i + 1].time);
            ++i;
        }
        const double now = impulse + (i + 1 < samples.size() ? part(until) : 0.0);
        pulse.means[step] = (now - before) / pulse.step;
        before = now;
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
        auto up = fe::peak(course, row, 1.0);
        if (sensor.quantity == Quantity::deflection) {
            return up;
        }
        auto down = fe::peak(course, row, -1.0);
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

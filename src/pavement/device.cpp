#include "pavement/device.h"

#include <algorithm>
#include <cmath>

namespace pave::pavement {

std::vector<DeflectionTerm> deflection_terms(const Sensor& sensor) {
    if (sensor.quantity == Quantity::slope) {
        constexpr double h = 0.01;
        return {{0.0, -2.0 * h, -1.0 / (12.0 * h)},
                {0.0, -h, 8.0 / (12.0 * h)},
                {0.0, h, -8.0 / (12.0 * h)},
                {0.0, 2.0 * h, 1.0 / (12.0 * h)}};
    }
    const double away = sensor.y < 0.0 ? -1.0 : 1.0;
    const double front = -beam_rear / (beam_rear - beam_front);
    return {{0.0, 0.0, 1.0},
            {-beam_half_width, away * beam_front, front / 2.0},
            {beam_half_width, away * beam_front, front / 2.0},
            {0.0, away * beam_rear, beam_front / (beam_rear - beam_front)}};
}

std::vector<PlainReading> plain_readings(const Sensor& sensor) {
    std::vector<PlainReading> list;
    const std::vector<Sensor::Share> whole{{.gauge = sensor.gauge}};
    for (const Sensor::Share& share : sensor.shares.empty() ? whole : sensor.shares) {
        PlainReading plain{sensor, share.weight};
        plain.sensor.shares.clear();
        plain.sensor.x += share.dx;
        plain.sensor.gauge = share.gauge;
        if (!is_of_device(sensor.quantity)) {
            list.push_back(std::move(plain));
            continue;
        }
        for (const DeflectionTerm& term : deflection_terms(plain.sensor)) {
            PlainReading& at = list.emplace_back(plain);
            at.sensor.quantity = Quantity::deflection;
            at.sensor.x += term.dx;
            at.sensor.y += term.dy;
            at.weight *= term.weight;
        }
    }
    return list;
}

double reach_of(const Sensor& sensor) {
    double reach = 0.0;
    for (const PlainReading& plain : plain_readings(sensor)) {
        reach = std::max(reach, std::hypot(plain.sensor.x, plain.sensor.y));
    }
    return reach;
}

double reach_along_axes(const Sensor& sensor) {
    double reach = 0.0;
    for (const PlainReading& plain : plain_readings(sensor)) {
        reach = std::max({reach, std::abs(plain.sensor.x), std::abs(plain.sensor.y)});
    }
    return reach;
}

} // namespace pave::pavement

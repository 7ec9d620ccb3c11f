// Readings of devices on the surface that are made of deflections w at several places. y: along the traffic.
//
// slope       -dw/dy, what a traffic speed deflectometer reads at (x, y) from the middle of its axle: the velocity of
// the
//             surface downwards over that of the axle, which drives towards +y. Positive ahead of the load, negative
//             behind it. Here a difference of fourth order, w at y +- 10 and 20 mm. Devices take the slope of a sensor
//             some 3.5 m away for zero: that is not in it.
// benkelman   what a Benkelman beam reads when the load drives away from its tip at (x, y): w there, less what the feet
//             of the beam in the bowl take off. With feet at s_f and s_r from the tip, on the side away from the load,
//                 w(tip) - s_r / (s_r - s_f) w(front) + s_f / (s_r - s_f) w(rear)
//             where w(front) is the mean of the two front feet. The standard beam (AASHTO T 256, IRC:81-1997): pivot
//             2440 mm from the tip, front feet 250 mm and rear foot 1660 mm behind it, front feet 330 mm apart; s_r /
//             (s_r - s_f) is the 2.91 of those standards' correction.
#pragma once

#include "pavement/section.h"

#include <vector>

namespace pave::pavement {

// A deflection at (x + dx, y + dy), with its weight.
struct DeflectionTerm {
    double dx = 0.0, dy = 0.0; // m
    double weight = 1.0;       // of a slope 1/m
};
inline constexpr double beam_front = 2.69, beam_rear = 4.10, beam_half_width = 0.165; // m, of the feet

// Whether the sensor reads deflections of the surface at several places.
constexpr bool is_of_device(Quantity quantity) {
    return quantity == Quantity::slope || quantity == Quantity::benkelman;
}

// Of a sensor whose quantity is that of a device.
std::vector<DeflectionTerm> deflection_terms(const Sensor& sensor);

// The plain readings whose weighted sum a sensor reads: its shares, and what its device reads at each.
struct PlainReading {
    Sensor sensor; // without shares, of no device
    double weight = 1.0;
};
std::vector<PlainReading> plain_readings(const Sensor& sensor);

// Distance from the load of the farthest place that is read: on a circle round it; along x or y alone.
double reach_of(const Sensor& sensor);
double reach_along_axes(const Sensor& sensor);

} // namespace pave::pavement

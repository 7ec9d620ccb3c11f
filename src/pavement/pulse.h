// A load that was recorded over time: its steps, and what is read under it.
#pragma once

#include "fe/solver.h"
#include "pavement/section.h"

namespace pave::pavement {

// How many steps of the settings lead from the first sample of a history to its last one or the last reading under the
// load, whichever is later.
std::size_t steps_of(const Case& c, int load);

// The history of a load in these steps. The impulse of a step is that of the samples.
fe::Pulse pulse_of(const Case& c, int load);

// The same in steps twice as long.
fe::Pulse coarser(const fe::Pulse& pulse);

// A sensor under the load at its own time, or without one its extreme over time: of deflections the largest downwards,
// of strains and stresses the one farthest from zero. course: one row a sensor, from the first sample on in steps of
// `step` [s]. variations: of the course; a shift of time acts here.
fe::Followed read_pulse(const Sensor& sensor, const Load& load, const fe::Course& course, Eigen::Index row, double step,
                        const std::vector<fe::Variation>& variations);

} // namespace pave::pavement

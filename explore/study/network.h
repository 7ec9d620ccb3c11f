// One reduced model for all stations of a road: they differ in their readings and in the pressure of their plates, and
// the pressure can be one of its parameters.
#pragma once

#include "study/problems.h"
#include "study/station.h"

namespace explore::study {

// The survey's study under one plate of pressures from low_kPa to high_kPa (its last parameter), read where `layout`
// is. To build a reduced model of: its readings are not to be fitted. Throws pave::Error as station_study() does.
Study network_study(const Study& survey, const data::DeflectionBowl& layout, double low_kPa, double high_kPa);

// A bowl of a station among the responses of the network's function.
struct NetworkLevel {
    double pressure_kPa = 0.0;
    std::vector<std::size_t> responses; // of each of its readings
};

// A station's problem with the function of a network_study() in place of the finite elements: one call a level.
problem::Problem with_network(problem::Problem station, std::shared_ptr<const problem::ForwardFunction> network,
                              std::vector<NetworkLevel> levels);

} // namespace explore::study

// The drift of sensors: the errors that a fit finds where [data.noise] drift_um_per_ms allows each sensor one.
#pragma once

#include "study/problems.h"

namespace explore::analysis {

struct SensorDrift {
    std::size_t reading = 0; // the sensor's first reading, by its number in the study
    double rate = 0.0;       // m/s, and its standard deviation given the answer
    double deviation = 0.0;
    double until = 0.0; // time of its last reading, s
};

// One for each sensor whose readings are fitted; empty unless the study states drift.
std::vector<SensorDrift> sensor_drifts(const study::Study& study, const problem::Evaluation& answer);

// The drifts that differ from zero at 95 %, in a sentence; "" if there are none.
std::string drift_words(const study::Study& study, const std::vector<SensorDrift>& drifts);

} // namespace explore::analysis

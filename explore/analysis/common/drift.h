// By how much sensors drift: what a fit says of the errors that [data.noise] drift_um_per_ms lets every sensor have.
#pragma once

#include "study/problems.h"

namespace explore::analysis {

struct SensorDrift {
    std::size_t reading = 0; // of the study: the first of the sensor
    double rate = 0.0;       // m/s, and its standard deviation given the answer
    double deviation = 0.0;
    double until = 0.0; // s: of its last reading
};

// Of every sensor whose readings are fitted, where the study states drift.
std::vector<SensorDrift> sensor_drifts(const study::Study& study, const problem::Evaluation& answer);

// Those that are told from none (95 %), in a sentence; else "".
std::string drift_words(const study::Study& study, const std::vector<SensorDrift>& drifts);

} // namespace explore::analysis

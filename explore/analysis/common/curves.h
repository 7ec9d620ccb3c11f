// The model between the sensors: what it reads along the lines on which readings lie.
#pragma once

#include "study/study.h"

namespace explore::analysis {

// Readings of one quantity under one load at three places of a line or more, and what the model reads between them.
struct Curve {
    std::string load, quantity;
    bool by_depth = false;                                         // along the depth, else along x
    double x_mm = 0.0, y_mm = 0.0, depth_mm = 0.0, gauge_mm = 0.0; // of all its points; that which changes is the first
    std::string unit;                                              // of the values: that of the first reading
    std::vector<double> at_mm;                                     // rising; the places of the readings are among them
    std::vector<double> values;
};

// At these parameter values (physical, in the order of the study's), by one run of the full model on the mesh of the
// study's own sensors, so that it reads the same there. Empty: no readings lie on a line, or the run has no answer.
std::vector<Curve> curves(const study::Study& study, const std::vector<double>& parameters);

} // namespace explore::analysis

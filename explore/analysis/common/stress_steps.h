// Levels of load fitted one at a time: does a layer that is taken for linear stiffen or soften?
#pragma once

#include "landscape/minima.h"
#include "study/study.h"

namespace explore::analysis {

// The parameters that a group of readings prefers by itself.
struct WantedAlone {
    std::string group;
    std::vector<double> unit;
    std::vector<double> standard_error; // unit coordinates; infinity: not determined
};

// "The base stiffens with load (234, 258, 284 MPa at 400, 550, 700 kPa): try law = "uzan" there.", for each linear
// layer whose modulus, fitted to each level alone, rises or falls from level to level, by more than two standard errors
// in all.
std::vector<std::string> stress_steps(const study::Study& study, const std::vector<WantedAlone>& alone);

} // namespace explore::analysis

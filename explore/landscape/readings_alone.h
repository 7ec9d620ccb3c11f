// The readings by themselves where priors or constraints hold an answer: that alone judges their noise.
#pragma once

#include "landscape/goodness.h"
#include "landscape/minima.h"

namespace explore::landscape {

// Sets `alone` of a minimum that a prior or an active limit holds: a search from there without them, kept under start
// number `first`. engine: of the problem's function. False: interrupted.
bool find_alone(run::Engine& engine, const problem::Problem& problem, Minimum& minimum, int first);

// The fit whose misfit the noise of the readings must explain: the minimum, or that of the readings by themselves.
struct JudgedFit {
    problem::Problem problem;
    const problem::Evaluation* at = nullptr;
    double sum = 0.0;           // of squares
    int degrees_of_freedom = 0; // readings (and priors) less the parameters that are free there
};
// Of a problem whose noise is stated in units of that noise.
JudgedFit judged_fit(const problem::Problem& problem, const Minimum& minimum);

} // namespace explore::landscape

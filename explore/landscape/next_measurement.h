// Which further reading would be most informative.
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// The uncertainty that one more reading would leave, to first order at the minimum.
struct CandidateEffect {
    std::size_t candidate = 0;
    double gain = 0.0;               // ln of the ratio by which the volume of the acceptable set shrinks (D-optimality)
    std::vector<double> parameters;  // standard error after / before, of each parameter
    std::vector<double> predictions; // and of each prediction
};

// candidates: d(reading)/d(unit) / its standard deviation, one row each; predictions: d(prediction)/d(unit), one row
// each. Before the reading the parameters have the variance of the data together with that of the box, 1/12 (uniform).
// Highest gain first.
std::vector<CandidateEffect> rank_candidates(const problem::Problem& problem, const Acceptance& acceptance,
                                             const Minimum& minimum, const Eigen::MatrixXd& candidates,
                                             const Eigen::MatrixXd& predictions);

} // namespace explore::landscape

// Directions by the sensitivities at a minimum: which combinations of parameters the data fix, and which they do not.
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// One combination of parameters that the data fix although the parameters in it are not: the sum of coefficient *
// s(parameter), s the natural logarithm on a log axis and the value itself on a linear one.
struct Combination {
    std::size_t leading = 0; // coefficient 1
    struct Term {
        std::size_t axis = 0;
        double coefficient = 0.0;
    };
    std::vector<Term> others;
    double standard_error = 0.0;
};

struct Directions {
    std::vector<double> unit; // of the minimum: the place where they hold
    // Of the normalised sensitivity matrix d(residual)/d(unit) / noise over the parameters off their bounds: how many
    // standard deviations the data move when the parameters cross the whole box along each singular vector.
    std::vector<double> singular_values;  // falling
    std::vector<Eigen::VectorXd> vectors; // unit coordinates, 0 for parameters on a bound
    double collinearity = 1.0;     // 1 / sqrt(lowest eigenvalue of the columns' correlation matrix): Brun, Reichert
                                   // and Kuensch (2001, Water Resources Research 37); above 10 to 15 is near dependence
    std::vector<std::size_t> dead; // axes that move the readings by less than their noise, from bound to bound
    std::vector<std::size_t> flat; // indices of singular vectors: half the box along them stays acceptable
    std::vector<std::size_t> free; // axes that the flat directions move: not determined
    std::vector<Combination> fixed; // combinations across the flat directions
};

Directions directions(const problem::Problem& problem, const Acceptance& acceptance, const Minimum& minimum);

} // namespace explore::landscape

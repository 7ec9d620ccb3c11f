// Whether the readings' noise explains the residuals of a fit.
#pragma once

#include "problem/problem.h"

namespace explore::landscape {

struct Goodness {
    double expected = 0.0; // of chi2, by the noise
    double p_value = 1.0;  // of a chi2 so large or larger
};

// A fit: a problem in units of noise that every reading states, and its minimum, with jacobian.
struct FittedProblem {
    const problem::Problem& problem;
    const problem::Evaluation& minimum;
};

// chi2: the sum of squares of the rows at the minima of fits that share no reading, one or several. degrees_of_freedom:
// of them together; 0 or less: nothing can be said, p = 1.
//
// Of normal noise chi2 has the distribution of that name. Of Student's noise the sum of rows (problem/student.h) has
// none with a name: 2000 sets of such errors, and of normal ones of the priors, are fitted by the linear model at the
// minimum (iteratively reweighted least squares from the truth), with the same errors whatever the data. p is then at
// least 1 / 2001.
Goodness goodness_of(std::span<const FittedProblem> fits, double chi2, int degrees_of_freedom);
Goodness goodness_of(const problem::Problem& problem, const problem::Evaluation& minimum, double chi2,
                     int degrees_of_freedom);

} // namespace explore::landscape

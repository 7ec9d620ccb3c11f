// How far the misfit may rise above its minimum before the data reject a point.
#pragma once

#include "landscape/minima.h"
#include "problem/noise_scale.h"

namespace explore::landscape {

// chi2 = f^2 / variance. A value of one quantity is acceptable while the lowest chi2 that it allows lies no more than
// `threshold` above the minimum: the profile likelihood interval (Venzon and Moolgavkar 1988, Applied Statistics 37).
struct Acceptance {
    bool noise_is_stated = false;
    int degrees_of_freedom = 0; // data - parameters that are off their bounds
    double variance = 1.0;      // of one residual
    double threshold = 0.0;     // 95 %
    double chi2 = 0.0;          // of the best minimum, by the stated noise; 0 when none is stated
    double p_value = 1.0;       // of that chi2
    bool widened = false;       // the stated noise does not explain the misfit: the variance is that of the residuals

    double noise() const; // standard deviation of one residual
    double rise(double misfit, double best_misfit) const {
        return (misfit * misfit - best_misfit * best_misfit) / variance;
    }
};

// Where the readings state their noise, residuals are in units of it (variance 1, threshold the 95 % quantile of chi2
// with one degree of freedom). Where chi2 contradicts that noise (p < 0.01) the variance is chi2 / degrees of freedom,
// as without stated noise: s2 = f^2 / degrees of freedom and the threshold the 95 % quantile of F(1, degrees of
// freedom). Of Student's noise the rows' sum takes the place of chi2 and what it is expected to be that of the degrees
// of freedom (goodness.h). Nothing: without stated noise or degrees of freedom no error can be given.
std::optional<Acceptance> acceptance_of(const problem::Problem& problem, const Minimum& best);

// Of noise whose size is fitted, that size: the root of the variance.
problem::NoiseScale noise_scale_of(const Acceptance& acceptance);

} // namespace explore::landscape

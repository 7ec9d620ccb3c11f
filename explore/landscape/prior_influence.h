// The shares of readings and priors in an answer.
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// share: the information on a parameter is the inverse of its variance with the others free in the box, to first order
// at the minimum: 1 / C_kk - 12 with C = (J'J + 12)^-1, J the Jacobian of the rows in standard deviations and 12 the
// inverse variance of the unit interval. The share of it that is gone without the priors' rows. conflict: a likelihood
// ratio test of the priors against the readings: how much lower chi2 is where the priors do not count, chi2 with
// rank(readings) + priors - rank(both) degrees of freedom.
struct PriorInfluence {
    std::vector<double> share;          // of every parameter, 0 to 1
    std::vector<std::size_t> only;      // parameters that the readings alone do not determine: crossing half the box
                                        // moves them by less than the accepted rise
    std::vector<double> readings_want;  // parameters of the best fit without priors, physical
    problem::Evaluation readings_alone; // there, with jacobian
    double readings_misfit = 0.0;       // and its misfit, of the readings
    double statistic = 0.0;
    int degrees_of_freedom = 0;
    double p_value = 1.0;
    bool is_contradicted() const { return degrees_of_freedom > 0 && p_value < contradicted; }
};

// problem: residuals in units of their noise; best: with find_alone() done. Nothing: the problem has no priors. Active
// constraints count as known, too.
std::optional<PriorInfluence> prior_influence(const problem::Problem& problem, const Acceptance& acceptance,
                                              const Minimum& best);

} // namespace explore::landscape

// Do the groups of data want different parameters?
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// The parameters of one group that is fitted alone.
struct GroupAlone {
    std::size_t group = 0;
    std::vector<double> unit, parameters;
    std::vector<double> standard_error; // unit coordinates; infinity: not determined
    double misfit = 0.0;                // of the group's own residuals
    int rank = 0;                       // directions that the group determines
};

// Likelihood ratio test of one parameter set for all groups against one for each. Statistic: (f_joint^2 - sum of
// f_group^2) / variance, chi2 with sum(rank) - joint rank degrees of freedom under stated noise; without, or where even
// the separate fits contradict that noise (p < 0.01), it is divided by them and by the residual variance of these
// fits: F. A direction counts as determined when crossing the box along it moves the data by two standard
// deviations or more.
struct Conflict {
    std::vector<GroupAlone> alone;
    double statistic = 0.0;
    int degrees_of_freedom = 0;
    int remaining = 0;    // data - sum(rank): of the variance of the F test
    double p_value = 1.0; // not a number: not enough data for a test
    // The disagreement of the two groups that disagree most, along the direction of the unit cube in which it is
    // largest in units of its standard error.
    std::size_t first = 0, second = 0;
    Eigen::VectorXd direction; // from what `first` wants to what `second` wants, length 1; empty: none
    double sigmas = 0.0;
};

// groups: which terms of the misfit each holds. starts: points of the unit cube the searches of every group begin
// from. Nothing: interrupted. Kept under start numbers from `first`.
std::optional<Conflict> conflict_of(run::Engine& engine, const problem::Problem& problem, const Acceptance& acceptance,
                                    const Minimum& joint, const std::vector<std::vector<std::size_t>>& groups,
                                    const std::vector<std::vector<double>>& starts, int first);

} // namespace explore::landscape

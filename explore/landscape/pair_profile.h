// The profiled landscape: for pairs of parameters, and for each alone, the rise of chi2 with all others fitted.
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// The profile of the parameters `axes` (one or two): r(h) = min over the others of chi2(h, others), less the lowest
// chi2 of all. Lines are values of a held parameter, in unit coordinates and rising; nodes are where they cross.
struct Slice {
    std::vector<std::size_t> axes;
    std::vector<std::vector<double>> lines; // of each axis
    std::vector<double> rise;               // of each node, the first axis fastest; not a number: no answer found
};

struct ProfiledLandscape {
    std::vector<Slice> single; // of each parameter
    std::vector<Slice> pairs;  // (0, 1), (0, 2), ..., (1, 2), ...
    double lower_by = 0.0;     // chi2 at the lowest node below that of the best minimum; 0: none is lower
};

inline constexpr double lower_matters = 0.1; // lower by more than this: there is another minimum

// The accepted range of a parameter, in unit coordinates.
struct Reach {
    double low = 0.0, high = 1.0;
};

struct PairProfileSettings {
    int most_nodes = 8000; // of all pairs together; lines are as many as it allows, between the two below
    int most_lines = 21;
    int least_lines = 9;
    int first_start = 0;                                       // of the chains of the engine
    std::optional<std::pair<std::size_t, std::size_t>> only{}; // this pair, the lower number first, and nothing else
};

// Lines over [0, 1]: half of them evenly over the box, half over the reach and a quarter of its width on either side,
// and one at the best value. Both ends are lines.
std::vector<double> profile_lines(int count, double best, const Reach& reach);

// Bounded Gauss-Newton over the parameters that are not held, node by node from the minima outwards: each node starts
// where the lowest node beside it ends, moved by its linear model. Then nodes whose neighbours predict a lower fit on
// another branch start from there, until none gains. A wave of nodes runs in parallel and depends on the waves before
// it alone: the same numbers for any number of threads. minima: points of the unit cube, the best first, with
// best_misfit; reach: of each parameter. Nothing: interrupted.
std::optional<ProfiledLandscape> profiled_landscape(run::Engine& engine, const problem::Problem& problem,
                                                    const Acceptance& acceptance,
                                                    const std::vector<std::vector<double>>& minima, double best_misfit,
                                                    const std::vector<Reach>& reach,
                                                    const PairProfileSettings& settings);

} // namespace explore::landscape

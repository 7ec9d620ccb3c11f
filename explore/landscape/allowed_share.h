// How much of what was thought possible before any reading the constraints leave: what an evidence under them is
// relative to.
#pragma once

#include "problem/problem.h"

#include <cstdint>

namespace explore::landscape {

struct AllowedShare {
    double log = 0.0;   // natural logarithm of the share of the prior
    double error = 0.0; // standard error of that
};

// The mean of the limits' own factor exp(-rows^2 / 2) over draws of the priors within the box; of priors that are
// correlated, over independent ones weighed by the correlation. For limits that read no response: nothing is run.
// Nothing: there is no limit, one reads a response, or next to no draw meets them.
std::optional<AllowedShare> allowed_share(const problem::Problem& problem, std::uint64_t seed);

} // namespace explore::landscape

// Ranges and valleys that agree about what the data accept.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::landscape {

// Widens the ranges of the parameters to every set that the walks met and that the data accept: where points without an
// answer ended one walk, another may have come further.
void widen_ranges(const problem::ParameterSpace& space, Uniqueness& u);

// The unit coordinates of the last point of a valley that the data accept: where its rise meets the threshold, between
// its points interpolated linearly in sqrt(chi2), and no further than the ranges of the parameters.
std::vector<double> accepted_end(const problem::ParameterSpace& space, const Uniqueness& u, const Branch& trace);

} // namespace explore::landscape

// A second method at the minima that the first one found.
#pragma once

#include "landscape/minima.h"

namespace explore::landscape {

// Which method confirms the ends of another one.
std::string_view confirming_method(std::string_view method);

// Evaluations that the second method may take beside a search of this many: a fifth.
int confirming_evaluations(std::size_t searched);

// Seeks each minimum once more by `method`, with exact derivatives, from where the first search ended; the lowest
// first, as many as `evaluations` allow. Sets `second` of those (minima.h). Where the method finds a lower misfit the
// minimum moves there, and the list is sorted anew. noise: standard deviation of one residual. The chains are kept as
// starts from `first` on. False: interrupted.
bool confirm(run::Engine& engine, const problem::Problem& problem, std::string_view method, double noise,
             int evaluations, int first, std::vector<Minimum>& minima);

// The second method's verdict on all of them, in one sentence; "": it was not used.
std::string confirmation_words(const std::vector<Minimum>& minima);

} // namespace explore::landscape

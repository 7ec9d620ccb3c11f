// A multistart of each of many problems, in parallel over the problems.
#pragma once

#include "landscape/multistart.h"

#include <functional>

namespace explore::landscape {

struct BatchItem {
    problem::Problem problem;
    int run = 0; // of the store
};

// Calls `done` with the number of the item and its result, from any thread, in any order, once an item that was not
// cut off. The results are those of multistart on each item alone. Threads left over by the last items help them.
void multistart_batch(const std::vector<BatchItem>& items, run::Store& store, const search::Design& design,
                      const MultistartSettings& settings, int threads,
                      const std::function<void(std::size_t, const MultistartResult&, const run::Tally&)>& done);

} // namespace explore::landscape

// Local searches of many problems, in parallel over the problems.
#pragma once

#include "run/engine.h"

#include <functional>

namespace explore::landscape {

struct BatchItem {
    problem::Problem problem;
    int run = 0;                             // of the store
    std::vector<std::vector<double>> starts; // points of the unit cube
};

// store may be nullptr: nothing is kept. Calls `done` with the number of an item and the ends of its searches, from any
// thread and in any order, for every item that was not cut off by an interrupt. The ends are those of Engine::search on
// each item alone, for any number of threads. Threads that the last items leave idle help them.
void search_batch(const std::vector<BatchItem>& items, run::Store* store, const optimise::Method& method,
                  const optimise::SearchSettings& settings, int threads,
                  const std::function<void(std::size_t, const std::vector<run::Endpoint>&, const run::Tally&)>& done);

} // namespace explore::landscape

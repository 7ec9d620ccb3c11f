#include "landscape/batch.h"

#include "run/parallel.h"

namespace explore::landscape {

void search_batch(const std::vector<BatchItem>& items, run::Store* store, const optimise::Method& method,
                  const optimise::SearchSettings& settings, int threads,
                  const std::function<void(std::size_t, const std::vector<run::Endpoint>&, const run::Tally&)>& done) {
    const int at_once = run::concurrency(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, at_once);
    tbb::task_arena arena(at_once);
    run::for_each_index(arena, items.size(), [&](std::size_t i) {
        // An engine has an arena of its own: a thread that waits there takes no other item on top of its own.
        const BatchItem& item = items[i];
        run::Engine engine(item.problem, store, item.run, {.threads = threads, .show_progress = false});
        if (const auto ends = engine.search(item.starts, method, settings)) {
            done(i, *ends, engine.tally());
        }
    });
}

} // namespace explore::landscape

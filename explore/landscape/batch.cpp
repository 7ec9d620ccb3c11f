#include "landscape/batch.h"

#include "run/parallel.h"

namespace explore::landscape {

void multistart_batch(const std::vector<BatchItem>& items, run::Store& store, const search::Design& design,
                      const MultistartSettings& settings, int threads,
                      const std::function<void(std::size_t, const MultistartResult&, const run::Tally&)>& done) {
    const int usable = run::usable_threads(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, usable);
    tbb::task_arena arena(usable);
    run::for_each_index(arena, items.size(), [&](std::size_t i) {
        // An engine has an arena of its own: a thread that waits there takes no other item on top of its own.
        run::Engine engine(items[i].problem, &store, items[i].run, {.threads = usable, .show_progress = false});
        if (const auto result = multistart(engine, items[i].problem, design, settings)) {
            done(i, *result, engine.tally());
        }
    });
}

} // namespace explore::landscape

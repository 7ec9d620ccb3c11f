#include "analysis/unique.h"

#include "analysis/layout.h"

#include <chrono>
#include <fmt/format.h>

namespace explore::analysis {

std::string UniqueResult::reason() const {
    return run::why_no_start(answer.explored);
}

std::optional<UniqueResult> unique(Session& session, const study::Study& study, const UniqueOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    const problem::Problem full = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem everything = study::make_noise_problem(study, study::Scope::everything);
    auto reduced = session.reduced(full, study, options.model);
    if (options.model.reduced() && !reduced) {
        return std::nullopt;
    }
    UniqueResult result{.study = study,
                        .options = options,
                        .problem = options.model.alone() ? reduced->problem : full,
                        .answer = {},
                        .next = {},
                        .reduced = std::move(reduced)};
    const std::string settings = fmt::format("searches of {} evaluations, seed {}{}", options.settings.max_evaluations,
                                             session.options().seed, result.reduced ? result.reduced->settings : "");
    std::optional<run::Engine> explorer;
    if (options.model.confirmed()) { // a run of its own: its evaluations are not the full model's
        explorer.emplace(result.reduced->problem, session.store(), session.begin(study, "explore", settings),
                         session.engine_settings());
    }
    const int outputs_run = session.begin(study, "unique-outputs", settings);
    auto engine = session.engine(result.problem, session.begin(study, "unique", settings));
    auto everything_engine = session.engine(everything, outputs_run);
    auto task = uniqueness_task(study, result.problem, everything, engine, everything_engine, session.options().seed);
    task.explorer = explorer ? &*explorer : nullptr;
    if (options.model.alone()) {
        task.outputs.clear(); // of loads that it may not have
    }
    auto answer = landscape::uniqueness(task, options.settings);
    if (!answer) {
        return std::nullopt;
    }
    result.answer = std::move(*answer);
    if (!result.failed() && result.answer.acceptance) {
        result.next = next_reading(study, result.problem, result.answer);
    }
    result.computed = engine.tally().computed + everything_engine.tally().computed;
    result.kept = engine.tally().kept + everything_engine.tally().kept;
    result.forward_cpu_seconds = engine.tally().forward_cpu_seconds + everything_engine.tally().forward_cpu_seconds +
                                 result.next.forward_cpu_seconds;
    if (explorer) {
        result.computed_by_reduced_model = explorer->tally().computed;
        result.forward_cpu_seconds += explorer->tally().forward_cpu_seconds;
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis

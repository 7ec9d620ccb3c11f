#include "run/engine.h"

#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <new>

namespace explore::run {
namespace {

using problem::Evaluation;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace

struct Engine::Implementation {
    const problem::Problem& problem;
    Store* store;
    int run;
    EngineSettings settings;
    tbb::global_control limit;
    tbb::task_arena arena;
    tbb::enumerable_thread_specific<std::unique_ptr<problem::ForwardFunction::Workspace>> workspaces;
    std::atomic<std::int64_t> computed{0};

    // One evaluation on the workspace of this thread. Running out of memory is an answer for this point, not the end.
    Evaluation evaluate(std::span<const double> unit, bool with_jacobian) {
        auto& workspace = workspaces.local();
        try {
            if (workspace == nullptr) {
                workspace = problem.function->make_workspace();
            }
            return problem.evaluate(unit, with_jacobian, *workspace);
        } catch (const std::bad_alloc&) {
            workspace.reset();
            Evaluation e;
            e.parameters = problem.space.physical(unit);
            e.reason = "out of memory";
            return e;
        }
    }

    void keep(RunNumber number, const Evaluation& e) {
        if (store != nullptr) {
            store->put(run, number, e);
        }
        ++computed;
    }

    std::map<RunNumber, Evaluation> known(RunNumber first, RunNumber last) const {
        return store != nullptr ? store->get(run, first, last) : std::map<RunNumber, Evaluation>{};
    }
};

Engine::Engine(const problem::Problem& problem, Store* store, int run, EngineSettings settings) {
    const int threads = usable_threads(settings.threads);
    implementation_ = std::unique_ptr<Implementation>(
        new Implementation{problem,
                           store,
                           run,
                           settings,
                           tbb::global_control(tbb::global_control::max_allowed_parallelism, threads),
                           tbb::task_arena(threads),
                           {},
                           {}});
}

Engine::~Engine() = default;

std::optional<std::vector<Evaluation>> Engine::evaluate(const search::Design& design) {
    Implementation& m = *implementation_;
    const auto begin = Clock::now();
    const std::size_t n = design.points.size();
    std::vector<Evaluation> evaluations(n);
    std::vector<char> done(n, 0);
    for (auto& [number, e] : m.known({-1, 0}, {-1, std::numeric_limits<int>::max()})) {
        const auto i = static_cast<std::size_t>(number.number);
        if (i < n && e.parameters == m.problem.space.physical(design.points[i])) {
            evaluations[i] = std::move(e);
            done[i] = 1;
        }
    }
    std::vector<std::size_t> missing;
    for (std::size_t i = 0; i < n; ++i) {
        if (done[i] == 0) {
            missing.push_back(i);
        }
    }
    tally_.kept += static_cast<std::int64_t>(n - missing.size());
    {
        Progress progress("explore", m.settings.show_progress ? static_cast<std::int64_t>(n) : -1);
        progress.add(static_cast<std::int64_t>(n - missing.size()), false);
        for_each_index(m.arena, missing.size(), [&](std::size_t k) {
            const std::size_t i = missing[k];
            evaluations[i] = m.evaluate(design.points[i], false);
            m.keep({-1, static_cast<int>(i)}, evaluations[i]);
            progress.add(1, true);
        });
    }
    tally_.computed = m.computed;
    tally_.seconds += seconds_since(begin);
    if (interrupted()) {
        return std::nullopt;
    }
    return evaluations;
}

std::optional<std::vector<Endpoint>> Engine::search(const std::vector<std::vector<double>>& starts,
                                                    const optimise::Method& method,
                                                    const optimise::SearchSettings& settings) {
    Implementation& m = *implementation_;
    const auto begin = Clock::now();
    std::vector<Endpoint> ends(starts.size());
    std::atomic<int> finished{0};
    std::atomic<std::int64_t> kept{0};
    {
        Progress progress("search", m.settings.show_progress ? 0 : -1);
        for_each_index(m.arena, starts.size(), [&](std::size_t s) {
            // A search that was cut off is replayed: the method asks for the same points again and is answered from
            // the store until it gets to new ones.
            const int start = static_cast<int>(s);
            auto known = m.known({start, 0}, {start, std::numeric_limits<int>::max()});
            int number = 0;
            Endpoint& end = ends[s];
            end.start = start;
            end.from = starts[s];
            double best = std::numeric_limits<double>::infinity();
            std::exception_ptr failure;
            const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
                if (interrupted() || failure) {
                    return optimise::Answer::stop;
                }
                try {
                    const RunNumber at{start, number++};
                    const auto old = known.find(at);
                    const bool have = old != known.end() && old->second.parameters == m.problem.space.physical(unit);
                    Evaluation e = have ? std::move(old->second) : m.evaluate(unit, method.uses_gradient);
                    if (have) {
                        ++kept;
                    } else {
                        m.keep(at, e);
                    }
                    progress.add(1, !have);
                    if (!e.converged()) {
                        return optimise::Answer::no_answer;
                    }
                    sample.residuals = m.problem.misfit.residuals(e.responses);
                    if (method.uses_gradient) {
                        sample.jacobian = m.problem.residual_jacobian(e);
                    }
                    if (e.misfit < best) {
                        best = e.misfit;
                        end.evaluation = std::move(e);
                    }
                    return optimise::Answer::computed;
                } catch (...) { // the store failed: no exception crosses the optimiser
                    failure = std::current_exception();
                    return optimise::Answer::stop;
                }
            };
            end.search = optimise::local_search(method, starts[s], objective, settings);
            if (failure) {
                std::rethrow_exception(failure);
            }
            if (!method.uses_gradient && !end.search.unit.empty() && !interrupted()) {
                end.evaluation = m.evaluate(end.search.unit, true);
            }
            progress.note("searches " + std::to_string(++finished) + "/" + std::to_string(starts.size()));
        });
    }
    tally_.computed = m.computed;
    tally_.kept += kept;
    tally_.seconds += seconds_since(begin);
    if (interrupted()) {
        return std::nullopt;
    }
    return ends;
}

Evaluation Engine::evaluate_one(std::span<const double> unit) {
    return implementation_->evaluate(unit, true);
}

std::vector<std::size_t> distinct_starts(const search::Design& design, const std::vector<Evaluation>& evaluations,
                                         int count, double distance) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < evaluations.size(); ++i) {
        if (evaluations[i].converged()) {
            order.push_back(i);
        }
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return evaluations[a].misfit < evaluations[b].misfit; });
    std::vector<std::size_t> taken;
    for (const std::size_t i : order) {
        const bool far = std::all_of(taken.begin(), taken.end(), [&](std::size_t j) {
            double d2 = 0.0;
            for (std::size_t k = 0; k < design.points[i].size(); ++k) {
                const double d = design.points[i][k] - design.points[j][k];
                d2 += d * d;
            }
            return d2 >= distance * distance;
        });
        if (far && static_cast<int>(taken.size()) < count) {
            taken.push_back(i);
        }
    }
    return taken;
}

} // namespace explore::run

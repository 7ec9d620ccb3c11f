#include "run/engine.h"

#include "problem/workspaces.h"
#include "run/cluster.h"
#include "run/in_step.h"
#include "run/least_squares.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <fmt/format.h>
#include <limits>
#include <new>

namespace explore::run {
namespace {

using problem::Evaluation;
using Clock = std::chrono::steady_clock;

constexpr std::size_t told_without = 10; // points without an answer, and none with one: said where as many are left

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace

struct Engine::Implementation {
    problem::Problem problem;
    Store* store;
    int run;
    EngineSettings settings;
    std::size_t threads;
    tbb::global_control limit;
    tbb::task_arena arena;
    problem::Workspaces workspaces{*problem.function};
    std::atomic<std::int64_t> computed{0};
    std::atomic<std::int64_t> forward_ns{0};

    // One evaluation. std::bad_alloc passes through: it is no answer for this point, which another time may have room.
    Evaluation evaluate(std::span<const double> unit, bool with_jacobian) {
        const std::int64_t begin = thread_cpu_ns();
        Evaluation e =
            workspaces.lend([&](auto& workspace) { return problem.evaluate(unit, with_jacobian, workspace); });
        forward_ns += thread_cpu_ns() - begin;
        return e;
    }

    // The same of several points at once.
    std::vector<Evaluation> evaluate_many(std::span<const std::vector<double>> units, bool with_jacobian) {
        const std::int64_t begin = thread_cpu_ns();
        auto evaluations =
            workspaces.lend([&](auto& workspace) { return problem.evaluate_many(units, with_jacobian, workspace); });
        forward_ns += thread_cpu_ns() - begin;
        return evaluations;
    }

    // So many go together, and no thread is without work.
    std::size_t at_once(std::size_t points) const {
        return std::max<std::size_t>(1, std::min(problem.function->lanes(), (points + threads - 1) / threads));
    }

    // The same of any number of points, in parallel; none of those that an interruption leaves out.
    InStep::Answers evaluate_all(std::span<const std::vector<double>> units, bool with_jacobian) {
        InStep::Answers answers(units.size());
        const std::size_t some = at_once(units.size());
        for_each_index(arena, (units.size() + some - 1) / some, [&](std::size_t k) {
            auto computed =
                evaluate_many(units.subspan(k * some, std::min(some, units.size() - k * some)), with_jacobian);
            std::move(computed.begin(), computed.end(), answers.begin() + static_cast<std::ptrdiff_t>(k * some));
        });
        return answers;
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
    problem::Problem spread = problem;
    if (Cluster* cluster = Cluster::current()) {
        spread.function = cluster->spread(problem.function, usable_threads(settings.threads), settings.threads);
    }
    const int threads = concurrency(settings.threads);
    implementation_ = std::unique_ptr<Implementation>(new Implementation{
        std::move(spread), store, run, settings, static_cast<std::size_t>(threads),
        tbb::global_control(tbb::global_control::max_allowed_parallelism, threads), tbb::task_arena(threads)});
}

Engine::~Engine() = default;

std::optional<std::vector<Evaluation>> Engine::evaluate(const search::Design& design, bool with_jacobian,
                                                        std::size_t first) {
    Implementation& m = *implementation_;
    const auto begin = Clock::now();
    const std::size_t n = design.points.size() - first;
    const auto point = [&](std::size_t i) -> const std::vector<double>& { return design.points[first + i]; };
    const auto number = [&](std::size_t i) { return static_cast<int>(first + i); };
    std::vector<Evaluation> evaluations(n);
    std::vector<char> done(n, 0);
    for (auto& [known, e] : m.known({-1, number(0)}, {-1, number(n) - 1})) {
        const auto i = static_cast<std::size_t>(known.number) - first;
        if (i < n && e.parameters == m.problem.space.physical(point(i))) {
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
        std::atomic<bool> has_answer = false; // of those that are computed here, or was kept
        for (std::size_t i = 0; i < n; ++i) {
            has_answer = has_answer || (done[i] != 0 && evaluations[i].converged());
        }
        std::atomic<std::size_t> without{0};
        const bool is_long = missing.size() >= 2 * told_without; // what ends anyway is not announced
        const std::size_t at_once = m.at_once(missing.size());
        for_each_index(m.arena, (missing.size() + at_once - 1) / at_once, [&](std::size_t k) {
            const std::span<const std::size_t> numbers =
                std::span(missing).subspan(k * at_once, std::min(at_once, missing.size() - k * at_once));
            std::vector<std::vector<double>> points;
            for (const std::size_t i : numbers) {
                points.push_back(point(i));
            }
            std::vector<Evaluation> computed;
            try {
                computed = m.evaluate_many(points, with_jacobian);
            } catch (const Interrupted&) { // the program's own flag tells
                return;
            }
            for (std::size_t j = 0; j < numbers.size(); ++j) {
                m.keep({-1, number(numbers[j])}, computed[j]);
                if (computed[j].converged()) {
                    has_answer = true;
                } else if (is_long && !has_answer && ++without == told_without) {
                    progress.say(fmt::format("no answer at the first {} points; one says: {}", told_without,
                                             computed[j].reason));
                }
                evaluations[numbers[j]] = std::move(computed[j]);
                progress.add(1, true);
            }
        });
    }
    tally_.computed = m.computed;
    tally_.forward_cpu_seconds = 1e-9 * static_cast<double>(m.forward_ns);
    tally_.seconds += seconds_since(begin);
    if (interrupted()) {
        return std::nullopt;
    }
    return evaluations;
}

namespace {

// A chain that keeps what it computes under the start number it was given. A point is computed and kept once, however
// often it is requested, now or in a run before: evaluations are pure.
class KeptChain final : public Chain {
public:
    using Compute = std::function<Evaluation(std::span<const double>, bool with_jacobian)>;
    KeptChain(const problem::Problem& problem, Store* store, int run, int start, Compute compute, Progress& progress)
        : problem_(problem),
          store_(store),
          run_(run),
          start_(start),
          compute_(std::move(compute)),
          progress_(progress) {
        if (store == nullptr) {
            return;
        }
        for (auto& [number, e] : store->get(run, {start, 0}, {start, std::numeric_limits<int>::max()})) {
            next_ = number.number + 1;
            std::vector<double> parameters = e.parameters;
            known_.insert_or_assign(std::move(parameters), Known{std::move(e), true}); // with derivatives comes later
        }
    }

    Evaluation at(std::span<const double> unit, bool with_jacobian) override {
        if (interrupted()) {
            throw Interrupted();
        }
        const auto old = known_.find(problem_.space.physical(unit));
        if (old != known_.end() &&
            (!with_jacobian || !old->second.evaluation.converged() || old->second.evaluation.jacobian.size() > 0)) {
            kept += old->second.before ? 1 : 0;
            progress_.add(1, false);
            return old->second.evaluation;
        }
        Evaluation e = compute_(unit, with_jacobian);
        if (store_ != nullptr) {
            store_->put(run_, {start_, next_++}, e);
        }
        known_.insert_or_assign(e.parameters, Known{e, false});
        ++computed;
        progress_.add(1, true);
        return e;
    }

    std::int64_t kept = 0, computed = 0;

private:
    struct Known {
        Evaluation evaluation;
        bool before = false; // it was in the store
    };

    const problem::Problem& problem_;
    Store* store_;
    int run_;
    int start_;
    Compute compute_;
    Progress& progress_;
    std::map<std::vector<double>, Known> known_; // by parameters
    int next_ = 0;
};

} // namespace

bool Engine::chains(const std::string& what, int first, std::size_t count,
                    const std::function<void(std::size_t i, Chain& chain)>& body) {
    return follow(
        what, [&](std::size_t i) { return first + static_cast<int>(i); }, count, true, body);
}

bool Engine::chain(const std::string& what, int number, const std::function<void(Chain& chain)>& body) {
    return follow(
        what, [&](std::size_t) { return number; }, 1, false, [&](std::size_t, Chain& chain) { body(chain); });
}

bool Engine::follow(const std::string& what, const std::function<int(std::size_t)>& start, std::size_t count,
                    bool in_step, const std::function<void(std::size_t i, Chain& chain)>& body) {
    Implementation& m = *implementation_;
    const auto begin = Clock::now();
    std::atomic<std::size_t> finished{0};
    std::atomic<std::int64_t> kept{0};
    {
        Progress progress(what, m.settings.show_progress ? 0 : -1);
        const auto follow_one = [&](std::size_t i, const KeptChain::Compute& compute) {
            KeptChain chain(m.problem, m.store, m.run, start(i), compute, progress);
            try {
                body(i, chain);
            } catch (const Interrupted&) { // as above
            }
            m.computed += chain.computed;
            kept += chain.kept;
            progress.note(fmt::format("{} of {}", ++finished, count));
        };
        if (const std::size_t lanes = m.problem.function->lanes(); lanes > 1 && in_step) {
            InStep together([&](std::span<const std::vector<double>> units, bool with_jacobian) {
                return m.evaluate_all(units, with_jacobian);
            });
            together.run(count, lanes * m.threads, [&](std::size_t i) {
                follow_one(i, [&](std::span<const double> unit, bool with_jacobian) {
                    return together.at(unit, with_jacobian);
                });
            });
        } else {
            for_each_index(m.arena, count, [&](std::size_t i) {
                follow_one(i, [&](std::span<const double> unit, bool with_jacobian) {
                    return m.evaluate(unit, with_jacobian);
                });
            });
        }
    }
    tally_.computed = m.computed;
    tally_.forward_cpu_seconds = 1e-9 * static_cast<double>(m.forward_ns);
    tally_.kept += kept;
    tally_.seconds += seconds_since(begin);
    return !interrupted();
}

std::optional<std::vector<Endpoint>> Engine::search(const std::vector<std::vector<double>>& starts,
                                                    const optimise::Method& method,
                                                    const optimise::SearchSettings& settings, int first,
                                                    const std::vector<int>& kept_as) {
    Implementation& m = *implementation_;
    std::vector<Endpoint> ends(starts.size());
    const bool finished = follow(
        "search", [&](std::size_t s) { return kept_as.empty() ? first + static_cast<int>(s) : kept_as[s]; },
        starts.size(), true,
        [&](std::size_t s, Chain& chain) {
            Endpoint& end = ends[s];
            end.start = first + static_cast<int>(s);
            end.from = starts[s];
            double best = std::numeric_limits<double>::infinity();
            std::exception_ptr failure;
            const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
                if (failure) {
                    return optimise::Answer::stop;
                }
                try {
                    Evaluation e = chain.at(unit, method.uses_gradient);
                    if (!e.converged()) {
                        return optimise::Answer::no_answer;
                    }
                    if (method.uses_gradient) {
                        sample = sample_of(m.problem, e);
                    } else {
                        sample = {
                            .residuals = m.problem.residuals(e), .jacobian = {}, .limits = m.problem.beyond_limits(e)};
                    }
                    if (e.misfit < best) {
                        best = e.misfit;
                        end.evaluation = std::move(e);
                    }
                    return optimise::Answer::computed;
                } catch (...) { // interrupted, or the store failed: no exception crosses the optimiser
                    failure = std::current_exception();
                    return optimise::Answer::stop;
                }
            };
            end.search = optimise::local_search(method, starts[s], objective, settings);
            if (failure) {
                std::rethrow_exception(failure);
            }
            if (!method.uses_gradient && !end.search.unit.empty()) {
                end.evaluation = chain.at(end.search.unit, true);
            }
        });
    if (!finished) {
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
            return search::squared_distance(design.points[i], design.points[j]) >= distance * distance;
        });
        if (far && static_cast<int>(taken.size()) < count) {
            taken.push_back(i);
        }
    }
    return taken;
}

std::string why_no_minimum(const problem::Problem& problem, const std::vector<Evaluation>& evaluations) {
    const auto nearest = std::min_element(evaluations.begin(), evaluations.end(), [](const auto& a, const auto& b) {
        return a.converged() && (!b.converged() || a.misfit < b.misfit);
    });
    if (nearest != evaluations.end() && nearest->converged()) {
        std::string broken;
        for (const std::size_t i : problem.broken_limits(*nearest)) {
            broken += (broken.empty() ? "\"" : "\", \"") + problem.limits[i]->text();
        }
        return "no search ended where the constraints are met" + (broken.empty() ? "" : ": " + broken + "\"");
    }
    return "not one explored point has an answer" +
           (evaluations.empty() ? "" : "; the first says: " + evaluations.front().reason);
}

} // namespace explore::run

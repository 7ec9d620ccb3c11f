#include "diagnose/workbench.h"

#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace explore::diagnose {

Target leaving_out(const std::vector<std::size_t>& terms, std::size_t residuals) {
    Target target;
    target.left_out.assign(residuals, 0);
    for (const std::size_t i : terms) {
        target.left_out[i] = 1;
    }
    return target;
}

double counted_sum(const Eigen::VectorXd& residuals, const Target& target) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
        const bool counts = target.left_out.empty() || target.left_out[static_cast<std::size_t>(i)] == 0;
        sum += counts ? residuals[i] * residuals[i] : 0.0;
    }
    return sum;
}

std::optional<Model> fit(run::Chain& chain, const problem::Problem& problem, const Members& members,
                         const std::vector<double>& start, const Target& target, const FitSettings& settings) {
    Model best;
    best.sum = std::numeric_limits<double>::infinity();
    bool is_first = true;
    std::exception_ptr failure;
    const problem::Problem compared = target.left_out.empty() ? problem : problem.setting_apart(target.left_out);
    const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
        const bool with_jacobian = sample.wants_derivatives;
        problem::Evaluation e;
        try {
            e = is_first && settings.at_start != nullptr ? *settings.at_start : chain.at(unit, with_jacobian);
            is_first = false;
        } catch (...) { // no exception crosses the optimiser
            failure = std::current_exception();
            return optimise::Answer::stop;
        }
        if (!e.converged()) {
            return optimise::Answer::no_answer;
        }
        if (with_jacobian) {
            sample = run::sample_of(compared, e);
        } else {
            sample = {.residuals = compared.residuals(e), .jacobian = {}, .limits = compared.beyond_limits(e)};
        }
        if (target.offset.size() > 0) {
            sample.residuals += target.offset;
        }
        Eigen::VectorXd residuals = sample.residuals; // of what is left out, too
        for (std::size_t i = 0; i < target.left_out.size(); ++i) {
            if (target.left_out[i] != 0) {
                sample.residuals[static_cast<Eigen::Index>(i)] = 0.0;
                if (with_jacobian) {
                    sample.jacobian.row(static_cast<Eigen::Index>(i)).setZero();
                }
            }
        }
        if (const auto pulls = target.penalty.rows(); pulls > 0) {
            const Eigen::VectorXd point =
                Eigen::Map<const Eigen::VectorXd>(unit.data(), static_cast<Eigen::Index>(unit.size()));
            const auto rows = sample.residuals.size();
            sample.residuals.conservativeResize(rows + pulls);
            sample.residuals.tail(pulls) = target.penalty * (point - target.centre);
            if (with_jacobian) {
                sample.jacobian.conservativeResize(rows + pulls, Eigen::NoChange);
                sample.jacobian.bottomRows(pulls) = target.penalty;
            }
        }
        if (const double sum = sample.residuals.squaredNorm(); sum < best.sum) {
            best = {members, {unit.begin(), unit.end()}, std::move(e), std::move(residuals), sum, Mesh::study};
        }
        return optimise::Answer::computed;
    };
    optimise::SearchSettings search;
    search.max_evaluations = 40;
    search.enough = settings.enough;
    search.secant_below = settings.secant_below;
    search.worth = settings.worth / 2.0;
    optimise::gauss_newton(start, objective, search);
    if (failure) {
        std::rethrow_exception(failure);
    }
    if (best.unit.empty() || best.sum > settings.worth) {
        return std::nullopt;
    }
    return best;
}

std::shared_ptr<const problem::Problem> Workbench::problem(const Members& members, Mesh asked) {
    const Mesh mesh = has_coarse_ ? asked : Mesh::study;
    std::shared_ptr<const problem::Problem> dropped; // destroyed without the lock, before another one is made
    {
        const std::scoped_lock lock(mutex_);
        if (members.empty() && baselines_[mesh]) {
            return baselines_[mesh];
        }
        if (const auto found = problems_.find({mesh, members}); found != problems_.end()) {
            if (auto kept = found->second.lock()) {
                return kept;
            }
        }
        dropped = std::move(recent_[mesh]);
        recent_[mesh].reset();
    }
    dropped.reset();
    auto made = std::make_shared<const problem::Problem>(making_.problem(members, mesh));
    const std::scoped_lock lock(mutex_);
    if (members.empty()) {
        return baselines_[mesh] = std::move(made);
    }
    problems_[{mesh, members}] = made;
    recent_[mesh] = made;
    return made;
}

Workbench::Counted::Counted(Workbench& bench, const problem::Problem& problem, const Key& key)
    : bench(bench),
      engine(problem, bench.making_.store,
             [&] {
                 const std::scoped_lock lock(bench.mutex_);
                 const auto [run, is_new] = bench.runs_.try_emplace(key, 0);
                 if (is_new) {
                     run->second = bench.making_.run(key.second, key.first);
                 }
                 return run->second;
             }(),
             {.threads = bench.making_.threads, .show_progress = false}) {}

Workbench::Counted::~Counted() {
    const run::Tally& own = engine.tally();
    const std::scoped_lock lock(bench.mutex_);
    bench.tally_.computed += own.computed;
    bench.tally_.kept += own.kept;
    bench.tally_.forward_cpu_seconds += own.forward_cpu_seconds;
}

bool Workbench::chain(const Members& members, int start,
                      const std::function<void(const problem::Problem&, run::Chain&)>& body, Mesh mesh) {
    return use(members, mesh, [&](const problem::Problem& problem, run::Engine& engine) {
        return engine.chain("", start, [&](run::Chain& chain) { body(problem, chain); });
    });
}

bool Workbench::chains(const Members& members, int first, std::size_t count,
                       const std::function<void(const problem::Problem&, std::size_t, run::Chain&)>& body, Mesh mesh) {
    return use(members, mesh, [&](const problem::Problem& problem, run::Engine& engine) {
        return engine.chains("", first, count, [&](std::size_t i, run::Chain& chain) { body(problem, i, chain); });
    });
}

Shift shift_between(const problem::Evaluation& own, const problem::Evaluation& coarse) {
    Shift shift(own.responses.size());
    std::transform(own.responses.begin(), own.responses.end(), coarse.responses.begin(), shift.begin(), std::minus<>());
    return shift;
}

problem::Evaluation shifted(const problem::Problem& problem, problem::Evaluation coarse, const Shift& shift) {
    if (coarse.converged()) {
        std::transform(coarse.responses.begin(), coarse.responses.end(), shift.begin(), coarse.responses.begin(),
                       std::plus<>());
        coarse.misfit = problem.misfit(coarse);
    }
    return coarse;
}

OnCoarse on_coarse(Workbench& bench, const Model& model, int number) {
    problem::Evaluation coarse;
    bench.chain(
        model.members, number, [&](const problem::Problem&, run::Chain& chain) { coarse = chain.at(model.unit); },
        Mesh::coarse);
    if (!coarse.converged()) {
        bench.give_up_coarse();
        return {model.evaluation, Shift(model.evaluation.responses.size(), 0.0)};
    }
    Shift shift = shift_between(model.evaluation, coarse);
    return {shifted(*bench.problem(model.members), std::move(coarse), shift), std::move(shift)};
}

namespace {

class ShiftedChain final : public run::Chain {
public:
    ShiftedChain(const problem::Problem& problem, run::Chain& coarse, const Shift& shift)
        : problem_(problem),
          coarse_(coarse),
          shift_(shift) {}
    problem::Evaluation at(std::span<const double> unit, bool with_jacobian) override {
        return shifted(problem_, coarse_.at(unit, with_jacobian), shift_);
    }

private:
    const problem::Problem& problem_;
    run::Chain& coarse_;
    const Shift& shift_;
};

// A fit as exact as a diagnosis needs.
std::optional<Model> fit_as_needed(run::Chain& chain, const problem::Problem& problem, const Members& members,
                                   const std::vector<double>& start, double variance, const Target& target,
                                   FitSettings settings) {
    settings.enough = std::max(settings.enough, close_enough * variance);
    if (settings.on_coarse == nullptr) {
        return fit(chain, problem, members, start, target, settings);
    }
    ShiftedChain shifted_chain(problem, chain, *settings.on_coarse);
    std::optional<Model> found = fit(shifted_chain, problem, members, start, target, settings);
    if (found) {
        found->mesh = Mesh::coarse;
    }
    return found;
}

Mesh mesh_of(const FitSettings& settings) {
    return settings.on_coarse == nullptr ? Mesh::study : Mesh::coarse;
}

} // namespace

std::optional<Model> fit_from(Workbench& bench, const Members& members, int number, const std::vector<double>& start,
                              double variance, const Target& target, const FitSettings& settings) {
    std::optional<Model> found;
    bench.chain(
        members, number,
        [&](const problem::Problem& problem, run::Chain& chain) {
            found = fit_as_needed(chain, problem, members, start, variance, target, settings);
        },
        mesh_of(settings));
    return found;
}

std::vector<std::optional<Model>> fit_in_step(Workbench& bench, const Members& members, int first,
                                              const std::vector<Start>& starts, double variance) {
    std::vector<std::optional<Model>> found(starts.size());
    std::vector<std::size_t> with_start;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        if (!starts[i].unit.empty()) {
            with_start.push_back(i);
        }
    }
    if (with_start.empty()) {
        return found;
    }
    bench.chains(
        members, first, with_start.size(),
        [&](const problem::Problem& problem, std::size_t i, run::Chain& chain) {
            const Start& own = starts[with_start[i]];
            found[with_start[i]] =
                fit_as_needed(chain, problem, members, own.unit, variance, *own.target, own.settings);
        },
        mesh_of(starts[with_start[0]].settings));
    return found;
}

FitSettings for_residuals(const problem::Evaluation* at_start, double variance) {
    constexpr double near = 2.0; // half of chi2
    return {.secant_below = at_start != nullptr ? INFINITY : near * variance, .at_start = at_start};
}

void keep_lower(std::optional<Model>& best, std::optional<Model> found) {
    if (found && (!best || found->sum < best->sum)) {
        best = std::move(found);
    }
}

run::Tally Workbench::tally() const {
    const std::scoped_lock lock(mutex_);
    return tally_;
}

} // namespace explore::diagnose

#include "analysis/explore/explore.h"

#include "base/error.h"
#include "landscape/multistart.h"
#include "landscape/pair_profile.h"
#include "pavement/forward.h"
#include "run/parallel.h"
#include "study/reduced_function.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace explore::analysis {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

double seconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

landscape::Minimum minimum_of(const run::Endpoint& end) {
    return {.evaluation = end.evaluation,
            .unit = end.search.unit,
            .members = {end.start},
            .on_bound = landscape::bounds_met(end.search.unit),
            .lowest = end.evaluation.parameters,
            .highest = end.evaluation.parameters,
            .converged = end.search.converged};
}

} // namespace

std::unique_ptr<Explorer> Explorer::make(Session& session, study::Study study, double limit_percent) {
    study::refuse_own_model(study, "explore");
    std::unique_ptr<Explorer> explorer(new Explorer(std::move(study), session.engine_settings()));
    const problem::Problem full = study::make_noise_problem(explorer->study_, study::Scope::fitted);
    explorer->why_full_ = study::why_no_reduced_model(explorer->study_);
    if (explorer->why_full_.empty()) {
        explorer->reduced_ =
            session.reduced(full, explorer->study_, {.use = ModelUse::reduced, .limit_percent = limit_percent});
        if (!explorer->reduced_) {
            return nullptr;
        }
    }
    explorer->problem_ = std::make_shared<problem::Problem>(explorer->reduced_ ? explorer->reduced_->problem : full);
    explorer->workspace_ = explorer->problem_->function->make_workspace();
    if (!explorer->search()) {
        return nullptr;
    }
    explorer->engine_.show_progress = false;
    const auto best = explorer->minima_.front().minimum.evaluation.parameters;
    explorer->curves_ = curves(explorer->study_, best);
    explorer->evaluate(best, {}); // the first run of a workspace makes it
    const auto begin = std::chrono::steady_clock::now();
    explorer->evaluate(best, {});
    explorer->seconds_a_point_ = seconds_since(begin);
    return explorer;
}

bool Explorer::search() {
    // Of a full model in three dimensions fewer: a run takes seconds.
    const bool slow = !reduced_ && pave::pavement::ForwardModel(study_.model).cost().seconds > 0.0;
    constexpr std::uint64_t seed = 1;
    const auto design = search::sobol(study_.space, slow ? 16 : 128, seed);
    run::Engine engine(*problem_, nullptr, 0, engine_);
    const auto found = landscape::multistart(engine, *problem_, design, {.starts = slow ? 2 : 8});
    if (!found) {
        return false;
    }
    if (found->minima.empty()) {
        throw std::runtime_error(run::why_no_minimum(*problem_, found->explored));
    }
    for (const auto& minimum : found->minima) {
        minima_.push_back(described(minimum, *problem_));
    }
    return true;
}

FoundMinimum Explorer::described(landscape::Minimum minimum, const problem::Problem& problem) const {
    FoundMinimum found{.minimum = std::move(minimum), .local = {}, .acceptance = {}};
    found.local = landscape::analyse(found.minimum, problem);
    found.acceptance = landscape::acceptance_of(problem, found.minimum);
    return found;
}

std::vector<double> Explorer::unit_of(const std::vector<double>& values) const {
    const auto& axes = study_.space.axes;
    if (values.size() != axes.size()) {
        throw std::invalid_argument(fmt::format("{} values for {} parameters", values.size(), axes.size()));
    }
    std::vector<double> unit;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        if (!std::isfinite(values[k])) {
            throw std::invalid_argument(fmt::format("the value of {} is not a number", axes[k].name));
        }
        unit.push_back(std::clamp(axes[k].unit(std::clamp(values[k], axes[k].low, axes[k].high)), 0.0, 1.0));
    }
    return unit;
}

std::shared_ptr<const problem::Problem> Explorer::with(const ChangedReadings& changes) {
    if (changes.empty()) {
        return problem_;
    }
    const std::scoped_lock lock(changed_mutex_);
    if (changed_ == nullptr || changes_ != changes) {
        study::Study other = study_;
        for (const auto& [reading, value] : changes) {
            if (reading >= other.measured().size() || !std::isfinite(value)) {
                throw std::invalid_argument("a measured reading and a number are wanted");
            }
            other.readings[reading].value = value;
        }
        try {
            problem::Problem problem = study::make_noise_problem(other, study::Scope::fitted);
            problem.function = problem_->function; // readings change what is compared, not what is computed
            changed_ = std::make_shared<problem::Problem>(std::move(problem));
        } catch (const pave::Error& error) { // a reading of zero where residuals are relative to it
            throw std::invalid_argument(error.what());
        }
        changes_ = changes;
    }
    return changed_;
}

std::vector<double> Explorer::residuals(const problem::Evaluation& evaluation, const ChangedReadings& changes) {
    const auto problem = with(changes);
    std::vector<double> list(study_.measured().size(), not_a_number);
    if (evaluation.converged()) {
        const Eigen::VectorXd single = problem->single_residuals(evaluation) / std::sqrt(unit_variance());
        for (std::size_t i = 0; i < problem->readings(); ++i) {
            list[problem->response_of(i)] = single[static_cast<Eigen::Index>(i)];
        }
    }
    return list;
}

problem::Evaluation Explorer::evaluate(const std::vector<double>& values, const ChangedReadings& changes) {
    const auto unit = unit_of(values);
    const auto problem = with(changes);
    const std::scoped_lock lock(point_mutex_);
    return problem->evaluate(unit, false, *workspace_);
}

std::optional<FoundMinimum> Explorer::fit_from(const std::vector<std::vector<double>>& starts,
                                               const problem::Problem& problem) {
    run::Engine engine(problem, nullptr, 0, engine_);
    const auto ends = engine.search(starts, *optimise::find_method("gauss-newton"), {});
    const run::Endpoint* best = nullptr;
    if (ends) {
        for (const run::Endpoint& end : *ends) {
            if (!end.search.unit.empty() && (best == nullptr || end.search.misfit < best->search.misfit)) {
                best = &end;
            }
        }
    }
    return best == nullptr ? std::nullopt : std::optional(described(minimum_of(*best), problem));
}

std::optional<FoundMinimum> Explorer::fit(const std::vector<double>& values, const ChangedReadings& changes) {
    const auto unit = unit_of(values);
    const auto problem = with(changes);
    const std::scoped_lock lock(search_mutex_);
    return fit_from({unit}, *problem);
}

std::optional<PairGrid> Explorer::landscape(std::size_t x, std::size_t y, const std::vector<double>& values,
                                            const ChangedReadings& changes, int lines, bool fitted) {
    constexpr int most_lines = 101;
    if (x >= y || y >= study_.space.axes.size() || lines < 2 || lines > most_lines) {
        throw std::invalid_argument("two parameters, the lower number first, and from 2 to 101 lines are wanted");
    }
    const auto unit = unit_of(values);
    const auto problem = with(changes);
    const std::uint64_t ticket = ++newest_landscape_;
    const std::scoped_lock lock(search_mutex_);
    if (ticket != newest_landscape_) {
        return std::nullopt;
    }
    PairGrid grid{.x = x, .y = y, .x_values = {}, .y_values = {}, .chi2 = {}, .fitted = fitted};
    if (fitted) {
        return fitted_landscape(std::move(grid), unit, *problem, lines);
    }
    const auto share = [&](int i) { return static_cast<double>(i) / (lines - 1); };
    for (int i = 0; i < lines; ++i) {
        grid.x_values.push_back(study_.space.axes[x].physical(share(i)));
        grid.y_values.push_back(study_.space.axes[y].physical(share(i)));
    }
    run::Engine engine(*problem, nullptr, 0, engine_);
    constexpr int rows_at_once = 4;
    for (int row = 0; row < lines; row += rows_at_once) {
        search::Design design;
        for (int j = row; j < std::min(row + rows_at_once, lines); ++j) {
            for (int i = 0; i < lines; ++i) {
                design.points.push_back(unit);
                design.points.back()[x] = share(i);
                design.points.back()[y] = share(j);
            }
        }
        const auto answers = engine.evaluate(design);
        if (!answers || ticket != newest_landscape_) {
            return std::nullopt;
        }
        for (const auto& answer : *answers) {
            grid.chi2.push_back(answer.converged() ? chi2(answer) : not_a_number);
        }
    }
    grid.lowest = chi2(minima_.front().minimum.evaluation);
    if (!changes.empty()) {
        if (const auto lowest = fit_from({unit, minima_.front().minimum.unit}, *problem)) {
            grid.lowest = chi2(lowest->minimum.evaluation);
        }
    }
    return grid;
}

std::optional<PairGrid> Explorer::fitted_landscape(PairGrid grid, const std::vector<double>& unit,
                                                   const problem::Problem& problem, int lines) {
    run::Engine engine(problem, nullptr, 0, engine_);
    std::vector<std::vector<double>> starts;
    for (const FoundMinimum& found : minima_) {
        starts.push_back(found.minimum.unit);
    }
    starts.push_back(unit);
    const auto best = fit_from(starts, problem);
    if (!best) {
        return std::nullopt;
    }
    starts.back() = best->minimum.unit;
    std::rotate(starts.begin(), starts.end() - 1, starts.end()); // the best first
    landscape::Acceptance acceptance;
    acceptance.variance = unit_variance();
    const std::size_t d = study_.space.axes.size();
    const std::vector<landscape::Reach> everywhere(d); // evenly over the box
    landscape::PairProfileSettings settings;
    settings.most_nodes = std::numeric_limits<int>::max();
    settings.most_lines = settings.least_lines = lines;
    settings.only = std::pair(grid.x, grid.y);
    const auto profiled = landscape::profiled_landscape(engine, problem, acceptance, starts,
                                                        best->minimum.evaluation.misfit, everywhere, settings);
    if (!profiled) {
        return std::nullopt;
    }
    const landscape::Slice& slice = profiled->pairs.front();
    const auto physical = [&](std::size_t axis, const std::vector<double>& at) {
        std::vector<double> list;
        list.reserve(at.size());
        for (const double u : at) {
            list.push_back(study_.space.axes[axis].physical(u));
        }
        return list;
    };
    grid.x_values = physical(slice.axes[0], slice.lines[0]);
    grid.y_values = physical(slice.axes[1], slice.lines[1]);
    grid.lowest = chi2(best->minimum.evaluation) - profiled->lower_by;
    for (const double rise : slice.rise) {
        grid.chi2.push_back(grid.lowest + rise);
    }
    return grid;
}

ConfirmedPoint Explorer::confirm(const std::vector<double>& values, const ChangedReadings& changes) {
    const auto unit = unit_of(values);
    const auto begin = std::chrono::steady_clock::now();
    const std::scoped_lock lock(confirm_mutex_);
    problem::Problem everything = *with(changes);
    everything.function = study::make_noise_problem(study_, study::Scope::everything).function;
    const auto workspace = everything.function->make_workspace();
    ConfirmedPoint point{.evaluation = everything.evaluate(unit, false, *workspace), .curves = {}};
    if (point.evaluation.converged()) {
        point.curves = curves(study_, point.evaluation.parameters);
    }
    point.seconds = seconds_since(begin);
    return point;
}

} // namespace explore::analysis

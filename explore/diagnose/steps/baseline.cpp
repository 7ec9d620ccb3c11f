// The study's own model.
#include "diagnose/steps/investigation.h"

#include <algorithm>
#include <cmath>

namespace explore::diagnose {

using Eigen::VectorXd;

bool Investigation::fit_baseline() {
    const auto baseline = bench_.problem({});
    const problem::Problem& problem = *baseline;
    const search::Design design = search::sobol(problem.space, settings_.explore, task_.seed);
    landscape::MultistartSettings multistart;
    multistart.starts = settings_.starts;
    multistart.search.enough = close_enough;
    multistart.first_kept = search_number;
    const auto search_all = [&] {
        return bench_.use({}, Mesh::coarse, [&](const problem::Problem& own, run::Engine& engine) {
            if (!task_.explore) {
                return landscape::multistart(engine, own, design, multistart);
            }
            auto explored = task_.explore(design);
            return explored ? landscape::refine(engine, own, design, std::move(*explored), {}, multistart)
                            : std::nullopt;
        });
    };
    std::optional<landscape::MultistartResult> result;
    while (d_.minima.empty()) {
        result = search_all();
        if (!result) {
            return false;
        }
        if (!result->minima.empty()) {
            fit_leading_minima(design, *result, multistart.start_distance);
        }
        if (run::interrupted()) {
            return false;
        }
        if (d_.minima.empty() && !bench_.has_coarse()) {
            d_.failed = run::why_no_minimum(problem, result->explored);
            return true;
        }
        if (d_.minima.empty()) {
            bench_.give_up_coarse();
        }
    }
    for (std::size_t i = 0; i < result->explored.size(); ++i) {
        if (result->explored[i].converged()) {
            explored_.push_back({design.points[i], problem.residuals(result->explored[i])});
        }
    }
    set_baseline(d_.minima[0]);
    return true;
}

// The leading minima of the coarse mesh on the study's own, and whether points of the sample lead lower there.
void Investigation::fit_leading_minima(const search::Design& design, const landscape::MultistartResult& coarse,
                                       double distance) {
    constexpr std::size_t leading = 3;
    constexpr int from_sample = 2;
    constexpr double lower = 0.5; // chi2
    d_.variance = variance_of(std::pow(coarse.minima[0].evaluation.misfit, 2));
    std::vector<std::vector<double>> starts;
    for (std::size_t m = 0; m < std::min(leading, coarse.minima.size()); ++m) {
        starts.push_back(coarse.minima[m].unit);
    }
    fit_minima(starts, minimum_number, INFINITY);
    starts.clear();
    for (const std::size_t i : run::distinct_starts(design, coarse.explored, from_sample, distance)) {
        starts.push_back(design.points[i]);
    }
    fit_minima(starts, minimum_number + static_cast<int>(leading),
               d_.minima.empty() ? INFINITY : d_.minima[0].sum - lower * d_.variance);
}

// Adds to the minima of the baseline what searches from these points find.
void Investigation::fit_minima(const std::vector<std::vector<double>>& starts, int number, double worth) {
    std::vector<std::optional<Model>> found(starts.size());
    run::for_each_index(arena_, starts.size(), [&](std::size_t s) {
        found[s] = fit_from({}, number + static_cast<int>(s), starts[s], {}, {.worth = worth});
    });
    for (auto& model : found) {
        if (model) {
            d_.minima.push_back(std::move(*model));
        }
    }
    std::stable_sort(d_.minima.begin(), d_.minima.end(), [](const Model& a, const Model& b) { return a.sum < b.sum; });
}

// Of a residual, where so much is left of all of them.
double Investigation::variance_of(double sum) const {
    const auto baseline = bench_.problem({});
    const double dof = static_cast<double>(baseline->rows()) - static_cast<double>(baseline->space.axes.size());
    return noise_is_stated_ ? 1.0 : std::max(sum / std::max(1.0, dof), 1e-24);
}

void Investigation::set_baseline(Model model) {
    d_.variance = variance_of(model.sum);
    d_.baseline = judged(std::move(model));
}

// A fit with an effect may have left the baseline's minimum for a better one: then that is the gain, not the
// effect's. False: interrupted.
bool Investigation::improve_baseline(bool& better) {
    constexpr std::size_t tried = 3;
    for (std::size_t e = 0; e < std::min(tried, d_.effects.size()) && d_.effects[e].fit; ++e) {
        const auto& unit = d_.effects[e].fit->model.unit;
        const std::vector<double> start(unit.begin(), unit.end() - 1);
        constexpr double lower = 0.5; // chi2
        const double known = d_.baseline.model.sum;
        const int number = baseline_number + attempts_++;
        auto found = fits_.lower({}, number, start, d_.screening.base.shift, {}, INFINITY, true);
        if (found && found->sum < known - 0.5 * lower * d_.variance) {
            found = fits_.confirm(found, number);
        }
        if (found && found->sum < d_.baseline.model.sum - lower * d_.variance) {
            d_.minima.insert(d_.minima.begin(), *found);
            set_baseline(*found);
            better = true;
        }
    }
    return !run::interrupted();
}

void Investigation::examine_baseline() {
    const VectorXd residuals = d_.baseline.model.residuals / std::sqrt(d_.variance);
    for (const ReadingGroup& group : task_.groups) {
        d_.groups.push_back(test_group(residuals, group));
    }
    const auto problem = bench_.problem({});
    d_.constancy = test_constancy(problem->residual_jacobian(d_.baseline.model.evaluation) / std::sqrt(d_.variance),
                                  residuals, nuisance_of(d_.baseline.model), task_.groups);
}

} // namespace explore::diagnose

#include "landscape/confirmation.h"

#include "base/text.h"
#include "run/least_squares.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <exception>
#include <fmt/format.h>

namespace explore::landscape {
namespace {

// Of one minimum: with fewer the method has hardly begun, and more than this none has needed to see a slope.
constexpr int least_evaluations = 4;
constexpr int most_evaluations = 16;

// A lower end matters where it lies off the first one and the noise tells the two misfits apart.
constexpr double same_place = 1e-3;    // of the box
constexpr double matters = 0.01;       // of the variance of one residual
constexpr double without_noise = 1e-3; // of the sum of squares

// Coordinates in which a unit changes the residuals by about their noise, and crosses no more than a part of the box:
// the second method, which has no matrix of its own to begin with, sees a round bowl where readings of very unequal
// weight make a ravine, and ends by what matters.
Eigen::MatrixXd metric_of(const problem::Problem& problem, const Minimum& minimum, double noise) {
    const Eigen::MatrixXd j = problem.residual_jacobian(minimum.evaluation);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j, Eigen::ComputeFullV);
    const auto rows = static_cast<double>(std::max<Eigen::Index>(1, j.rows()));
    const double level = noise > 0.0 ? noise : minimum.evaluation.misfit / std::sqrt(rows);
    constexpr double longest = 0.1; // of the box
    constexpr double shortest = 1e-9;
    Eigen::VectorXd lengths = Eigen::VectorXd::Constant(j.cols(), longest);
    for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i) {
        lengths[i] = std::clamp(level / std::max(svd.singularValues()[i], 1e-300), shortest, longest);
    }
    return svd.matrixV() * lengths.asDiagonal();
}

void seek(run::Chain& chain, const problem::Problem& problem, const optimise::Method& method, double noise,
          int evaluations, Minimum& minimum) {
    problem::Evaluation lowest = minimum.evaluation;
    std::vector<double> lowest_unit = minimum.unit;
    std::exception_ptr failure;
    const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
        if (failure) {
            return optimise::Answer::stop;
        }
        try {
            // The first is known.
            problem::Evaluation e = std::equal(unit.begin(), unit.end(), minimum.unit.begin(), minimum.unit.end())
                                        ? minimum.evaluation
                                        : chain.at(unit);
            if (!e.converged()) {
                return optimise::Answer::no_answer;
            }
            sample = run::sample_of(problem, e);
            if (e.misfit < lowest.misfit) {
                lowest = std::move(e);
                lowest_unit.assign(unit.begin(), unit.end());
            }
            return optimise::Answer::computed;
        } catch (...) { // interrupted, or the store failed: no exception crosses the optimiser
            failure = std::current_exception();
            return optimise::Answer::stop;
        }
    };
    optimise::SearchSettings settings;
    settings.max_evaluations = evaluations;
    settings.metric = metric_of(problem, minimum, noise);
    const optimise::SearchResult search = optimise::local_search(method, minimum.unit, objective, settings);
    if (failure) {
        std::rethrow_exception(failure);
    }
    const double before = minimum.evaluation.misfit;
    const double gain = before * before - lowest.misfit * lowest.misfit;
    double moved = 0.0;
    for (std::size_t k = 0; k < lowest_unit.size(); ++k) {
        moved = std::max(moved, std::abs(lowest_unit[k] - minimum.unit[k]));
    }
    const double level = noise > 0.0 ? matters * noise * noise : without_noise * before * before;
    Confirmation second{.method = method.name,
                        .agrees = moved <= same_place || gain <= level,
                        .has_ended = search.converged,
                        .misfit_before = before,
                        .evaluations = search.evaluations - 1,
                        .ended = search.ended};
    if (!second.agrees) {
        minimum.unit = std::move(lowest_unit);
        minimum.evaluation = std::move(lowest);
        minimum.on_bound = bounds_met(minimum.unit);
        minimum.converged = search.converged;
        for (std::size_t k = 0; k < minimum.unit.size(); ++k) {
            minimum.lowest[k] = std::min(minimum.lowest[k], minimum.evaluation.parameters[k]);
            minimum.highest[k] = std::max(minimum.highest[k], minimum.evaluation.parameters[k]);
        }
    }
    minimum.second = std::move(second);
}

} // namespace

std::string_view confirming_method(std::string_view method) {
    return method == "gauss-newton" ? "slsqp" : "gauss-newton";
}

int confirming_evaluations(std::size_t searched) {
    return static_cast<int>(searched / 5);
}

bool confirm(run::Engine& engine, const problem::Problem& problem, std::string_view method, double noise,
             int evaluations, int first, std::vector<Minimum>& minima) {
    const std::size_t count =
        std::min(minima.size(), static_cast<std::size_t>(std::max(evaluations, 0)) / least_evaluations);
    if (count == 0) {
        return true;
    }
    const int each = std::min(most_evaluations, evaluations / static_cast<int>(count));
    const optimise::Method& by = *optimise::find_method(method);
    if (!engine.chains("confirm", first, count, [&](std::size_t i, run::Chain& chain) {
            seek(chain, problem, by, noise, each + 1, minima[i]);
        })) {
        return false;
    }
    std::stable_sort(minima.begin(), minima.end(),
                     [](const Minimum& a, const Minimum& b) { return a.evaluation.misfit < b.evaluation.misfit; });
    return true;
}

std::string confirmation_words(const std::vector<Minimum>& minima) {
    std::vector<const Minimum*> asked;
    std::vector<const Minimum*> moved;
    for (const Minimum& m : minima) {
        if (m.second) {
            asked.push_back(&m);
            if (!m.second->agrees) {
                moved.push_back(&m);
            }
        }
    }
    if (asked.empty()) {
        return "";
    }
    const std::string_view method = asked[0]->second->method;
    const std::string of = asked.size() == 1 && minima.size() == 1 ? "the minimum"
                           : asked.size() == minima.size()
                               ? fmt::format("each of the {} minima", minima.size())
                               : fmt::format("each of the {} lowest of {} minima", asked.size(), minima.size());
    const auto open = std::find_if(asked.begin(), asked.end(), [](const Minimum* m) { return !m->second->has_ended; });
    if (moved.empty() && open != asked.end()) {
        return fmt::format("The check by a second method is unfinished: started at {}, {} had found nothing lower when "
                           "it was stopped ({}).",
                           of, method, (*open)->second->ended);
    }
    if (moved.empty()) {
        return fmt::format("Two methods agree: started at {}, {} found nothing lower.", of, method);
    }
    return fmt::format("Two methods do not agree: started at {}, {} went on to a lower misfit from {} of them ({} in "
                       "place of {}), whose search had ended too early; the values here are where {} ended.",
                       of, method, moved.size(), pave::figure(moved[0]->evaluation.misfit),
                       pave::figure(moved[0]->second->misfit_before), method);
}

} // namespace explore::landscape

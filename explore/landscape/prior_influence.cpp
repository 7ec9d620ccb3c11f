#include "landscape/prior_influence.h"

#include "landscape/rank.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What a parameter that may lie anywhere in its range is known by: the inverse variance of the unit interval.
constexpr double box = 12.0;

// Of every column of the rows j in standard deviations, the others known by their ranges alone.
VectorXd informations(const MatrixXd& j) {
    MatrixXd h = j.transpose() * j;
    h.diagonal().array() += box;
    return (h.inverse().diagonal().cwiseInverse().array() - box).cwiseMax(0.0);
}

} // namespace

std::optional<PriorInfluence> prior_influence(run::Engine& engine, const problem::Problem& problem,
                                              const Acceptance& acceptance, const Minimum& best, int first) {
    const auto priors = static_cast<int>(problem.priors().size());
    if (priors == 0) {
        return std::nullopt;
    }
    PriorInfluence result;
    const problem::Problem alone = problem.without_priors();
    const MatrixXd all = problem.information_jacobian(best.evaluation) / acceptance.noise();
    const MatrixXd without = alone.information_jacobian(best.evaluation) / acceptance.noise();
    const VectorXd of_all = informations(all);
    const VectorXd of_readings = informations(without);
    const double half_box = 4.0 * acceptance.threshold;
    for (Index k = 0; k < of_all.size(); ++k) {
        result.share.push_back(of_all[k] > 0.0 ? std::clamp(1.0 - of_readings[k] / of_all[k], 0.0, 1.0) : 0.0);
        if (of_readings[k] < half_box && of_all[k] >= half_box) {
            result.only.push_back(static_cast<std::size_t>(k));
        }
    }
    problem::Evaluation at = best.evaluation;
    result.readings_misfit = alone.misfit(at);
    const bool finished = engine.chains("without priors", first, 1, [&](std::size_t, run::Chain& chain) {
        const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
            problem::Evaluation e = chain.at(unit);
            if (!e.converged()) {
                return optimise::Answer::no_answer;
            }
            sample = run::sample_of(alone, e);
            if (const double misfit = sample.residuals.norm(); misfit < result.readings_misfit) {
                result.readings_misfit = misfit;
                at = std::move(e);
            }
            return optimise::Answer::computed;
        };
        optimise::SearchSettings settings;
        settings.enough = 0.005 * acceptance.variance;
        optimise::gauss_newton(best.unit, objective, settings);
    });
    if (!finished) {
        return std::nullopt;
    }
    result.readings_want = at.parameters;
    result.readings_alone = std::move(at);
    const double joint = problem.misfit(best.evaluation);
    result.statistic =
        std::max(0.0, joint * joint - result.readings_misfit * result.readings_misfit) / acceptance.variance;
    result.degrees_of_freedom = rank_of(without) + priors - rank_of(all);
    if (result.degrees_of_freedom > 0) {
        result.p_value = gsl_cdf_chisq_Q(result.statistic, result.degrees_of_freedom);
    }
    return result;
}

} // namespace explore::landscape

#include "landscape/prior_influence.h"

#include "inference/quantiles.h"
#include "landscape/rank.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The information on a parameter that may lie anywhere in its range: the inverse variance of the unit interval.
constexpr double box = 1.0 / inference::box_variance;

// Of every column of the rows j in standard deviations, the others known by their ranges alone.
VectorXd informations(const MatrixXd& j) {
    MatrixXd h = j.transpose() * j;
    h.diagonal().array() += box;
    return (h.inverse().diagonal().cwiseInverse().array() - box).cwiseMax(0.0);
}

} // namespace

std::optional<PriorInfluence> prior_influence(const problem::Problem& problem, const Acceptance& acceptance,
                                              const Minimum& best) {
    const auto priors = static_cast<int>(problem.priors().size());
    if (priors == 0) {
        return std::nullopt;
    }
    PriorInfluence result;
    const problem::Problem alone = problem.of_readings();
    MatrixXd all = problem.information_jacobian(best.evaluation);
    all.topRows(static_cast<Index>(problem.readings())) /= acceptance.noise();
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
    result.readings_alone = best.alone ? *best.alone : best.evaluation;
    result.readings_want = result.readings_alone.parameters;
    result.readings_misfit = alone.misfit(result.readings_alone);
    const double joint = problem.misfit(best.evaluation);
    result.statistic =
        std::max(0.0, joint * joint - result.readings_misfit * result.readings_misfit) / acceptance.variance;
    const auto active = static_cast<int>(problem.active_limits(best.evaluation).size());
    result.degrees_of_freedom = rank_of(without) + priors + active - rank_of(all);
    if (result.degrees_of_freedom > 0) {
        result.p_value = gsl_cdf_chisq_Q(result.statistic, result.degrees_of_freedom);
    }
    return result;
}

} // namespace explore::landscape

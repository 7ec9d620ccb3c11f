#include "landscape/next_measurement.h"

#include "inference/quantiles.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace explore::landscape {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<CandidateEffect> rank_candidates(const problem::Problem& problem, const Acceptance& acceptance,
                                             const Minimum& minimum, const MatrixXd& candidates,
                                             const MatrixXd& predictions) {
    const MatrixXd s = problem.information_jacobian(minimum.evaluation) / acceptance.noise();
    MatrixXd h = s.transpose() * s;
    h.diagonal().array() += 1.0 / inference::box_variance;
    const MatrixXd before = h.llt().solve(MatrixXd::Identity(h.rows(), h.cols()));
    std::vector<CandidateEffect> effects;
    for (Index i = 0; i < candidates.rows(); ++i) {
        const VectorXd row = candidates.row(i);
        const VectorXd c = before * row;
        const double told = 1.0 + row.dot(c);
        const MatrixXd after = before - c * c.transpose() / told; // Sherman-Morrison
        CandidateEffect effect;
        effect.candidate = static_cast<std::size_t>(i);
        effect.gain = 0.5 * std::log(told);
        for (Index k = 0; k < h.rows(); ++k) {
            effect.parameters.push_back(std::sqrt(after(k, k) / before(k, k)));
        }
        for (Index p = 0; p < predictions.rows(); ++p) {
            const VectorXd g = predictions.row(p);
            effect.predictions.push_back(std::sqrt(g.dot(after * g) / g.dot(before * g)));
        }
        effects.push_back(std::move(effect));
    }
    std::stable_sort(effects.begin(), effects.end(), [](const auto& a, const auto& b) { return a.gain > b.gain; });
    return effects;
}

} // namespace explore::landscape

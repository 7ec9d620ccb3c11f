#include "diagnose/open_directions.h"

#include "inference/quantiles.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace explore::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double open = 4.0; // of chi2, where the standard deviation of the box is crossed

class Looker {
public:
    Looker(const problem::Problem& problem, const Model& model, double variance, run::Chain& chain)
        : problem_(problem),
          model_(model),
          noise_(std::sqrt(variance)),
          chain_(chain),
          scale_(std::sqrt(inference::box_variance)),
          jacobian_(scale_ / noise_ * problem.residual_jacobian(model.evaluation)),
          at_(Eigen::Map<const VectorXd>(model.unit.data(), static_cast<Index>(model.unit.size()))) {
        const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(jacobian_.transpose() * jacobian_));
        weights_ = solver.eigenvalues().cwiseMax(0.0);
        directions_ = solver.eigenvectors();
        before_ = model.residuals.squaredNorm() / variance;
    }

    MatrixXd rows() {
        std::vector<VectorXd> found;
        for (Index i = 0; i < weights_.size() && weights_[i] < open; ++i) {
            std::vector<double> widths; // of the posterior, on both sides
            for (const double side : {1.0, -1.0}) {
                if (const auto weight = weight_along(side * directions_.col(i), weights_[i])) {
                    widths.push_back(1.0 / std::sqrt(1.0 + *weight));
                }
            }
            if (widths.empty()) {
                continue;
            }
            const double width = 0.5 * (widths.front() + widths.back());
            const double more = 1.0 / (width * width) - 1.0 - weights_[i];
            constexpr double worth = 0.5;
            if (more > worth) {
                found.push_back(std::sqrt(more) * noise_ / scale_ * directions_.col(i));
            }
        }
        MatrixXd rows(static_cast<Index>(found.size()), at_.size());
        for (std::size_t r = 0; r < found.size(); ++r) {
            rows.row(static_cast<Index>(r)) = found[r].transpose();
        }
        return rows;
    }

private:
    // Rise of chi2 over the square of the distance; nothing: the box ends there, or nothing has an answer.
    std::optional<double> weight_along(const VectorXd& direction, double first_order) {
        double distance = 1.0;
        for (Index k = 0; k < at_.size(); ++k) {
            const double slope = scale_ * direction[k];
            const double room = slope > 0.0 ? 1.0 - at_[k] : at_[k];
            if (std::abs(slope) > 1e-9) {
                distance = std::min(distance, room / std::abs(slope));
            }
        }
        constexpr double least = 0.1;
        constexpr double enough = 6.0; // of chi2: about where an interval ends
        constexpr int tries = 4;
        std::optional<double> found;
        for (int i = 0; i < tries && distance >= least; ++i) {
            const auto rise = rise_at(distance * direction);
            if (!rise) {
                distance *= 0.5;
                continue;
            }
            found = std::max(first_order, std::max(0.0, *rise) / (distance * distance));
            if (*rise <= enough) {
                break;
            }
            distance *= std::clamp(std::sqrt(0.5 * enough / *rise), 0.2, 0.8);
        }
        return found;
    }

    // Of chi2, so far from the fit, where the directions that are not open make the best of it.
    std::optional<double> rise_at(const VectorXd& away) {
        VectorXd point = (at_ + scale_ * away).cwiseMax(0.0).cwiseMin(1.0);
        std::optional<double> least;
        constexpr int corrections = 2;
        for (int i = 0; i <= corrections; ++i) {
            const auto evaluation = chain_.at({point.data(), static_cast<std::size_t>(point.size())}, false);
            if (!evaluation.converged()) {
                break;
            }
            const VectorXd residuals = problem_.residuals(evaluation) / noise_;
            const double rise = residuals.squaredNorm() - before_;
            constexpr double settled = 0.1;
            const bool is_settled = least && rise > *least - settled;
            least = std::min(rise, least.value_or(INFINITY));
            if (is_settled) {
                break;
            }
            VectorXd move = VectorXd::Zero(point.size());
            for (Index k = 0; k < weights_.size(); ++k) {
                if (weights_[k] >= open) {
                    move -= directions_.col(k) * (jacobian_ * directions_.col(k)).dot(residuals) / weights_[k];
                }
            }
            point = (point + scale_ * move).cwiseMax(0.0).cwiseMin(1.0);
        }
        return least;
    }

    const problem::Problem& problem_;
    const Model& model_;
    double noise_;
    run::Chain& chain_;
    double scale_; // a standard deviation of the box, the unit of distances here
    MatrixXd jacobian_;
    VectorXd at_;
    VectorXd weights_; // rising
    MatrixXd directions_;
    double before_ = 0.0; // chi2 at the fit
};

} // namespace

MatrixXd rows_of_open_directions(const problem::Problem& problem, const Model& model, double variance,
                                 run::Chain& chain) {
    return Looker(problem, model, variance, chain).rows();
}

} // namespace explore::diagnose

#include "landscape/held_ranges.h"

#include "optimise/linear_reach.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double damping = 1e-12;
constexpr double shows = 0.05; // of a range: less is not worth another form of it

// The readings near a minimum, and what is allowed there, as linear functions of a move.
class Allowed {
public:
    Allowed(const problem::Problem& problem, const Minimum& minimum, const LocalAnalysis& local, bool bounds_count)
        : quantile_(local.quantile()) {
        sample_.residuals = local.rest;
        sample_.jacobian = local.root;
        if (bounds_count && local.root.size() > 0) {
            bounds_ = minimum.on_bound;
        }
        if (local.root.size() == 0 || (problem.limits.empty() && bounds_.empty())) {
            return;
        }
        sample_.limits = problem.beyond_limits(minimum.evaluation);
        sample_.limit_jacobian = problem.limit_jacobian(minimum.evaluation);
        const VectorXd unit = Eigen::Map<const VectorXd>(minimum.unit.data(), static_cast<Index>(minimum.unit.size()));
        low_ = -unit;
        high_ = 1.0 - unit.array();
        inverse_ = local.root.completeOrthogonalDecomposition().pseudoInverse();
        centre_ = -inverse_ * local.rest;
        std::vector<std::size_t> numbers; // of the inequalities among all limits
        for (std::size_t i = 0; i < problem.limits.size(); ++i) {
            if (!problem.limits[i]->is_equality()) {
                numbers.push_back(i);
            }
        }
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            const VectorXd a = sample_.limit_jacobian.row(static_cast<Index>(i)).transpose();
            if (sample_.limits[static_cast<Index>(i)] + a.dot(centre_) + quantile_ * deviation(a) > 0.0) {
                reached_.push_back(numbers[i]);
            }
        }
        if (is_held()) {
            const optimise::LinearRows rows(sample_, none_);
            lowest_ = 2.0 * rows.half(rows.lowest(damping, low_, high_));
        }
    }

    const std::vector<std::size_t>& reached() const { return reached_; }
    const std::vector<BoundMet>& bounds() const { return bounds_; }
    bool is_held() const { return !reached_.empty() || !bounds_.empty(); }
    // Standard deviation of a linear function by the readings; infinity: they do not see it.
    double deviation(const VectorXd& gradient) const {
        const VectorXd seen = inverse_.transpose() * gradient;
        const double lost = (gradient - sample_.jacobian.transpose() * seen).norm();
        return lost > 1e-6 * gradient.norm() ? INFINITY : seen.norm();
    }

    // How far that function may move up (sign 1) or down (-1).
    double reach(const VectorXd& gradient, double sign) const {
        return optimise::LinearReach(sample_, low_, high_, gradient, damping)
            .until(sign, quantile_ * quantile_, lowest_)
            .change;
    }

    // Nothing: the range is the symmetric one.
    std::optional<HeldRange> range(const VectorXd& gradient) const {
        if (!is_held() || !(gradient.norm() > 0.0)) {
            return std::nullopt;
        }
        const HeldRange held{reach(gradient, -1.0), reach(gradient, 1.0)};
        const double half = quantile_ * deviation(gradient);
        const double width = held.high - held.low;
        const bool same = std::abs(held.low + half) < shows * width && std::abs(held.high - half) < shows * width;
        return same ? std::nullopt : std::optional(held);
    }

private:
    double quantile_;
    optimise::Sample sample_;
    VectorXd low_, high_;
    MatrixXd inverse_;
    VectorXd centre_; // the move to what the readings say by themselves
    std::vector<std::size_t> reached_;
    std::vector<BoundMet> bounds_;
    double lowest_ = 0.0; // sum of squares
    MatrixXd none_;
};

} // namespace

HeldRanges held_ranges(const problem::Problem& problem, const Minimum& minimum, const LocalAnalysis& local,
                       bool bounds_count) {
    const Allowed allowed(problem, minimum, local, bounds_count);
    HeldRanges ranges;
    const std::size_t count = minimum.unit.size();
    ranges.parameters.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
        const double at = minimum.unit[k];
        if (auto range = allowed.range(VectorXd::Unit(static_cast<Index>(count), static_cast<Index>(k)))) {
            ranges.parameters[k] = HeldRange{std::max(0.0, at + range->low), std::min(1.0, at + range->high)};
            ranges.limits = allowed.reached();
            ranges.bounds = allowed.bounds();
        }
    }
    return ranges;
}

std::optional<HeldRange> held_range(const problem::Problem& problem, const Minimum& minimum, const LocalAnalysis& local,
                                    const VectorXd& gradient, bool bounds_count) {
    return Allowed(problem, minimum, local, bounds_count).range(gradient);
}

} // namespace explore::landscape

#include "optimise/linear_reach.h"

#include <algorithm>
#include <cmath>

namespace explore::optimise {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double steep = 1e5; // how much stiffer than the rows the quantity is held

} // namespace

LinearReach::LinearReach(const Sample& rows, const VectorXd& low, const VectorXd& high, const VectorXd& gradient,
                         double damping)
    : plain_(rows),
      low_(low),
      high_(high),
      gradient_(gradient),
      damping_(damping),
      weight_(steep * std::max(1.0, rows.jacobian.norm()) / std::max(gradient.norm(), 1e-300)),
      held_(rows) {
    const Index last = rows.jacobian.rows();
    held_.jacobian.conservativeResize(last + 1, gradient.size());
    held_.jacobian.row(last) = weight_ * gradient.transpose();
    held_.residuals.conservativeResize(last + 1);
}

LinearReach::Move LinearReach::to(double change, double from) const {
    Sample held = held_;
    held.residuals[held.residuals.size() - 1] = -weight_ * change;
    Move move;
    move.d = LinearRows(held, none_).lowest(damping_, low_, high_);
    move.change = gradient_.dot(move.d);
    move.rise = 2.0 * LinearRows(plain_, none_).half(move.d) - from;
    move.slope = -2.0 * weight_ * weight_ * (move.change - change); // by the envelope theorem
    constexpr double room = 1e-3;
    if (std::abs(move.change - change) > room * std::abs(change)) { // there, what ends the room bears the pull
        constexpr double before = 0.99;
        move.slope = change * move.change > 0.0 ? to(before * move.change, from).slope : 0.0;
    }
    return move;
}

LinearReach::Move LinearReach::until(double sign, double rise, double from) const {
    double most = 0.0; // the farthest corner
    for (Index k = 0; k < gradient_.size(); ++k) {
        most += std::max(sign * gradient_[k] * low_[k], sign * gradient_[k] * high_[k]);
    }
    Move farthest = to(sign * most, from);
    if (farthest.rise <= rise) {
        return farthest;
    }
    double within = 0.0;
    double beyond = most;
    constexpr int halvings = 40;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (within + beyond);
        Move move = to(sign * middle, from);
        if (move.rise <= rise) {
            within = middle;
            farthest = std::move(move);
        } else {
            beyond = middle;
        }
    }
    return within > 0.0 ? farthest : to(0.0, from);
}

} // namespace explore::optimise

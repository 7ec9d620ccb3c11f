// The part of residuals that free parameters cannot absorb: they are a nuisance where something else is judged.
#pragma once

#include <Eigen/Dense>

#include <vector>

namespace explore::inference {

// Of the range of a parameter or a size: closer to an end it is at it.
constexpr double end_of_range = 1e-4;
// Whether a fit presses a coordinate against an end of its range. pull: of the sum of squares, which falls against it.
inline bool is_pressed(double unit, double pull) {
    return (unit < end_of_range && pull > 0.0) || (unit > 1.0 - end_of_range && pull < 0.0);
}

// Whether an interval unit -+ half reaches an end of the range beyond which more of an effect is possible: not where
// the effect is none, nor where no more exists.
inline bool reaches_end(double unit, double half, double none, bool high_is_limit) {
    constexpr double at_none = 1e-6;
    return (unit + half >= 1.0 && none < 1.0 - at_none && !high_is_limit) || (unit - half <= 0.0 && none > at_none);
}

// Directions that parameters follow, to first order: the span of the residuals' derivatives. Those that crossing the
// whole box moves by less than one standard deviation are not in it, nor are parameters that the fit presses against a
// bound.
class Nuisance {
public:
    // jacobian: residuals in standard deviations by unit coordinates.
    Nuisance(const Eigen::MatrixXd& jacobian, const std::vector<double>& unit, const Eigen::VectorXd& residuals);

    // The part that no parameter can follow.
    Eigen::VectorXd beyond(const Eigen::VectorXd& change) const;
    // The point of the cube at which the parameters make the best of these residuals.
    std::vector<double> best_response(const std::vector<double>& unit, const Eigen::VectorXd& residuals) const;
    int rank() const { return static_cast<int>(base_.cols()); }

private:
    Eigen::MatrixXd base_;    // orthonormal
    Eigen::MatrixXd inverse_; // parameters by residuals
};

} // namespace explore::inference

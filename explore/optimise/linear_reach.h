// How far a linear quantity can be moved while rows that are linear too, inequalities and bounds give way.
#pragma once

#include "optimise/linear_rows.h"

namespace explore::optimise {

class LinearReach {
public:
    struct Move {
        Eigen::VectorXd d;
        double change = 0.0; // of the quantity: gradient . d
        double rise = 0.0;   // of the sum of squares, from what it is counted
        double slope = 0.0;  // of the lowest rise by the change there
    };

    // rows: a sample with derivatives; low <= 0 <= high: of a step; gradient: of the quantity, not zero. damping: as in
    // LinearRows::lowest. What is taken must outlive this but for the gradient.
    LinearReach(const Sample& rows, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                const Eigen::VectorXd& gradient, double damping);

    // The lowest sum of squares with the quantity changed by that, or by as much of it as there is room for. from:
    // the sum of squares that a rise is counted from.
    Move to(double change, double from) const;
    // The farthest up (sign 1) or down (-1) at which the sum of squares has risen by no more.
    Move until(double sign, double rise, double from) const;

private:
    const Sample& plain_;
    const Eigen::VectorXd& low_;
    const Eigen::VectorXd& high_;
    Eigen::VectorXd gradient_;
    double damping_;
    double weight_;
    Sample held_; // with a row more, which holds the quantity
    Eigen::MatrixXd none_;
};

} // namespace explore::optimise

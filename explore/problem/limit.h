// A condition on parameters and responses that the answer must meet.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <string>

namespace explore::problem {

// g <= 0, or g = 0, where 1 is what still counts as met: a ten-thousandth of what g's sides can differ by. It enters
// the sum of squares as one more row, max(0, g) or g: a quadratic penalty so steep that a search ends beyond the
// condition by less than that tolerance where the readings pull by less than 1e4 of chi2 a tolerance.
class Limit {
public:
    virtual ~Limit() = default;
    virtual std::string text() const = 0; // as in the study
    virtual bool is_equality() const = 0;
    // parameters: physical; responses: SI. Not a number where the condition has no value.
    virtual double value(std::span<const double> parameters, std::span<const double> responses) const = 0;
    // d(value)/d(physical parameters); jacobian: responses x parameters.
    virtual Eigen::RowVectorXd gradient(std::span<const double> parameters, std::span<const double> responses,
                                        const Eigen::MatrixXd& jacobian) const = 0;
};

} // namespace explore::problem

// A calibration problem: where to look, what to compute, what to compare it with.
#pragma once

#include "problem/forward_function.h"
#include "problem/misfit.h"
#include "problem/parameter_space.h"

#include <limits>

namespace explore::problem {

// One evaluated point. Only `converged` has responses; the misfit of the others, and where there is nothing to compare
// with, is not a number on purpose.
struct Evaluation {
    std::vector<double> parameters; // physical
    pave::Status status = pave::Status::failed;
    std::string reason; // when not converged
    std::vector<double> responses;
    Eigen::MatrixXd jacobian; // responses x parameters, physical; empty unless asked for
    std::vector<std::string> warnings;
    double misfit = std::numeric_limits<double>::quiet_NaN();

    bool converged() const { return status == pave::Status::converged; }
};

struct Problem {
    ParameterSpace space;
    std::shared_ptr<const ForwardFunction> function;
    Misfit misfit;

    // unit: a point of the unit cube.
    Evaluation evaluate(std::span<const double> unit, bool with_jacobian, ForwardFunction::Workspace& workspace) const;

    // d(residuals)/d(unit coordinates) of an evaluation with a jacobian.
    Eigen::MatrixXd residual_jacobian(const Evaluation& evaluation) const;
};

} // namespace explore::problem

#include "problem/problem.h"

#include <cmath>

namespace explore::problem {

Evaluation Problem::evaluate(std::span<const double> unit, bool with_jacobian,
                             ForwardFunction::Workspace& workspace) const {
    Evaluation e;
    e.parameters = space.physical(unit);
    auto outcome = function->evaluate(e.parameters, with_jacobian, workspace);
    e.status = outcome.status();
    if (!outcome) {
        e.reason = outcome.failure().reason;
        return e;
    }
    Prediction prediction = std::move(outcome).value();
    e.responses = std::move(prediction.responses);
    e.jacobian = std::move(prediction.jacobian);
    e.warnings = std::move(prediction.warnings);
    if (misfit.size() > 0) {
        e.misfit = misfit.residuals(e.responses).norm();
        if (!std::isfinite(e.misfit)) {
            Evaluation without_answer;
            without_answer.parameters = std::move(e.parameters);
            without_answer.reason =
                "the misfit is no number: the noise of a reading, or the reading that its residual is relative to, "
                "is next to nothing";
            return without_answer;
        }
    }
    return e;
}

Eigen::MatrixXd Problem::residual_jacobian(const Evaluation& evaluation) const {
    const Eigen::VectorXd slopes = misfit.slopes(evaluation.responses);
    Eigen::MatrixXd j(slopes.size(), evaluation.jacobian.cols());
    for (Eigen::Index i = 0; i < j.rows(); ++i) {
        const std::size_t response = misfit.terms()[static_cast<std::size_t>(i)].response;
        j.row(i) = slopes[i] * evaluation.jacobian.row(static_cast<Eigen::Index>(response));
    }
    for (Eigen::Index k = 0; k < j.cols(); ++k) {
        const Axis& axis = space.axes[static_cast<std::size_t>(k)];
        j.col(k) *= axis.d_physical(axis.unit(evaluation.parameters[static_cast<std::size_t>(k)]));
    }
    return j;
}

} // namespace explore::problem

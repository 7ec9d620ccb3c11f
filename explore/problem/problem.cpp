#include "problem/problem.h"

#include <algorithm>
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
    e.in_place_of_reduced = prediction.in_place_of_reduced;
    if (readings() > 0) {
        e.misfit = misfit(e);
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

double Problem::log_density(const Evaluation& evaluation) const {
    return evaluation.converged() ? misfit_.log_normaliser() - 0.5 * residuals(evaluation).squaredNorm()
                                  : -std::numeric_limits<double>::infinity();
}

Eigen::MatrixXd Problem::residual_jacobian(const Evaluation& evaluation) const {
    const Eigen::VectorXd slopes = misfit_.slopes(evaluation.responses);
    Eigen::MatrixXd j(slopes.size(), evaluation.jacobian.cols());
    for (Eigen::Index i = 0; i < j.rows(); ++i) {
        const std::size_t response = response_of(static_cast<std::size_t>(i));
        j.row(i) = slopes[i] * evaluation.jacobian.row(static_cast<Eigen::Index>(response));
    }
    if (misfit_.is_correlated()) {
        j = misfit_.whitened(std::move(j));
    }
    for (Eigen::Index k = 0; k < j.cols(); ++k) {
        const Axis& axis = space.axes[static_cast<std::size_t>(k)];
        j.col(k) *= axis.d_physical(axis.unit(evaluation.parameters[static_cast<std::size_t>(k)]));
    }
    return j;
}

Eigen::VectorXd Problem::change_by(std::size_t i) const {
    return misfit_.whitened(Eigen::VectorXd::Unit(static_cast<Eigen::Index>(readings()), static_cast<Eigen::Index>(i)));
}

Problem Problem::setting_apart(const std::vector<char>& readings) const {
    std::vector<Misfit::Term> terms(misfit_.terms().begin(), misfit_.terms().end());
    for (std::size_t i = 0; i < terms.size(); ++i) {
        terms[i].place.load = readings[i] != 0 ? -1 : terms[i].place.load;
    }
    return {space, function, {misfit_.kind(), std::move(terms)}};
}

bool Problem::noise_is_stated() const {
    const auto terms = misfit_.terms();
    return !terms.empty() && std::all_of(terms.begin(), terms.end(), [](const auto& t) { return t.noise.is_stated(); });
}

Eigen::VectorXd Problem::noise(const Evaluation& evaluation) const {
    Eigen::VectorXd noise = misfit_.slopes(evaluation.responses);
    for (Eigen::Index i = 0; i < noise.size(); ++i) {
        const Misfit::Term& term = misfit_.terms()[static_cast<std::size_t>(i)];
        noise[i] *= term.noise.deviation(evaluation.responses[term.response]);
    }
    return noise;
}

Problem Problem::with_readings(const std::vector<std::size_t>& residuals) const {
    std::vector<Misfit::Term> terms;
    terms.reserve(residuals.size());
    for (const std::size_t i : residuals) {
        terms.push_back(misfit_.terms()[i]);
    }
    return {space, function, {misfit_.kind(), std::move(terms)}};
}

Problem Problem::in_units_of_noise() const {
    if (!noise_is_stated()) {
        return *this;
    }
    std::vector<Misfit::Term> terms(misfit_.terms().begin(), misfit_.terms().end());
    for (Misfit::Term& term : terms) {
        term.factor = 1.0;
    }
    return {space, function, {MisfitKind::noise, std::move(terms)}};
}

} // namespace explore::problem

#include "problem/problem.h"

#include "base/over_time.h"
#include "base/passing_failure.h"
#include "problem/noise_scale.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace explore::problem {
namespace {

// Derivatives by physical parameters, a column each, to those by unit coordinates.
void by_unit(const ParameterSpace& space, const std::vector<double>& parameters, Eigen::MatrixXd& derivatives) {
    for (Eigen::Index k = 0; k < derivatives.cols(); ++k) {
        const Axis& axis = space.axes[static_cast<std::size_t>(k)];
        derivatives.col(k) *= axis.d_physical(axis.unit(parameters[static_cast<std::size_t>(k)]));
    }
}

// L of the correlation matrix L L' of these priors; empty: they are independent.
Eigen::MatrixXd prior_root(const ParameterSpace& space, const std::vector<std::size_t>& known) {
    if (space.prior_correlations.empty()) {
        return {};
    }
    const auto n = static_cast<Eigen::Index>(known.size());
    Eigen::MatrixXd r = Eigen::MatrixXd::Identity(n, n);
    for (const PriorCorrelation& tie : space.prior_correlations) {
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index j = 0; j < n; ++j) {
                if (space.axes[known[static_cast<std::size_t>(i)]].name == tie.a &&
                    space.axes[known[static_cast<std::size_t>(j)]].name == tie.b) {
                    r(i, j) = r(j, i) = tie.value;
                }
            }
        }
    }
    return r.llt().matrixL();
}

std::string why_no_number(const Problem& problem, const Evaluation& e) {
    for (const auto& limit : problem.limits) {
        if (!std::isfinite(limit->value(e.parameters, e.responses))) {
            return "the constraint \"" + limit->text() + "\" has no value here";
        }
    }
    return "the misfit is not a number: the noise of a reading, or the reading that its residual is relative to, is "
           "next to nothing";
}

} // namespace

Evaluation Problem::evaluate(std::span<const double> unit, bool with_jacobian,
                             ForwardFunction::Workspace& workspace) const {
    std::vector<double> parameters = space.physical(unit);
    auto outcome = function->evaluate(parameters, with_jacobian, workspace);
    return evaluation_of(std::move(parameters), std::move(outcome));
}

std::vector<Evaluation> Problem::evaluate_many(std::span<const std::vector<double>> units, bool with_jacobian,
                                               ForwardFunction::Workspace& workspace) const {
    std::vector<std::vector<double>> points;
    for (const auto& unit : units) {
        points.push_back(space.physical(unit));
    }
    auto outcomes = function->evaluate_many(points, with_jacobian, workspace);
    std::vector<Evaluation> evaluations;
    for (std::size_t i = 0; i < points.size(); ++i) {
        evaluations.push_back(evaluation_of(std::move(points[i]), std::move(outcomes[i])));
    }
    return evaluations;
}

Evaluation Problem::evaluation_of(std::vector<double> parameters, pave::Outcome<Prediction> outcome) const {
    Evaluation e;
    e.parameters = std::move(parameters);
    e.status = outcome.status();
    if (!outcome) {
        e.reason = outcome.failure().reason;
        e.over_time = pave::is_over_time(e.reason) || pave::is_passing(e.reason);
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
            without_answer.reason = why_no_number(*this, e);
            without_answer.parameters = std::move(e.parameters);
            return without_answer;
        }
    }
    return e;
}

std::vector<std::size_t> Problem::priors() const {
    std::vector<std::size_t> list;
    for (std::size_t k = 0; with_priors_ && k < space.axes.size(); ++k) {
        if (space.axes[k].prior) {
            list.push_back(k);
        }
    }
    return list;
}

Eigen::VectorXd Problem::residuals(const Evaluation& evaluation) const {
    const Eigen::VectorXd of_readings = misfit_.residuals(evaluation.responses);
    const auto known = priors();
    Eigen::VectorXd all(of_readings.size() + static_cast<Eigen::Index>(known.size() + limits.size()));
    all.head(of_readings.size()) = of_readings;
    for (std::size_t i = 0; i < known.size(); ++i) {
        all[of_readings.size() + static_cast<Eigen::Index>(i)] =
            space.axes[known[i]].pull(evaluation.parameters[known[i]]);
    }
    if (const Eigen::MatrixXd root = prior_root(space, known); root.size() > 0) {
        root.triangularView<Eigen::Lower>().solveInPlace(all.segment(of_readings.size(), root.rows()));
    }
    Eigen::Index row = all.size() - static_cast<Eigen::Index>(limits.size());
    for (const auto& limit : limits) {
        const double value = limit->value(evaluation.parameters, evaluation.responses);
        all[row++] = limit->is_equality() || !(value < 0.0) ? value : 0.0; // what is not a number stays so
    }
    return all;
}

std::vector<std::size_t> Problem::active_limits(const Evaluation& evaluation) const {
    constexpr double near = -10.0;
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < limits.size(); ++i) {
        if (limits[i]->is_equality() || limits[i]->value(evaluation.parameters, evaluation.responses) > near) {
            active.push_back(i);
        }
    }
    return active;
}

std::vector<std::size_t> Problem::broken_limits(const Evaluation& evaluation) const {
    constexpr double gives_way = 100.0;
    std::vector<std::size_t> broken;
    for (std::size_t i = 0; i < limits.size(); ++i) {
        const double value = limits[i]->value(evaluation.parameters, evaluation.responses);
        if (!((limits[i]->is_equality() ? std::abs(value) : value) <= gives_way)) {
            broken.push_back(i);
        }
    }
    return broken;
}

Eigen::RowVectorXd Problem::limit_gradient(const Limit& limit, const Evaluation& evaluation) const {
    Eigen::MatrixXd row = limit.gradient(evaluation.parameters, evaluation.responses, evaluation.jacobian);
    by_unit(space, evaluation.parameters, row);
    return row;
}

Eigen::VectorXd Problem::beyond_limits(const Evaluation& evaluation) const {
    Eigen::VectorXd values(static_cast<Eigen::Index>(limits.size()));
    Eigen::Index count = 0;
    for (const auto& limit : limits) {
        if (!limit->is_equality()) {
            values[count++] = limit->value(evaluation.parameters, evaluation.responses);
        }
    }
    return values.head(count);
}

Eigen::MatrixXd Problem::limit_jacobian(const Evaluation& evaluation) const {
    Eigen::MatrixXd j(static_cast<Eigen::Index>(limits.size()), static_cast<Eigen::Index>(space.axes.size()));
    Eigen::Index count = 0;
    for (const auto& limit : limits) {
        if (!limit->is_equality()) {
            j.row(count++) = limit_gradient(*limit, evaluation);
        }
    }
    return j.topRows(count);
}

std::vector<Eigen::Index> Problem::limit_rows() const {
    std::vector<Eigen::Index> numbers;
    for (std::size_t i = 0; i < limits.size(); ++i) {
        if (!limits[i]->is_equality()) {
            numbers.push_back(static_cast<Eigen::Index>(rows() - limits.size() + i));
        }
    }
    return numbers;
}

double Problem::log_density(const Evaluation& evaluation) const {
    if (!evaluation.converged()) {
        return -std::numeric_limits<double>::infinity();
    }
    const Eigen::VectorXd rows = residuals(evaluation);
    const auto of_readings = static_cast<Eigen::Index>(readings());
    const double sum = rows.head(of_readings).squaredNorm();
    double log = misfit_.log_normaliser() - 0.5 * rows.tail(rows.size() - of_readings).squaredNorm() +
                 (noise_scale_is_sought() ? log_of_sought_scale(sum, readings()) : -0.5 * sum);
    const auto below = [](double pull) { return 0.5 * std::erfc(-pull / std::numbers::sqrt2); };
    for (const std::size_t k : priors()) { // normal within the box, over what is uniform in it
        const Axis& axis = space.axes[k];
        log += std::log(axis.d_pull() / std::sqrt(2.0 * std::numbers::pi)) -
               std::log(below(axis.pull(axis.high)) - below(axis.pull(axis.low)));
    }
    if (const Eigen::MatrixXd root = prior_root(space, priors()); root.size() > 0) {
        log -= root.diagonal().array().log().sum();
    }
    return log;
}

Eigen::MatrixXd Problem::residual_jacobian(const Evaluation& evaluation) const {
    return rows_by_unit(evaluation, misfit_.loss_slopes(evaluation.responses));
}

Eigen::MatrixXd Problem::information_jacobian(const Evaluation& evaluation) const {
    return rows_by_unit(evaluation, misfit_.loss_information(evaluation.responses));
}

Eigen::MatrixXd Problem::rows_by_unit(const Evaluation& evaluation, const Eigen::VectorXd& loss) const {
    const Eigen::VectorXd slopes = misfit_.slopes(evaluation.responses);
    Eigen::MatrixXd j(slopes.size(), evaluation.jacobian.cols());
    for (Eigen::Index i = 0; i < j.rows(); ++i) {
        const std::size_t response = response_of(static_cast<std::size_t>(i));
        j.row(i) = slopes[i] * evaluation.jacobian.row(static_cast<Eigen::Index>(response));
    }
    if (misfit_.is_correlated()) {
        j = misfit_.whitened(std::move(j));
    }
    j.array().colwise() *= loss.array();
    by_unit(space, evaluation.parameters, j);
    const auto known = priors();
    const Eigen::Index of_readings = j.rows();
    j.conservativeResize(of_readings + static_cast<Eigen::Index>(known.size() + limits.size()), Eigen::NoChange);
    for (std::size_t i = 0; i < known.size(); ++i) {
        j.row(of_readings + static_cast<Eigen::Index>(i)).setZero();
        j(of_readings + static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(known[i])) =
            space.axes[known[i]].d_pull();
    }
    if (const Eigen::MatrixXd root = prior_root(space, known); root.size() > 0) {
        auto rows_of_priors = j.middleRows(of_readings, root.rows());
        root.triangularView<Eigen::Lower>().solveInPlace(rows_of_priors);
    }
    Eigen::Index row = j.rows() - static_cast<Eigen::Index>(limits.size());
    for (const auto& limit : limits) {
        const bool counts = limit->is_equality() || limit->value(evaluation.parameters, evaluation.responses) > 0.0;
        j.row(row++) =
            counts ? limit_gradient(*limit, evaluation) : Eigen::RowVectorXd(Eigen::RowVectorXd::Zero(j.cols()));
    }
    return j;
}

Problem Problem::with_misfit(Misfit misfit) const {
    Problem other(space, function, std::move(misfit));
    other.limits = limits;
    other.with_priors_ = with_priors_;
    return other;
}

Problem Problem::without_priors() const {
    Problem other = *this;
    other.with_priors_ = false;
    return other;
}

Problem Problem::of_readings() const {
    Problem other = without_priors();
    other.limits.clear();
    return other;
}

Eigen::VectorXd Problem::change_by(std::size_t i) const {
    const auto count = static_cast<Eigen::Index>(readings());
    Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rows()));
    change.head(count) = misfit_.whitened(Eigen::VectorXd::Unit(count, static_cast<Eigen::Index>(i)));
    return change;
}

Eigen::VectorXd Problem::change_by_gain(std::size_t i, const Evaluation& evaluation) const {
    const double slope = misfit_.slopes(evaluation.responses)[static_cast<Eigen::Index>(i)];
    Eigen::VectorXd change = slope * evaluation.responses[response_of(i)] * change_by(i);
    change.head(static_cast<Eigen::Index>(readings())).array() *= misfit_.loss_slopes(evaluation.responses).array();
    return change;
}

Problem Problem::setting_apart(const std::vector<char>& readings) const {
    std::vector<Misfit::Term> terms(misfit_.terms().begin(), misfit_.terms().end());
    for (std::size_t i = 0; i < terms.size(); ++i) {
        terms[i].place.load = readings[i] != 0 ? -1 : terms[i].place.load;
    }
    return with_misfit({misfit_.kind(), std::move(terms)});
}

bool Problem::noise_is_stated() const {
    const auto terms = misfit_.terms();
    return !terms.empty() && !noise_scale_is_sought() &&
           std::all_of(terms.begin(), terms.end(), [](const auto& t) { return t.noise.is_stated(); });
}

bool Problem::noise_scale_is_sought() const {
    return !misfit_.terms().empty() && misfit_.terms()[0].noise.scale_is_sought;
}

double Problem::noise_scale(const Evaluation& evaluation) const {
    return noise_scale_is_sought()
               ? std::sqrt(sought_variance(misfit_.residuals(evaluation.responses).squaredNorm(), readings()))
               : 1.0;
}

Eigen::VectorXd Problem::noise(const Evaluation& evaluation) const {
    Eigen::VectorXd noise = misfit_.slopes(evaluation.responses);
    for (Eigen::Index i = 0; i < noise.size(); ++i) {
        const Misfit::Term& term = misfit_.terms()[static_cast<std::size_t>(i)];
        noise[i] *= term.noise.deviation(evaluation.responses[term.response]);
    }
    const auto of_readings = noise.size();
    noise.conservativeResize(static_cast<Eigen::Index>(rows()));
    noise.tail(noise.size() - of_readings).setOnes();
    return noise;
}

Eigen::VectorXd Problem::noise_rows(const Evaluation& evaluation, Eigen::VectorXd deviates) const {
    if (misfit_.kind() != MisfitKind::noise || noise_is_correlated() || noise_is_student()) {
        return deviates;
    }
    for (std::size_t i = 0; i < readings(); ++i) {
        const Misfit::Term& term = misfit_.terms()[i];
        const double value = evaluation.responses[term.response];
        double& row = deviates[static_cast<Eigen::Index>(i)];
        if (term.noise.relative > 0.0) {
            row = term.noise.residual(value, value - row * term.noise.deviation(value));
        }
    }
    return deviates;
}

Problem Problem::with_readings(const std::vector<std::size_t>& residuals) const {
    std::vector<Misfit::Term> terms;
    terms.reserve(residuals.size());
    for (const std::size_t i : residuals) {
        terms.push_back(misfit_.terms()[i]);
    }
    return with_misfit({misfit_.kind(), std::move(terms)}).without_priors();
}

Problem Problem::in_units_of_noise() const {
    if (!noise_is_stated()) {
        return *this;
    }
    std::vector<Misfit::Term> terms(misfit_.terms().begin(), misfit_.terms().end());
    for (Misfit::Term& term : terms) {
        term.factor = 1.0;
    }
    return with_misfit({MisfitKind::noise, std::move(terms)});
}

} // namespace explore::problem

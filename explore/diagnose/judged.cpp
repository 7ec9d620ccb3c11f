#include "diagnose/judged.h"

#include "inference/nuisance.h"
#include "inference/quantiles.h"
#include "problem/censored.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <optional>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool Judged::ends_range(std::size_t member) const {
    const double size = model.unit[model.unit.size() - model.members.size() + member];
    return size < inference::end_of_range || size > 1.0 - inference::end_of_range;
}

bool Judged::ends_range() const {
    for (std::size_t m = 0; m < model.members.size(); ++m) {
        if (ends_range(m)) {
            return true;
        }
    }
    return false;
}

double aicc(double sum, std::size_t readings, std::size_t parameters, bool noise_is_stated) {
    const auto k = static_cast<double>(parameters);
    if (noise_is_stated) {
        return sum + 2.0 * k;
    }
    const auto n = static_cast<double>(readings);
    const double free = k + 1.0;
    return n * std::log(std::max(sum, 1e-300) / n) + 2.0 * free +
           (n > free + 1.0 ? 2.0 * free * (free + 1.0) / (n - free - 1.0) : INFINITY);
}

Interval interval_within(const problem::Axis& axis, double unit, double variance) {
    const double half = inference::two_sided_95 * std::sqrt(variance);
    return {axis.physical(unit), axis.physical(std::clamp(unit - half, 0.0, 1.0)),
            axis.physical(std::clamp(unit + half, 0.0, 1.0))};
}

namespace {

// The derivatives of the residuals with what they do not see.
MatrixXd with_open_rows(MatrixXd jacobian, const Model& model) {
    const Index seen = jacobian.rows();
    jacobian.conservativeResize(seen + model.open_rows.rows(), Eigen::NoChange);
    jacobian.bottomRows(jacobian.rows() - seen) = model.open_rows;
    return jacobian;
}

} // namespace

MatrixXd covariance_of(const problem::Problem& problem, const Model& model, double variance) {
    const MatrixXd j = with_open_rows(problem.residual_jacobian(model.evaluation), model);
    MatrixXd h = j.transpose() * j / variance;
    // A parameter on a bound gives way no further; the box is known beforehand.
    constexpr double weak = 0.01;
    h.diagonal().array() += weak / inference::box_variance;
    return h.llt().solve(MatrixXd::Identity(h.rows(), h.cols()));
}

Interval interval_of(const problem::Problem& problem, const Model& model, std::size_t axis, double variance) {
    const auto k = static_cast<Index>(axis);
    return interval_within(problem.space.axes[axis], model.unit[axis], covariance_of(problem, model, variance)(k, k));
}

inference::Nuisance Judge::nuisance_of(const Model& model, double variance) const {
    const double noise = std::sqrt(variance);
    return {bench_.problem(model.members)->residual_jacobian(model.evaluation) / noise, model.unit,
            model.residuals / noise};
}

namespace {

// 95 % interval of a size by which the model's answer at a reading is moved that is a limit: from the end of its range
// on the side where the limit is kept to where chi2 is larger by what one number may take. row: the residual there,
// rate: its derivative by the unit coordinate (problem/censored.h). Nothing: it is kept by so much that no end is seen.
std::optional<Interval> interval_of_limit(const problem::Axis& axis, double unit, double row, double rate) {
    const auto beyond = [](double of_row) { return -gsl_cdf_ugaussian_Pinv(std::exp(-0.5 * of_row * of_row)); };
    const double z = beyond(row);
    const double by_unit = std::copysign(1.0, row) * rate / problem::censored_row_slope(z, data::Censored::below);
    if (!std::isfinite(z) || !std::isfinite(by_unit) || by_unit == 0.0) {
        return std::nullopt;
    }
    const double end = std::clamp(unit + (beyond(inference::two_sided_95) - z) / by_unit, 0.0, 1.0);
    const double low = axis.physical(by_unit > 0.0 ? 0.0 : end);
    return Interval{axis.physical(unit), low, axis.physical(by_unit > 0.0 ? end : 1.0)};
}

} // namespace

Judged Judge::judge(Model model, double variance) const {
    Judged j;
    const auto problem = bench_.problem(model.members);
    const double noise = std::sqrt(variance);
    const MatrixXd with_open = with_open_rows(problem->residual_jacobian(model.evaluation), model) / noise;
    const MatrixXd jacobian = with_open.topRows(with_open.rows() - model.open_rows.rows());
    const inference::Nuisance nuisance(jacobian, model.unit, model.residuals / noise);
    j.chi2 = model.sum / variance;
    const std::size_t rows = drawn(model);
    j.dof = static_cast<int>(rows) - nuisance.rank();
    if (noise_is_stated_ && j.dof > 0) {
        j.p_value = gsl_cdf_chisq_Q(j.chi2, j.dof);
    }
    j.aicc = aicc(model.sum, rows, model.unit.size(), noise_is_stated_);
    j.pattern = test_pattern(model.residuals / noise, nuisance, groups_);
    const std::size_t parameters = model.unit.size() - model.members.size();
    auto prior = hypotheses::Prior::of_parameters(static_cast<Index>(parameters));
    for (std::size_t m = 0; m < model.members.size(); ++m) {
        const Candidate& candidate = candidates_[model.members[m]];
        const auto column = static_cast<Index>(parameters + m);
        double typical = candidate.typical;
        if (candidate.reading) {
            // A gross error is a share of the reading, or ten times its noise where next to nothing is to be read.
            constexpr double gross = 10.0;
            const double moves = jacobian.col(column).norm(); // standard deviations by the unit coordinate
            typical = candidate.null + std::max(typical - candidate.null, moves > 0.0 ? gross / moves : 0.0);
        }
        if (candidate.is_layout) {
            prior.add_layout(candidate.null, typical, model.unit[parameters + m]);
        } else {
            prior.add_size(candidate.null, typical, model.unit[parameters + m]);
        }
    }
    if (!model.members.empty()) {
        const MatrixXd known = covariance_of(*problem, model, variance);
        const MatrixXd information = with_open.transpose() * with_open + prior.precision;
        const MatrixXd covariance = information.llt().solve(MatrixXd::Identity(information.rows(), information.cols()));
        for (std::size_t m = 0; m < model.members.size(); ++m) {
            const auto at = static_cast<Index>(parameters + m);
            const double size = model.unit[parameters + m];
            const double deviation = std::sqrt(covariance(at, at));
            prior.cut_off(size, deviation);
            const Candidate& candidate = candidates_[model.members[m]];
            const problem::Axis& axis = problem->space.axes[parameters + m];
            std::optional<Interval> of_limit;
            if (candidate.is_of_limit) {
                const auto row = static_cast<Index>(*candidate.reading);
                of_limit = interval_of_limit(axis, size, model.residuals[row] / noise, jacobian(row, at));
            }
            j.sizes.push_back(of_limit ? *of_limit : interval_within(axis, size, known(at, at)));
            const bool ends = inference::reaches_end(size, inference::two_sided_95 * deviation, candidate.null,
                                                     candidate.high_is_limit);
            j.at_end = j.at_end || (ends && !candidate.is_of_limit);
        }
    }
    j.evidence = hypotheses::evidence(j.chi2, static_cast<Index>(rows), with_open, prior, noise_prior());
    j.model = std::move(model);
    return j;
}

} // namespace explore::diagnose

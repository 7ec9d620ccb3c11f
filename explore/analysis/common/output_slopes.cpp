#include "analysis/common/output_slopes.h"

#include "analysis/common/mesh_error.h"
#include "base/error.h"
#include "inference/quantiles.h"
#include "landscape/held_ranges.h"

#include <algorithm>
#include <cmath>

namespace explore::analysis {

using diagnose::Said;
using diagnose::Slopes;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<Slopes> slopes_of(const problem::Problem& problem, const VectorXd& at, const problem::Evaluation& e,
                                const std::vector<std::size_t>& outputs, double noise) {
    if (!e.converged()) {
        return std::nullopt;
    }
    Slopes slopes{.at = at,
                  .residuals = problem.residuals(e) / noise,
                  .rows = problem.residual_jacobian(e) / noise,
                  .outputs = VectorXd(static_cast<Index>(outputs.size())),
                  .output_rows = MatrixXd(static_cast<Index>(outputs.size()), at.size())};
    for (Index o = 0; o < slopes.outputs.size(); ++o) {
        const std::size_t row = outputs[static_cast<std::size_t>(o)];
        slopes.outputs[o] = std::log(std::abs(e.responses[row]));
        for (Index k = 0; k < at.size(); ++k) {
            const auto axis = static_cast<std::size_t>(k);
            slopes.output_rows(o, k) =
                e.jacobian(static_cast<Index>(row), k) * problem.space.axes[axis].d_physical(at[k]) / e.responses[row];
        }
    }
    const bool is_finite = slopes.residuals.allFinite() && slopes.rows.allFinite() && slopes.outputs.allFinite() &&
                           slopes.output_rows.allFinite();
    return is_finite ? std::optional(std::move(slopes)) : std::nullopt;
}

void hold_bounds(Slopes& slopes, const std::vector<double>& unit) {
    for (const landscape::BoundMet& bound : landscape::bounds_met(unit)) {
        slopes.rows.col(static_cast<Index>(bound.axis)).setZero();
        slopes.output_rows.col(static_cast<Index>(bound.axis)).setZero();
    }
}

VectorXd mesh_errors(const study::Study& study, const problem::Problem& plain, const Slopes& right,
                     const problem::Evaluation& best, const std::vector<std::size_t>& outputs, double noise) {
    VectorXd errors = VectorXd::Zero(static_cast<Index>(outputs.size()));
    const auto refined = on_finer_mesh(study);
    if (!refined) {
        return errors;
    }
    try {
        const problem::Problem finer = study::make_problem(*refined, study::Scope::everything);
        const auto outcome = finer.function->evaluate(best.parameters, false, *finer.function->make_workspace());
        const double ratio = refined->model.settings.refine / study.model.settings.refine;
        if (!outcome) {
            return errors;
        }
        problem::Evaluation there = best;
        there.responses = outcome->responses;
        const VectorXd moved = plain.residuals(there) / noise - right.residuals;
        MatrixXd information = right.rows.transpose() * right.rows;
        information.diagonal().array() += 1.0 / inference::box_variance;
        VectorXd step = VectorXd::Zero(information.rows());
        if (moved.allFinite()) {
            step = -information.llt().solve(right.rows.transpose() * moved);
        }
        const VectorXd followed = right.output_rows * step;
        for (Index o = 0; o < errors.size(); ++o) {
            const std::size_t row = outputs[static_cast<std::size_t>(o)];
            const double change = std::log(std::abs(outcome->responses[row] / best.responses[row])) + followed[o];
            errors[o] = std::isfinite(change) ? change / (1.0 - 1.0 / (ratio * ratio)) : 0.0;
        }
    } catch (const pave::Error&) { // too large
    }
    return errors;
}

Right right_at(const problem::Problem& plain, const Said& here, const problem::Evaluation& best,
               const std::vector<std::vector<double>>& others, const std::vector<std::size_t>& outputs, double noise) {
    Right right;
    const auto add = [&](const Said& said, const problem::Evaluation& e) {
        VectorXd values(static_cast<Index>(outputs.size()));
        for (Index o = 0; o < values.size(); ++o) {
            values[o] = e.responses[outputs[static_cast<std::size_t>(o)]];
        }
        right.said.push_back(said);
        right.values.push_back(std::move(values));
    };
    add(here, best);
    for (const std::vector<double>& unit : others) {
        const auto n = static_cast<Index>(unit.size());
        const problem::Evaluation e = plain.evaluate(unit, true, *plain.function->make_workspace());
        if (auto slopes = slopes_of(plain, Eigen::Map<const VectorXd>(unit.data(), n), e, outputs, noise)) {
            hold_bounds(*slopes, unit);
            add(diagnose::say(*slopes, n, VectorXd(0), MatrixXd(0, 0)), e);
        }
    }
    return right;
}

RangeAtBound::RangeAtBound(const problem::Problem& plain, const Slopes& unbounded, const problem::Evaluation& best,
                           double noise)
    : plain_(plain),
      slopes_(unbounded),
      there_(landscape::minimum_at(best, {unbounded.at.begin(), unbounded.at.end()})) {
    if (!there_.on_bound.empty()) {
        local_ = landscape::analyse(there_, plain, std::max(1.0, noise));
    }
}

std::optional<std::pair<double, double>> RangeAtBound::of(Index output, double value, double mesh) const {
    const auto held =
        local_ ? landscape::held_range(plain_, there_, *local_, slopes_.output_rows.row(output).transpose(), true)
               : std::nullopt;
    if (!held) {
        return std::nullopt;
    }
    const double of_mesh = inference::two_sided_95 * mesh;
    return std::minmax(
        {value * std::exp(-std::hypot(held->low, of_mesh)), value * std::exp(std::hypot(held->high, of_mesh))});
}

std::pair<double, double> range_if_right(const Right& right, Index output, double mesh, double tail) {
    const double first = right.values[0][output];
    double most = -INFINITY;
    for (const Said& said : right.said) {
        most = std::max(most, said.log_evidence);
    }
    std::vector<double> weights, means, deviations;
    double sum = 0.0;
    for (std::size_t m = 0; m < right.said.size(); ++m) {
        if (right.values[m][output] * first > 0.0) {
            weights.push_back(std::exp(right.said[m].log_evidence - most));
            means.push_back(std::log(right.values[m][output] / first));
            deviations.push_back(std::hypot(right.said[m].deviation[output], mesh));
            sum += weights.back();
        }
    }
    for (double& weight : weights) {
        weight /= sum;
    }
    const double a = first * std::exp(std::min(0.0, diagnose::mixture_quantile(weights, means, deviations, tail)));
    const double b =
        first * std::exp(std::max(0.0, diagnose::mixture_quantile(weights, means, deviations, 1.0 - tail)));
    double low = std::min(a, b);
    double high = std::max(a, b);
    for (std::size_t m = 0; m < right.said.size(); ++m) {
        const double value = right.values[m][output];
        constexpr double counts = 0.025;
        if (value * first < 0.0 && std::exp(right.said[m].log_evidence - most) > counts) {
            const double half = inference::two_sided_95 * right.said[m].deviation[output];
            low = std::min({low, value * std::exp(half), value * std::exp(-half)});
            high = std::max({high, value * std::exp(half), value * std::exp(-half)});
        }
    }
    return {low, high};
}

} // namespace explore::analysis

#include "analysis/common/mesh_error.h"

#include "analysis/common/run_cost.h"
#include "base/error.h"
#include "base/text.h"
#include "landscape/minima.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<study::Study> on_finer_mesh(const study::Study& study) {
    constexpr double finer = 1.5;
    constexpr double most_memory = 0.5e9; // bytes
    if (study.has_own_model) {
        return std::nullopt;
    }
    study::Study refined = study;
    refined.model.settings.refine *= finer;
    try {
        return affordable_cost(refined, 1).memory > most_memory ? std::nullopt : std::optional(std::move(refined));
    } catch (const pave::Error&) { // too large
        return std::nullopt;
    }
}

study::Study on_coarser_mesh(study::Study study) {
    constexpr double coarser = 0.5;
    constexpr double coarsest = 0.25; // that a study may ask for
    double& refine = study.model.settings.refine;
    refine = std::max(std::min(refine, coarsest), coarser * refine);
    int& steps = study.model.settings.solver.load_steps;
    steps = (2 * steps + 2) / 3;
    study.hash += fmt::format(" on a mesh of refine {}", refine);
    return study;
}

std::optional<MeshError> mesh_error(const study::Study& study, const problem::Problem& problem,
                                    const problem::Evaluation& answer, const std::vector<double>& unit, double noise) {
    const auto refined = noise > 0.0 ? on_finer_mesh(study) : std::nullopt;
    if (!refined) {
        return std::nullopt;
    }
    problem::Evaluation other = answer;
    try {
        const problem::Problem same = study::make_problem(*refined, study::Scope::fitted);
        const auto outcome = same.function->evaluate(answer.parameters, false, *same.function->make_workspace());
        if (!outcome) {
            return std::nullopt;
        }
        other.responses = outcome->responses;
    } catch (const pave::Error&) { // too large
        return std::nullopt;
    }
    const VectorXd r = problem.residuals(answer) / noise;
    const VectorXd d = problem.residuals(other) / noise - r;
    if (!(d.norm() > 0.0) || !d.allFinite()) {
        return std::nullopt;
    }
    MeshError error{.refine = refined->model.settings.refine, .chi2 = r.squaredNorm(), .moved = {}};
    const MatrixXd j = landscape::off_bounds(problem.residual_jacobian(answer) / noise, landscape::bounds_met(unit));
    const Eigen::JacobiSVD<MatrixXd> svd(j, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const MatrixXd u = landscape::followed_by(j, {});
    const VectorXd left = d - u * (u.transpose() * d);
    error.beyond = left.norm();
    error.chi2_finer = error.chi2 + 2.0 * r.dot(left) + left.squaredNorm();
    constexpr double determined = 2.0; // standard deviations by crossing the box, as in landscape/rank.h
    const Index rank = (svd.singularValues().array() >= determined).count();
    const MatrixXd scaled = svd.matrixV().leftCols(rank) * svd.singularValues().head(rank).cwiseInverse().asDiagonal();
    const VectorXd step = -scaled * (svd.matrixU().leftCols(rank).transpose() * d);
    for (Index k = 0; k < step.size(); ++k) {
        const double deviation = scaled.row(k).norm();
        error.moved.push_back(
            {problem.space.axes[static_cast<std::size_t>(k)].name, deviation > 0.0 ? step[k] / deviation : 0.0});
    }
    const VectorXd single = (problem.single_residuals(other) - problem.single_residuals(answer)).cwiseAbs();
    Index most = 0;
    single.maxCoeff(&most);
    error.reading = problem.response_of(static_cast<std::size_t>(most));
    error.change = other.responses[error.reading] / answer.responses[error.reading] - 1.0;
    return error;
}

namespace {

constexpr double shows_in_residuals = 1.0;   // standard deviations of the noise
constexpr double shows_in_parameters = 0.25; // standard errors
constexpr double shows_in_outputs = 0.5;     // standard deviations

} // namespace

bool MeshError::shows() const {
    return beyond >= shows_in_residuals ||
           std::any_of(moved.begin(), moved.end(),
                       [](const Moved& m) { return std::abs(m.standard_errors) >= shows_in_parameters; }) ||
           std::any_of(outputs.begin(), outputs.end(),
                       [](const Output& o) { return std::abs(o.deviations) >= shows_in_outputs; });
}

std::string mesh_words(const study::Study& study, const std::optional<MeshError>& error) {
    if (!error || !error->shows()) {
        return "";
    }
    std::vector<std::string> changes;
    if (error->beyond >= shows_in_residuals) {
        changes.push_back(
            fmt::format("chi2 would be {} instead of {}", pave::figure(error->chi2_finer), pave::figure(error->chi2)));
    }
    for (const auto& [parameter, moved] : error->moved) {
        if (std::abs(moved) >= shows_in_parameters) {
            changes.push_back(fmt::format("{} would lie {:.1f} standard errors {}", parameter, std::abs(moved),
                                          moved > 0.0 ? "higher" : "lower"));
        }
    }
    for (const MeshError::Output& output : error->outputs) {
        if (std::abs(output.deviations) >= shows_in_outputs) {
            changes.push_back(fmt::format("{} would be {:.1f} % {} (its range holds that)",
                                          study.readings[output.reading].output, 100.0 * std::abs(output.change),
                                          output.change > 0.0 ? "larger" : "smaller"));
        }
    }
    return fmt::format(
        "The mesh is coarse beside this noise. On one {:g} times as fine, {} changes by {:.1f} %, more of "
        "its noise than any other reading; fitted with it, to first order, {}. refine = {:g} under [mesh] "
        "takes that mesh.",
        error->refine / study.model.settings.refine, study.readings[error->reading].words(),
        100.0 * std::abs(error->change), pave::join(changes), error->refine);
}

} // namespace explore::analysis

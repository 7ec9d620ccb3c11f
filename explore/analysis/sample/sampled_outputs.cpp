#include "analysis/sample/sampled_outputs.h"

#include "study/problems.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr double small_error = 0.05; // of the standard deviation over the draws: that of the sum is 0.1 % more
constexpr double no_error = 1e-4;    // of the value

// Draws as deviations from their mean, uncorrelated and of variance 1: unit = mean + axes z.
struct Whitened {
    RowVectorXd mean;
    MatrixXd axes; // d(unit)/d(z)
    MatrixXd z;    // a row a draw
};

Whitened whitened(const MatrixXd& units, const VectorXd& weights) {
    const VectorXd share = weights / weights.sum();
    Whitened w;
    w.mean = share.transpose() * units;
    const MatrixXd off = units.rowwise() - w.mean;
    const MatrixXd covariance = off.transpose() * share.asDiagonal() * off;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance);
    constexpr double least = 1e-7; // standard deviation, of the box: of what does not move
    const VectorXd deviations = eigen.eigenvalues().cwiseMax(least * least).cwiseSqrt();
    w.axes = eigen.eigenvectors() * deviations.asDiagonal();
    w.z = off * eigen.eigenvectors() * deviations.cwiseInverse().asDiagonal();
    return w;
}

// The powers up to the second of z, and their derivatives by each of its coordinates.
MatrixXd powers(const RowVectorXd& z) {
    const Index d = z.size();
    MatrixXd rows = MatrixXd::Zero(1 + d, (d + 1) * (d + 2) / 2);
    rows(0, 0) = 1.0;
    for (Index a = 0; a < d; ++a) {
        rows(0, 1 + a) = z[a];
        rows(1 + a, 1 + a) = 1.0;
    }
    Index next = 1 + d;
    for (Index a = 0; a < d; ++a) {
        for (Index b = a; b < d; ++b, ++next) {
            rows(0, next) = z[a] * z[b];
            rows(1 + a, next) += z[b];
            rows(1 + b, next) += z[a];
        }
    }
    return rows;
}

// From the mean outwards, each as far from those before as there is one: what lies between them is not extrapolated.
std::vector<std::size_t> spread_out(const MatrixXd& z, std::size_t count) {
    std::vector<std::size_t> chosen;
    VectorXd nearest = VectorXd::Constant(z.rows(), std::numeric_limits<double>::infinity());
    Index next = 0;
    z.rowwise().squaredNorm().minCoeff(&next);
    while (chosen.size() < count && static_cast<Index>(chosen.size()) < z.rows()) {
        chosen.push_back(static_cast<std::size_t>(next));
        nearest = nearest.cwiseMin((z.rowwise() - z.row(next)).rowwise().squaredNorm());
        if (!(nearest.maxCoeff(&next) > 0.0)) {
            break; // every draw is one of them
        }
    }
    return chosen;
}

search::Design at_draws(const MatrixXd& units, const std::vector<std::size_t>& chosen) {
    search::Design design{"draws", {}};
    for (const std::size_t i : chosen) {
        const RowVectorXd unit = units.row(static_cast<Index>(i));
        design.points.emplace_back(unit.begin(), unit.end());
    }
    return design;
}

class Surfaces {
public:
    Surfaces(const problem::Problem& problem, const Whitened& draws, const std::vector<std::size_t>& rows)
        : problem_(problem),
          draws_(draws),
          rows_(rows) {}

    void add(std::size_t draw, const problem::Evaluation& e) {
        if (!e.converged()) {
            return;
        }
        const MatrixXd own = powers(draws_.z.row(static_cast<Index>(draw)));
        left_.conservativeResize(left_.rows() + own.rows(), own.cols());
        left_.bottomRows(own.rows()) = own;
        right_.conservativeResize(left_.rows(), static_cast<Index>(rows_.size()));
        const std::vector<double> unit = problem_.space.unit(e.parameters);
        for (std::size_t o = 0; o < rows_.size(); ++o) {
            RowVectorXd slope = e.jacobian.row(static_cast<Index>(rows_[o]));
            for (std::size_t k = 0; k < unit.size(); ++k) {
                slope[static_cast<Index>(k)] *= problem_.space.axes[k].d_physical(unit[k]);
            }
            const auto column = static_cast<Index>(o);
            right_(left_.rows() - own.rows(), column) = e.responses[rows_[o]];
            right_.col(column).tail(own.rows() - 1) = (slope * draws_.axes).transpose();
        }
        ++runs_;
    }

    // Whether what was added determines them with something to spare.
    bool fit() {
        constexpr Index left_over = 3; // half of as many again
        if (2 * left_.rows() < left_over * left_.cols()) {
            return false;
        }
        logarithm_.clear();
        MatrixXd right = right_;
        const Index stride = 1 + draws_.z.cols(); // a value, and its derivatives
        for (Index o = 0; o < right.cols(); ++o) {
            double low = std::numeric_limits<double>::infinity();
            double high = -low;
            for (Index row = 0; row < right.rows(); row += stride) {
                low = std::min(low, right(row, o));
                high = std::max(high, right(row, o));
            }
            logarithm_.push_back(low > 0.0 || high < 0.0 ? (low > 0.0 ? 1 : -1) : 0);
            for (Index row = 0; logarithm_.back() != 0 && row < right.rows(); row += stride) {
                const double value = right(row, o);
                right.col(o).segment(row + 1, stride - 1) /= value;
                right(row, o) = std::log(std::abs(value));
            }
        }
        coefficients_ = Eigen::ColPivHouseholderQR<MatrixXd>(left_).solve(right);
        return coefficients_.allFinite();
    }

    RowVectorXd at(std::size_t draw) const {
        RowVectorXd values = powers(draws_.z.row(static_cast<Index>(draw))).row(0) * coefficients_;
        for (std::size_t o = 0; o < logarithm_.size(); ++o) {
            double& value = values[static_cast<Index>(o)];
            value = logarithm_[o] == 0 ? value : logarithm_[o] * std::exp(value);
        }
        return values;
    }

    std::size_t runs() const { return runs_; }

private:
    const problem::Problem& problem_;
    const Whitened& draws_;
    const std::vector<std::size_t>& rows_;
    MatrixXd left_, right_, coefficients_;
    std::vector<int> logarithm_; // of each output: the sign whose logarithm is the surface, 0: itself is
    std::size_t runs_ = 0;
};

// Root mean squares of what the surfaces are off, and whether they are small beside the spread over the draws.
bool holds(const Surfaces& surfaces, const std::vector<std::size_t>& checks,
           const std::vector<problem::Evaluation>& there, const std::vector<std::size_t>& rows, const MatrixXd& values,
           const VectorXd& weights, OutputSurface& found) {
    found = {.runs = surfaces.runs(), .checks = 0, .error = std::vector<double>(rows.size(), 0.0)};
    for (std::size_t i = 0; i < checks.size(); ++i) {
        if (there[i].converged()) {
            const RowVectorXd by_surface = surfaces.at(checks[i]);
            for (std::size_t o = 0; o < rows.size(); ++o) {
                found.error[o] += std::pow(by_surface[static_cast<Index>(o)] - there[i].responses[rows[o]], 2);
            }
            ++found.checks;
        }
    }
    if (2 * found.checks < checks.size() || !values.allFinite()) {
        return false;
    }
    bool all = true;
    for (std::size_t o = 0; o < rows.size(); ++o) {
        found.error[o] = std::sqrt(found.error[o] / static_cast<double>(found.checks));
        const VectorXd column = values.col(static_cast<Index>(o));
        const double mean = weights.dot(column) / weights.sum();
        const double spread = std::sqrt(weights.dot((column.array() - mean).square().matrix()) / weights.sum());
        all = all && found.error[o] <= std::max(small_error * spread, no_error * std::abs(mean));
    }
    return all;
}

} // namespace

std::vector<std::size_t> outputs_besides(const study::Study& study) {
    std::vector<std::size_t> rows;
    const std::vector<bool> computed = study::computed_loads(study);
    for (const std::size_t i : study.outputs()) {
        if (!computed[static_cast<std::size_t>(study.model.sensors[i].load)]) {
            rows.push_back(i);
        }
    }
    return rows;
}

std::optional<DrawnOutputs> outputs_at_draws(Session& session, const study::Study& study, const MatrixXd& units,
                                             const std::vector<double>& weights, std::size_t most,
                                             const std::string& settings) {
    DrawnOutputs result{.rows = outputs_besides(study), .values = {}, .surface = {}};
    std::vector<bool> loads(study.model.loads.size(), false);
    for (const std::size_t i : result.rows) {
        loads[static_cast<std::size_t>(study.model.sensors[i].load)] = true;
    }
    const problem::Problem problem = study::make_prediction_problem(study, loads);
    const VectorXd weight = Eigen::Map<const VectorXd>(weights.data(), static_cast<Index>(weights.size()));
    const Whitened draws = whitened(units, weight);
    const auto count = static_cast<std::size_t>(units.rows());
    result.values.resize(units.rows(), static_cast<Index>(result.rows.size()));

    // Draws to check at: evenly spread over all, whatever the surface goes through.
    std::vector<std::size_t> checks;
    constexpr std::size_t most_checks = 6;
    for (std::size_t k = 0; k < std::min(count, most_checks); ++k) {
        checks.push_back((2 * k + 1) * count / (2 * most_checks));
    }
    auto checking = session.engine(problem, session.begin(study, "sample-outputs-checks", settings));
    auto surveying = session.engine(problem, session.begin(study, "sample-outputs-surface", settings));
    const auto tally = [&](const run::Engine& engine) {
        result.computed += engine.tally().computed;
        result.kept += engine.tally().kept;
    };

    const std::size_t d = study.space.axes.size();
    const std::size_t coefficients = (d + 1) * (d + 2) / 2;
    const std::size_t least_runs = std::max<std::size_t>(3, (3 * coefficients / 2 + d) / (d + 1));
    Surfaces surfaces(problem, draws, result.rows);
    std::optional<std::vector<problem::Evaluation>> there;
    std::size_t have = 0;
    const std::vector<std::size_t> chosen = spread_out(draws.z, std::max(least_runs, most / 8));
    for (std::size_t runs = least_runs; have < chosen.size(); runs += (runs + 1) / 2) {
        const auto last = chosen.begin() + static_cast<std::ptrdiff_t>(std::min(runs, chosen.size()));
        const auto more = surveying.evaluate(at_draws(units, {chosen.begin(), last}), true, have);
        if (!more) {
            return std::nullopt;
        }
        for (const problem::Evaluation& e : *more) {
            surfaces.add(chosen[have++], e);
        }
        if (!surfaces.fit()) {
            continue;
        }
        if (!there && !(there = checking.evaluate(at_draws(units, checks)))) {
            return std::nullopt;
        }
        for (std::size_t i = 0; i < count; ++i) {
            result.values.row(static_cast<Index>(i)) = surfaces.at(i);
        }
        OutputSurface found;
        if (holds(surfaces, checks, *there, result.rows, result.values, weight, found)) {
            result.surface = std::move(found);
            tally(checking);
            tally(surveying);
            return result;
        }
    }
    tally(checking);
    tally(surveying);

    // No such surface: runs that stand for themselves.
    std::vector<std::size_t> alone;
    for (std::size_t k = 0; k < std::min(count, most); ++k) {
        alone.push_back(k * count / std::min(count, most));
    }
    auto engine = session.engine(
        problem, session.begin(study, "sample-outputs", fmt::format("{}, {} of the draws", settings, alone.size())));
    const auto evaluations = engine.evaluate(at_draws(units, alone));
    if (!evaluations) {
        return std::nullopt;
    }
    tally(engine);
    result.values.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < alone.size(); ++k) {
        for (std::size_t o = 0; o < result.rows.size() && (*evaluations)[k].converged(); ++o) {
            result.values(static_cast<Index>(alone[k]), static_cast<Index>(o)) =
                (*evaluations)[k].responses[result.rows[o]];
        }
    }
    return result;
}

} // namespace explore::analysis

#include "landscape/conflict.h"

#include "landscape/goodness.h"
#include "landscape/rank.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <limits>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Fitted {
    std::vector<double> unit;
    problem::Evaluation evaluation;
    double misfit = std::numeric_limits<double>::infinity();
};

} // namespace

std::optional<Conflict> conflict_of(run::Engine& engine, const problem::Problem& problem, const Acceptance& acceptance,
                                    const Minimum& joint, const std::vector<std::vector<std::size_t>>& groups,
                                    const std::vector<std::vector<double>>& starts, int first) {
    Conflict c;
    c.p_value = std::numeric_limits<double>::quiet_NaN();
    std::vector<problem::Problem> problems;
    problems.reserve(groups.size());
    for (const auto& rows : groups) {
        problems.push_back(problem.with_readings(rows));
    }
    std::vector<Fitted> fits(groups.size() * starts.size());
    const bool finished = engine.chains("groups alone", first, fits.size(), [&](std::size_t i, run::Chain& chain) {
        const problem::Problem& own = problems[i / starts.size()];
        Fitted& fit = fits[i];
        const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
            problem::Evaluation e = chain.at(unit);
            if (!e.converged()) {
                return optimise::Answer::no_answer;
            }
            sample = run::sample_of(own, e);
            if (sample.residuals.norm() < fit.misfit) {
                fit.misfit = sample.residuals.norm();
                fit.unit.assign(unit.begin(), unit.end());
                fit.evaluation = std::move(e);
            }
            return optimise::Answer::computed;
        };
        optimise::SearchSettings settings;
        settings.enough = 0.005 * acceptance.variance;
        optimise::gauss_newton(starts[i % starts.size()], objective, settings);
    });
    if (!finished) {
        return std::nullopt;
    }
    double separate = 0.0;
    int ranks = 0;
    std::vector<MatrixXd> informations;
    std::vector<FittedProblem> fitted;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const auto begin = fits.begin() + static_cast<std::ptrdiff_t>(g * starts.size());
        const auto best = std::min_element(begin, begin + static_cast<std::ptrdiff_t>(starts.size()),
                                           [](const auto& a, const auto& b) { return a.misfit < b.misfit; });
        if (best->unit.empty()) {
            return c;
        }
        const MatrixXd s = problems[g].information_jacobian(best->evaluation) / acceptance.noise();
        GroupAlone alone;
        alone.group = g;
        alone.unit = best->unit;
        alone.parameters = best->evaluation.parameters;
        alone.misfit = best->misfit;
        alone.rank = rank_of(s);
        MatrixXd h = s.transpose() * s;
        h.diagonal().array() += 1e-9;
        const MatrixXd covariance = h.inverse();
        for (Index k = 0; k < h.rows(); ++k) {
            const double error = std::sqrt(covariance(k, k));
            alone.standard_error.push_back(error < 1.0 ? error : std::numeric_limits<double>::infinity());
        }
        informations.push_back(std::move(h));
        fitted.push_back({problems[g], best->evaluation});
        separate += best->misfit * best->misfit;
        ranks += alone.rank;
        c.alone.push_back(std::move(alone));
    }
    const double sum = joint.evaluation.misfit * joint.evaluation.misfit;
    c.degrees_of_freedom = ranks - rank_of(problem.information_jacobian(joint.evaluation) / acceptance.noise());
    c.remaining = problem.degrees_of_freedom(static_cast<std::size_t>(ranks));
    if (c.degrees_of_freedom > 0) {
        // Stated noise that even the separate fits contradict is no measure of their difference.
        constexpr double contradicted = 0.01;
        const bool noise_holds =
            acceptance.noise_is_stated && goodness_of(fitted, separate, c.remaining).p_value >= contradicted;
        if (noise_holds) {
            c.statistic = std::max(0.0, sum - separate);
            c.p_value = gsl_cdf_chisq_Q(c.statistic, c.degrees_of_freedom);
        } else if (c.remaining > 0 && separate > 0.0) {
            c.statistic = std::max(0.0, sum - separate) / c.degrees_of_freedom / (separate / c.remaining);
            c.p_value = gsl_cdf_fdist_Q(c.statistic, c.degrees_of_freedom, c.remaining);
        }
    }
    for (std::size_t a = 0; a < c.alone.size(); ++a) {
        for (std::size_t b = a + 1; b < c.alone.size(); ++b) {
            VectorXd apart(joint.evaluation.parameters.size());
            for (Index k = 0; k < apart.size(); ++k) {
                apart[k] = c.alone[b].unit[static_cast<std::size_t>(k)] - c.alone[a].unit[static_cast<std::size_t>(k)];
            }
            // Information about the difference of two estimates.
            const MatrixXd both = (informations[a].inverse() + informations[b].inverse()).inverse();
            const double sigmas = std::sqrt(std::max(0.0, apart.dot(both * apart)));
            if (sigmas > c.sigmas) {
                c.sigmas = sigmas;
                c.first = a;
                c.second = b;
                // The combination of parameters that shows it best: the largest part of apart' both apart.
                const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(both);
                Index most = 0;
                double share = -1.0;
                for (Index i = 0; i < both.rows(); ++i) {
                    const double part = eigen.eigenvalues()[i] * std::pow(eigen.eigenvectors().col(i).dot(apart), 2);
                    if (part > share) {
                        share = part;
                        most = i;
                    }
                }
                const VectorXd v = eigen.eigenvectors().col(most);
                c.direction = v.dot(apart) < 0.0 ? VectorXd(-v) : v;
            }
        }
    }
    return c;
}

} // namespace explore::landscape

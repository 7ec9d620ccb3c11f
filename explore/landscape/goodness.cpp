#include "landscape/goodness.h"

#include "base/random.h"
#include "landscape/minima.h"
#include "problem/student.h"

#include <Eigen/Cholesky>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int sets = 2000;

// The linear model at a minimum, by the parameters off their bounds.
struct Linear {
    MatrixXd readings; // d(standard residual)/d(unit)
    MatrixXd known;    // the same of priors and limits
    Index priors = 0;  // how many of them are priors
    double degrees = 0.0;

    explicit Linear(const FittedProblem& fit)
        : priors(static_cast<Index>(fit.problem.priors().size())),
          degrees(fit.problem.noise_degrees()) {
        std::vector<Index> open;
        const auto unit = fit.problem.space.unit(fit.minimum.parameters);
        for (std::size_t k = 0; k < unit.size(); ++k) {
            if (!is_at_bound(unit[k])) {
                open.push_back(static_cast<Index>(k));
            }
        }
        const auto count = static_cast<Index>(fit.problem.readings());
        const MatrixXd rows = fit.problem.information_jacobian(fit.minimum)(Eigen::all, open);
        readings = rows.topRows(count) / std::sqrt(problem::student_information(degrees));
        known = rows.bottomRows(rows.rows() - count);
    }

    Index size() const { return readings.rows() + priors; }

    // The lowest sum of squares of the rows for these errors, of the readings first.
    double lowest(const VectorXd& errors) const {
        const VectorXd of_readings = errors.head(readings.rows());
        VectorXd of_known = VectorXd::Zero(known.rows());
        of_known.head(priors) = errors.tail(priors);
        VectorXd move = VectorXd::Zero(readings.cols());
        double sum = sum_at(of_readings, of_known);
        constexpr int most_rounds = 50;
        for (int round = 0; round < most_rounds && move.size() > 0; ++round) {
            const VectorXd weight = (of_readings + readings * move).unaryExpr([&](double z) {
                return problem::student_weight(z, degrees);
            });
            MatrixXd normal =
                readings.transpose() * weight.asDiagonal() * readings + MatrixXd(known.transpose() * known);
            normal.diagonal().array() += 1e-9; // where nothing tells of a parameter
            move = -normal.ldlt().solve(
                VectorXd(readings.transpose() * weight.cwiseProduct(of_readings) + known.transpose() * of_known));
            const double before = sum;
            sum = sum_at(of_readings + readings * move, of_known + known * move);
            if (before - sum < 1e-4) {
                break;
            }
        }
        return sum;
    }

private:
    double sum_at(const VectorXd& z, const VectorXd& of_known) const {
        double sum = of_known.squaredNorm();
        for (const double value : z) {
            const double row = problem::student_row(value, degrees);
            sum += row * row;
        }
        return sum;
    }
};

} // namespace

Goodness goodness_of(std::span<const FittedProblem> fits, double chi2, int degrees_of_freedom) {
    Goodness result{.expected = static_cast<double>(degrees_of_freedom)};
    if (degrees_of_freedom <= 0) {
        return result;
    }
    if (!fits[0].problem.noise_is_student()) {
        result.p_value = gsl_cdf_chisq_Q(chi2, degrees_of_freedom);
        return result;
    }
    std::vector<Linear> models;
    for (const FittedProblem& fit : fits) {
        models.emplace_back(fit);
    }
    double sum = 0.0;
    int above = 0;
    for (int set = 0; set < sets; ++set) {
        const pave::RandomStream random(1, static_cast<std::uint64_t>(set));
        std::uint64_t number = 0;
        double lowest = 0.0;
        for (const Linear& model : models) {
            VectorXd errors(model.size());
            for (Index i = 0; i < errors.size(); ++i, ++number) {
                errors[i] = i < model.readings.rows()
                                ? problem::student_draw(random.uniform(2 * number), random.uniform(2 * number + 1),
                                                        model.degrees)
                                : random.normal(number);
            }
            lowest += model.lowest(errors);
        }
        sum += lowest;
        above += lowest >= chi2 ? 1 : 0;
    }
    result.expected = sum / sets;
    result.p_value = (1.0 + above) / (1.0 + sets);
    return result;
}

Goodness goodness_of(const problem::Problem& problem, const problem::Evaluation& minimum, double chi2,
                     int degrees_of_freedom) {
    const FittedProblem fit[] = {{problem, minimum}};
    return goodness_of(fit, chi2, degrees_of_freedom);
}

} // namespace explore::landscape

#include "landscape/minima.h"

#include "landscape/readings_alone.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {
namespace {

constexpr double at_bound = 1e-6; // of the unit cube

Eigen::VectorXd difference(const std::vector<double>& a, const std::vector<double>& b) {
    Eigen::VectorXd d(static_cast<Eigen::Index>(a.size()));
    for (std::size_t k = 0; k < a.size(); ++k) {
        d[static_cast<Eigen::Index>(k)] = a[k] - b[k];
    }
    return d;
}

// The change of the misfit when every reading changes by the rounding of models.
double rounding_of_misfit(const run::Endpoint& end, const problem::Problem& by_noise) {
    constexpr double rounding = 1e-5; // of a reading
    double squares = 0.0;
    for (std::size_t i = 0; i < by_noise.readings(); ++i) {
        squares += by_noise.change_by_gain(i, end.evaluation).squaredNorm();
    }
    return rounding * std::sqrt(squares);
}

double noise_of_misfit(const run::Endpoint& lower, const problem::Problem& by_noise) {
    if (by_noise.noise_is_stated()) {
        return 1.0;
    }
    const int free = std::max(1, by_noise.degrees_of_freedom(by_noise.space.axes.size()));
    return std::max(by_noise.misfit(lower.evaluation) / std::sqrt(static_cast<double>(free)),
                    rounding_of_misfit(lower, by_noise));
}

} // namespace

Minimum minimum_at(problem::Evaluation evaluation, std::vector<double> unit) {
    Minimum there;
    there.evaluation = std::move(evaluation);
    there.on_bound = bounds_met(unit);
    there.unit = std::move(unit);
    return there;
}

bool fit_alike(const run::Endpoint& lower, const run::Endpoint& other, const problem::Problem& by_noise) {
    const double noise = noise_of_misfit(lower, by_noise);
    return by_noise.misfit(other.evaluation) - by_noise.misfit(lower.evaluation) < 0.1 * noise &&
           (by_noise.residuals(other.evaluation) - by_noise.residuals(lower.evaluation)).norm() < noise;
}

bool are_one_minimum(const run::Endpoint& lower, const run::Endpoint& other, const problem::Problem& by_noise) {
    if (!by_noise.noise_is_stated() && by_noise.degrees_of_freedom(by_noise.space.axes.size()) < 0 &&
        by_noise.misfit(other.evaluation) <= rounding_of_misfit(other, by_noise)) {
        return true; // both meet every reading, and parameters are left
    }
    const Eigen::VectorXd d = difference(other.search.unit, lower.search.unit);
    return d.lpNorm<Eigen::Infinity>() < 0.01 ||
           (fit_alike(lower, other, by_noise) &&
            (by_noise.residual_jacobian(lower.evaluation) * d).norm() < noise_of_misfit(lower, by_noise));
}

bool is_at_bound(double unit) {
    return unit < at_bound || unit > 1.0 - at_bound;
}

std::vector<BoundMet> bounds_met(const std::vector<double>& unit) {
    std::vector<BoundMet> met;
    for (std::size_t k = 0; k < unit.size(); ++k) {
        if (is_at_bound(unit[k])) {
            met.push_back({k, unit[k] >= 0.5});
        }
    }
    return met;
}

Eigen::MatrixXd off_bounds(Eigen::MatrixXd derivatives, const std::vector<BoundMet>& bounds) {
    for (const BoundMet& bound : bounds) {
        derivatives.col(static_cast<Eigen::Index>(bound.axis)).setZero();
    }
    return derivatives;
}

std::vector<char> seen(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& directions) {
    constexpr double accuracy = 1e-8; // of a sensor's derivatives
    std::vector<char> is_seen(static_cast<std::size_t>(directions.cols()), 0);
    const Eigen::MatrixXd along = (rows * directions).cwiseAbs();
    Eigen::VectorXd sizes = rows.rowwise().norm();
    constexpr double rounding = 1e-15; // of the decomposition that the directions are of
    sizes = sizes.cwiseMax(rounding / accuracy * sizes.maxCoeff());
    for (Eigen::Index k = 0; k < along.cols(); ++k) {
        is_seen[static_cast<std::size_t>(k)] = (along.col(k).array() > accuracy * sizes.array()).any() ? 1 : 0;
    }
    return is_seen;
}

Eigen::MatrixXd followed_by(const Eigen::MatrixXd& jacobian, const std::vector<BoundMet>& bounds) {
    const Eigen::MatrixXd open = off_bounds(jacobian, bounds);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(open, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const std::vector<char> is_seen = seen(open, svd.matrixV());
    std::vector<Eigen::Index> followed;
    for (std::size_t k = 0; k < is_seen.size(); ++k) {
        if (is_seen[k] != 0) {
            followed.push_back(static_cast<Eigen::Index>(k));
        }
    }
    return svd.matrixU()(Eigen::all, followed);
}

std::string bound_words(const problem::ParameterSpace& space, const BoundMet& bound) {
    return space.axes[bound.axis].name + (bound.upper ? " at its upper bound" : " at its lower bound");
}

std::vector<std::string> bound_words(const problem::ParameterSpace& space, const std::vector<BoundMet>& bounds) {
    std::vector<std::string> words;
    words.reserve(bounds.size());
    for (const BoundMet& bound : bounds) {
        words.push_back(bound_words(space, bound));
    }
    return words;
}

namespace {

// Whether an end stands for its minimum better than that which does: off bounds, where nothing else tells the two
// apart. Of a flat valley that reaches a bound the lowest end is anywhere, and on the bound the valley is not seen.
bool stands_for(const run::Endpoint& end, const Minimum& minimum, const run::Endpoint& lowest,
                const problem::Problem& by_noise) {
    constexpr double nothing = 1e-4; // of the variance of a residual
    const auto square = [&](const problem::Evaluation& e) { return std::pow(by_noise.misfit(e), 2); };
    return end.search.converged && bounds_met(end.search.unit).size() < minimum.on_bound.size() &&
           square(end.evaluation) - square(lowest.evaluation) <=
               nothing * std::pow(noise_of_misfit(lowest, by_noise), 2);
}

} // namespace

std::vector<Minimum> distinct_minima(const std::vector<run::Endpoint>& ends, const problem::Problem& problem) {
    const problem::Problem by_noise = problem.in_units_of_noise();
    std::vector<const run::Endpoint*> order;
    for (const auto& end : ends) {
        if (!end.search.unit.empty() && problem.broken_limits(end.evaluation).empty()) {
            order.push_back(&end);
        }
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto* a, const auto* b) { return a->search.misfit < b->search.misfit; });
    std::vector<Minimum> minima;
    std::vector<std::vector<const run::Endpoint*>> of; // each minimum: a valley that bends is followed from end to end
    for (const run::Endpoint* end : order) {
        const auto here = std::find_if(of.begin(), of.end(), [&](const auto& known) {
            return std::any_of(known.begin(), known.end(),
                               [&](const run::Endpoint* other) { return are_one_minimum(*other, *end, by_noise); });
        });
        auto home = minima.begin() + (here - of.begin());
        if (here == of.end() && !end->search.converged && !minima.empty()) {
            continue; // ended early, and nowhere that is known
        }
        if (here == of.end()) {
            of.emplace_back();
        }
        of[static_cast<std::size_t>(home - minima.begin())].push_back(end);
        const auto& parameters = end->evaluation.parameters;
        if (home == minima.end()) {
            Minimum m;
            m.evaluation = end->evaluation;
            m.unit = end->search.unit;
            m.lowest = m.highest = parameters;
            m.converged = end->search.converged;
            m.on_bound = bounds_met(m.unit);
            minima.push_back(std::move(m));
            home = minima.end() - 1;
        }
        if (stands_for(*end, *home, *of[static_cast<std::size_t>(home - minima.begin())].front(), by_noise)) {
            home->evaluation = end->evaluation;
            home->unit = end->search.unit;
            home->converged = true;
            home->on_bound = bounds_met(home->unit);
            home->members.insert(home->members.begin(), end->start);
        } else {
            home->members.push_back(end->start);
        }
        for (std::size_t k = 0; k < parameters.size(); ++k) {
            home->lowest[k] = std::min(home->lowest[k], parameters[k]);
            home->highest[k] = std::max(home->highest[k], parameters[k]);
        }
    }
    return minima;
}

namespace {

// The standard deviation of every residual, with what it says of the fit.
Eigen::VectorXd noise_of(const Minimum& minimum, const problem::Problem& problem, double noise_factor,
                         LocalAnalysis& a) {
    const auto readings = static_cast<Eigen::Index>(problem.readings());
    a.noise_is_stated = problem.noise_is_stated();
    const problem::Problem by_noise = problem.in_units_of_noise();
    const JudgedFit fit = judged_fit(by_noise, minimum);
    a.degrees_of_freedom = fit.degrees_of_freedom;
    if (!a.noise_is_stated) {
        if (a.degrees_of_freedom > 0) {
            a.noise = std::sqrt(fit.sum / static_cast<double>(a.degrees_of_freedom));
        }
        return Eigen::VectorXd::Constant(static_cast<Eigen::Index>(problem.rows()), a.noise);
    }
    Eigen::VectorXd noise = problem.noise(minimum.evaluation);
    a.chi2 = fit.sum;
    const Goodness goodness = goodness_of(fit.problem, *fit.at, a.chi2, a.degrees_of_freedom);
    a.expected_chi2 = goodness.expected;
    a.p_value = goodness.p_value;
    a.widened = a.p_value < contradicted;
    a.widening = std::max(noise_factor, a.widened ? std::sqrt(a.chi2 / goodness.expected) : 1.0);
    noise.head(readings) *= a.widening;
    a.noise = noise.head(readings).norm() / std::sqrt(static_cast<double>(readings));
    return noise;
}

} // namespace

double LocalAnalysis::quantile() const {
    constexpr double level = 0.975;
    const bool noise_is_known = noise_is_stated && !widened;
    return noise_is_known || degrees_of_freedom < 1
               ? gsl_cdf_ugaussian_Pinv(level)
               : gsl_cdf_tdist_Pinv(level, static_cast<double>(degrees_of_freedom));
}

LocalAnalysis analyse(const Minimum& minimum, const problem::Problem& problem, double noise_factor) {
    LocalAnalysis a;
    Eigen::MatrixXd j = problem.information_jacobian(minimum.evaluation);
    Eigen::VectorXd residuals = problem.residuals(minimum.evaluation);
    for (const Eigen::Index row : problem.limit_rows()) { // no reading: an inequality says nothing within it
        j.row(row).setZero();
        residuals[row] = 0.0;
    }
    const auto n = static_cast<Eigen::Index>(minimum.unit.size());
    const double infinity = std::numeric_limits<double>::infinity();
    a.standard_error.assign(minimum.unit.size(), infinity);
    a.weakest.assign(minimum.unit.size(), 0.0);
    const Eigen::VectorXd noise = noise_of(minimum, problem, noise_factor, a);
    // A parameter on a bound is no more known for that: it takes part like the others.
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(j, Eigen::ComputeThinU | Eigen::ComputeFullV);
    Eigen::VectorXd s = Eigen::VectorXd::Zero(n);
    s.head(svd.singularValues().size()) = svd.singularValues();
    const std::vector<char> direction_is_seen = seen(j, svd.matrixV());
    for (Eigen::Index i = 0; i < n; ++i) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(j.rows()); // of the inverse of the jacobian
        bool is_seen = true;
        for (Eigen::Index k = 0; k < n; ++k) {
            const double v = svd.matrixV()(i, k);
            if (k < svd.singularValues().size() && direction_is_seen[static_cast<std::size_t>(k)] != 0) {
                row += v / s[k] * svd.matrixU().col(k);
            } else if (std::abs(v) > 1e-6) {
                is_seen = false;
            }
        }
        a.standard_error[static_cast<std::size_t>(i)] =
            is_seen && a.noise > 0.0 ? row.cwiseProduct(noise).norm() : infinity;
        a.weakest[static_cast<std::size_t>(i)] = svd.matrixV()(i, n - 1);
    }
    if (a.noise > 0.0) {
        const Eigen::MatrixXd& u = svd.matrixU();
        const Eigen::LLT<Eigen::MatrixXd> spread(Eigen::MatrixXd(u.transpose() * noise.cwiseAbs2().asDiagonal() * u));
        a.root = spread.matrixL().solve(Eigen::MatrixXd(
            svd.singularValues().asDiagonal() * svd.matrixV().leftCols(svd.singularValues().size()).transpose()));
        a.rest = spread.matrixL().solve(u.transpose() * residuals);
    }
    // A reading that the parameters follow has nothing left to be judged by.
    a.leverage = followed_by(j, bounds_met(minimum.unit)).rowwise().squaredNorm();
    a.weakest_growth = 0.1 * s[n - 1];
    a.strongest_growth = 0.1 * s[0];
    return a;
}

} // namespace explore::landscape

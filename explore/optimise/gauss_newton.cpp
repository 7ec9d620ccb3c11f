#include "optimise/gauss_newton.h"

#include "optimise/linear_rows.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace explore::optimise {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

struct Step {
    VectorXd d;
    double gain = 0.0; // by how much half of the sum of squares is predicted to fall
};

// Where the search is, and how far it may go.
struct Place {
    std::vector<double> unit;
    Sample sample;
    double half = INFINITY; // of the sum of squares

    VectorXd low() const { return -Eigen::Map<const VectorXd>(unit.data(), static_cast<Index>(unit.size())); }
    VectorXd high() const { return low().array() + 1.0; }
    std::vector<double> after(const VectorXd& d) const {
        std::vector<double> there = unit;
        for (std::size_t k = 0; k < there.size(); ++k) {
            there[k] = std::clamp(there[k] + d[static_cast<Index>(k)], 0.0, 1.0);
        }
        return there;
    }
};

// The step of no more than this length; `least`: of the damping.
Step step_within(const LinearRows& rows, const Place& here, double radius, double least) {
    const VectorXd low = here.low();
    const VectorXd high = here.high();
    Step step;
    step.d = rows.lowest(least, low, high);
    constexpr double loose = 1.1;
    constexpr double tight = 0.75;
    if (step.d.norm() > loose * radius) {
        // |d| falls with the damping, and is below twice the slope over it.
        double weak = least;
        double strong =
            std::max(2.0 * (here.sample.jacobian.transpose() * here.sample.residuals).norm() / radius, 4.0 * least);
        constexpr int most = 40;
        for (int i = 0; i < most; ++i) {
            const double damping = std::sqrt(weak * strong);
            step.d = rows.lowest(damping, low, high);
            const double length = step.d.norm();
            if (length > loose * radius) {
                weak = damping;
            } else if (length < tight * radius && strong > 1.01 * weak) {
                strong = damping;
            } else {
                break;
            }
        }
    }
    step.gain = here.half - rows.half(step.d);
    return step;
}

// The shortest step after which half of the sum of squares is predicted to be no more than that; nothing: none is, of
// no more than this length.
std::optional<VectorXd> step_down_to(const LinearRows& rows, const Place& here, double half, double longest,
                                     double least) {
    const VectorXd low = here.low();
    const VectorXd high = here.high();
    const double slope = (here.sample.jacobian.transpose() * here.sample.residuals).norm();
    double weak = least;
    double strong = std::max(2.0 * slope / (1e-6 * longest), 4.0 * least);
    VectorXd d = rows.lowest(weak, low, high);
    if (rows.half(d) > half) {
        return std::nullopt;
    }
    while (strong > 2.0 * weak) {
        const double damping = std::sqrt(weak * strong);
        const VectorXd shorter = rows.lowest(damping, low, high);
        if (rows.half(shorter) > half) {
            strong = damping;
        } else {
            weak = damping;
            d = shorter;
        }
    }
    return d.norm() <= longest ? std::optional(d) : std::nullopt;
}

} // namespace

SearchResult gauss_newton(const std::vector<double>& start, const Objective& objective,
                          const SearchSettings& settings) {
    const auto n = static_cast<Index>(start.size());
    SearchResult result;
    bool is_stopped = false;
    double lowest = INFINITY; // half of a sum of squares, of all points
    const auto ask = [&](Place& place, bool with_derivatives) {
        ++result.evaluations;
        place.sample.jacobian.resize(0, 0);
        place.sample.wants_derivatives = with_derivatives;
        const Answer answer = objective(place.unit, place.sample);
        is_stopped = answer == Answer::stop;
        place.half = answer == Answer::computed ? 0.5 * place.sample.residuals.squaredNorm() : INFINITY;
        if (place.half < lowest) {
            lowest = place.half;
            result.unit = place.unit;
        }
        return std::isfinite(place.half);
    };
    Place here{.unit = start, .sample = {}};
    if (!ask(here, true)) {
        result.stopped = is_stopped;
        result.ended = is_stopped ? "stopped" : "the start has no answer";
        return result;
    }
    double radius = settings.first_step;
    MatrixXd curvature = MatrixXd::Zero(n, n); // of the residuals: sum of r_i times its Hessian, a secant estimate
    bool with_curvature = false;
    bool is_secant = false; // the derivatives at hand
    bool is_new = true;     // the point
    int hopeless = 0;       // points in a row that promise nothing worth having
    const MatrixXd none;
    while (true) {
        if (here.half < 1e-24) {
            result.converged = true;
            result.ended = "an exact fit";
            break;
        }
        // A step across the box has to promise what matters.
        const double matters = std::max(settings.misfit_tolerance * here.half, settings.enough);
        const double largest = here.sample.jacobian.colwise().squaredNorm().maxCoeff();
        const double least = std::max({2.0 * matters, 1e-20 * largest, 1e-300});
        const LinearRows plain(here.sample, none);
        const LinearRows rows(here.sample, with_curvature ? curvature : none);
        Step promised{.d = plain.lowest(least, here.low(), here.high())};
        promised.gain = here.half - plain.half(promised.d);
        if (is_new && std::isfinite(settings.worth)) {
            constexpr double share = 0.5;
            hopeless = promised.gain < share * (here.half - settings.worth) ? hopeless + 1 : 0;
            constexpr int enough = 2;
            if (hopeless == enough) {
                result.ended = "it leads to nothing as low as is wanted";
                break;
            }
        }
        is_new = false;
        // The rows alone promise too much along a valley that bends; the curvature tells, where they promise little.
        constexpr double little = 1e-3; // of the sum of squares
        Step whole = promised;
        if (with_curvature && promised.gain <= little * here.half) {
            whole.d = rows.lowest(least, here.low(), here.high());
            whole.gain = here.half - rows.half(whole.d);
        }
        if (whole.gain <= matters) {
            result.converged = true;
            result.ended = "the misfit no longer changes";
            break;
        }
        const double longest = whole.d.cwiseAbs().maxCoeff();
        constexpr double next_to_nothing = 1e-5; // of the sum of squares
        constexpr double nothing = 1e-3;         // of the tolerance
        if (longest < settings.step_tolerance &&
            (whole.gain <= next_to_nothing * here.half || longest < nothing * settings.step_tolerance)) {
            result.converged = true;
            result.ended = "the parameters no longer change";
            break;
        }
        if (radius < settings.step_tolerance) {
            result.converged = promised.gain <= little * here.half; // rounding of the model may hide that much
            result.ended = result.converged ? "rounding limits further progress"
                                            : "no step lowers the misfit, though its derivatives promise it";
            break;
        }
        if (result.evaluations >= settings.max_evaluations) {
            result.ended = "the limit of evaluations";
            break;
        }
        const Step step = step_within(rows, here, radius, least);
        Place there{.unit = here.after(step.d), .sample = {}};
        ask(there, step.gain > settings.secant_below || here.sample.limits.size() > 0);
        // Back to the valley, by ever shorter steps.
        constexpr double poor = 0.25;
        constexpr int most_returns = 4;
        double length = step.d.norm();
        for (int i = 0; i < most_returns && !is_stopped && result.evaluations < settings.max_evaluations &&
                        here.half - there.half < poor * step.gain && there.sample.jacobian.size() > 0;
             ++i) {
            constexpr double shorter = 0.5;
            constexpr double worth_while = 0.9;
            const auto back = step_down_to(LinearRows(there.sample, none), there, here.half - worth_while * step.gain,
                                           shorter * length, least);
            if (!back) {
                break;
            }
            Place nearer{.unit = there.after(*back), .sample = {}};
            constexpr double better = 0.25;
            if (!ask(nearer, true) || !(nearer.half < std::max(better * there.half, here.half))) {
                break;
            }
            there = std::move(nearer);
            length = back->norm();
        }
        if (is_stopped) {
            result.stopped = true;
            result.ended = "stopped";
            break;
        }
        const double gain = (here.half - there.half) / step.gain;
        if (!(gain > 1e-4)) {
            if (is_secant) {
                if (!ask(here, true)) {
                    result.ended = "no derivatives";
                    break;
                }
                is_secant = false;
                continue;
            }
            // The parabola through both points and the slope at this one.
            const double slope = (here.sample.jacobian.transpose() * here.sample.residuals).dot(step.d);
            const double best = -slope / (2.0 * (there.half - here.half - slope));
            radius = step.d.norm() * (std::isfinite(there.half) ? std::clamp(best, 0.1, 0.5) : 0.5);
            continue;
        }
        VectorXd moved(n);
        for (Index k = 0; k < n; ++k) {
            moved[k] = there.unit[static_cast<std::size_t>(k)] - here.unit[static_cast<std::size_t>(k)];
        }
        is_secant = there.sample.jacobian.size() == 0;
        if (is_secant) {
            there.sample.jacobian =
                here.sample.jacobian + (there.sample.residuals - here.sample.residuals - here.sample.jacobian * moved) *
                                           moved.transpose() / moved.squaredNorm();
        }
        // Secant update of the residuals' curvature along the way: that of the residuals which a whole step from there
        // would leave, not of those that it takes away. Rows far stiffer than the others then count with the force that
        // holds them.
        const LinearRows ahead(there.sample, none);
        const VectorXd left =
            there.sample.residuals + there.sample.jacobian * ahead.lowest(least, there.low(), there.high());
        const VectorXd y = (there.sample.jacobian - here.sample.jacobian).transpose() * left;
        const VectorXd change = there.sample.jacobian.transpose() * there.sample.residuals -
                                here.sample.jacobian.transpose() * here.sample.residuals;
        const double along = change.dot(moved);
        const double size = std::abs(moved.dot(curvature * moved));
        if (size > 0.0) {
            curvature *= std::min(1.0, std::abs(moved.dot(y)) / size);
        }
        if (along > 1e-12 * change.norm() * moved.norm()) {
            const VectorXd wrong = y - curvature * moved;
            curvature += (wrong * change.transpose() + change * wrong.transpose()) / along -
                         moved.dot(wrong) / (along * along) * (change * change.transpose());
        }
        // Which model would have predicted this gain better?
        const double without = here.half - plain.half(step.d);
        const double with = without - 0.5 * step.d.dot(curvature * step.d);
        with_curvature = std::abs(with - (here.half - there.half)) < std::abs(without - (here.half - there.half));
        if (gain < poor) {
            radius = 0.5 * step.d.norm();
        } else if (gain > 0.5) {
            radius = std::max(radius, (gain > 0.75 ? 3.0 : 1.5) * step.d.norm());
        }
        here = std::move(there);
        is_new = true;
    }
    result.misfit = std::sqrt(2.0 * lowest);
    return result;
}

} // namespace explore::optimise

#include "optimise/gauss_newton.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace explore::optimise {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The d with low <= d <= high that minimises d.h d / 2 + g.d, h positive definite: a primal active set method. low <= 0
// <= high.
VectorXd bounded_step(const MatrixXd& h, const VectorXd& g, const VectorXd& low, const VectorXd& high) {
    const Index n = g.size();
    VectorXd d = VectorXd::Zero(n);
    std::vector<int> held(static_cast<std::size_t>(n), 0); // -1 at low, 1 at high
    for (Index i = 0; i < n; ++i) {
        if (g[i] > 0.0 && low[i] >= 0.0) {
            held[static_cast<std::size_t>(i)] = -1;
        } else if (g[i] < 0.0 && high[i] <= 0.0) {
            held[static_cast<std::size_t>(i)] = 1;
        }
    }
    for (int iteration = 0; iteration < 10 * n + 10; ++iteration) {
        std::vector<Index> open;
        for (Index i = 0; i < n; ++i) {
            if (held[static_cast<std::size_t>(i)] == 0) {
                open.push_back(i);
            }
        }
        const VectorXd slope = g + h * d;
        VectorXd move = VectorXd::Zero(n);
        if (!open.empty()) {
            const MatrixXd part = h(open, open);
            const VectorXd right = -slope(open);
            const VectorXd found = part.llt().solve(right);
            move(open) = found;
        }
        // As far as the first bound.
        double length = 1.0;
        Index first = -1;
        for (const Index i : open) {
            const double room = move[i] > 0.0 ? high[i] - d[i] : low[i] - d[i];
            if (std::abs(move[i]) > 0.0 && room / move[i] < length) {
                length = std::max(0.0, room / move[i]);
                first = i;
            }
        }
        d += length * move;
        if (first >= 0) {
            const bool up = move[first] > 0.0;
            d[first] = up ? high[first] : low[first];
            held[static_cast<std::size_t>(first)] = up ? 1 : -1;
            continue;
        }
        // Release the bound that holds back most.
        const VectorXd now = g + h * d;
        Index release = -1;
        double most = 1e-14 * (1.0 + g.cwiseAbs().maxCoeff());
        for (Index i = 0; i < n; ++i) {
            const double pull = held[static_cast<std::size_t>(i)] * now[i];
            if (pull > most) {
                most = pull;
                release = i;
            }
        }
        if (release < 0) {
            break;
        }
        held[static_cast<std::size_t>(release)] = 0;
    }
    return d;
}

// The same for that and half the sum of max(0, limit + a d)^2 over the limits, of which h and g hold those above 0: the
// steps of ever other sets of limits that count, until the set is that beyond which its own step leads.
// predicted: how much lower all of it is at the step.
VectorXd limited_step(const MatrixXd& h, const VectorXd& g, const VectorXd& low, const VectorXd& high,
                      const Sample& here, double& predicted) {
    const auto count = here.limits.size();
    std::vector<char> counts(static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
        counts[static_cast<std::size_t>(i)] = here.limits[i] > 0.0 ? 1 : 0;
    }
    MatrixXd matrix = h;
    VectorXd gradient = g;
    VectorXd step = bounded_step(matrix, gradient, low, high);
    constexpr int most = 20;
    for (int round = 0; round < most; ++round) {
        bool changed = false;
        for (Index i = 0; i < count; ++i) {
            const Eigen::RowVectorXd a = here.limit_jacobian.row(i);
            const char now = here.limits[i] + a * step > 0.0 ? 1 : 0;
            char& before = counts[static_cast<std::size_t>(i)];
            if (now != before) {
                matrix += (now - before) * a.transpose() * a;
                gradient += (now - before) * here.limits[i] * a.transpose();
                before = now;
                changed = true;
            }
        }
        if (!changed) {
            break;
        }
        step = bounded_step(matrix, gradient, low, high);
    }
    // What h and g hold of the limits above 0, and what there is of all.
    predicted = -(g.dot(step) + 0.5 * step.dot(h * step));
    for (Index i = 0; i < count; ++i) {
        const double there = here.limits[i] + here.limit_jacobian.row(i) * step;
        const double held = here.limits[i] > 0.0 ? there : 0.0;
        predicted += 0.5 * (held * held - std::max(0.0, there) * std::max(0.0, there));
    }
    return step;
}

// By how much linear theory promises half of the sum of squares to fall within the cube, from here. normal, gradient:
// of here.
double promised(MatrixXd normal, const VectorXd& gradient, const VectorXd& low, const VectorXd& high,
                const Sample& here) {
    constexpr double least = 1e-9; // of the largest term: for parameters that change nothing
    normal.diagonal().array() += least * (1e-300 + normal.diagonal().maxCoeff());
    double predicted = 0.0;
    limited_step(normal, gradient, low, high, here, predicted);
    return predicted;
}

} // namespace

SearchResult gauss_newton(const std::vector<double>& start, const Objective& objective,
                          const SearchSettings& settings) {
    const auto n = static_cast<Index>(start.size());
    SearchResult result;
    std::vector<double> point = start;
    Sample here;
    ++result.evaluations;
    switch (objective(point, here)) {
    case Answer::computed: break;
    case Answer::no_answer: result.ended = "the start has no answer"; return result;
    case Answer::stop:
        result.stopped = true;
        result.ended = "stopped";
        return result;
    }
    double half = 0.5 * here.residuals.squaredNorm();
    result.unit = point;
    Eigen::RowVectorXd sizes = here.jacobian.colwise().squaredNorm();
    for (Index i = 0; i < here.limits.size(); ++i) { // whose steepness is no measure of the rest
        sizes -= here.limits[i] > 0.0 ? Eigen::RowVectorXd(here.limit_jacobian.row(i).cwiseAbs2())
                                      : Eigen::RowVectorXd(Eigen::RowVectorXd::Zero(n));
    }
    double damping = settings.damping * sizes.cwiseMax(0.0).maxCoeff();
    double raise = 2.0;
    MatrixXd curvature = MatrixXd::Zero(n, n); // of the residuals: sum of r_i times its Hessian, a secant estimate
    bool with_curvature = false;
    Sample there;
    bool is_secant = false; // the derivatives at hand
    bool is_new = true;     // the point
    int hopeless = 0;       // points in a row that promise nothing worth having
    while (true) {
        if (half < 1e-24) {
            result.converged = true;
            result.ended = "an exact fit";
            break;
        }
        const VectorXd gradient = here.jacobian.transpose() * here.residuals;
        const MatrixXd normal = here.jacobian.transpose() * here.jacobian;
        MatrixXd h = normal;
        if (with_curvature) {
            h += curvature;
        }
        // Keep it positive definite.
        const double lowest = Eigen::SelfAdjointEigenSolver<MatrixXd>(h, Eigen::EigenvaluesOnly).eigenvalues()[0];
        h.diagonal().array() += damping + std::max(0.0, -2.0 * lowest) + 1e-14 * (1.0 + normal.diagonal().maxCoeff());
        VectorXd low(n);
        VectorXd high(n);
        for (Index i = 0; i < n; ++i) {
            low[i] = -point[static_cast<std::size_t>(i)];
            high[i] = 1.0 - point[static_cast<std::size_t>(i)];
        }
        if (is_new && std::isfinite(settings.worth)) {
            constexpr double share = 0.5;
            const bool is_hopeless = promised(normal, gradient, low, high, here) < share * (half - settings.worth);
            hopeless = is_hopeless ? hopeless + 1 : 0;
            constexpr int enough = 2;
            if (hopeless == enough) {
                result.ended = "it leads to nothing as low as is wanted";
                break;
            }
        }
        is_new = false;
        double predicted = 0.0;
        const VectorXd step = limited_step(h, gradient, low, high, here, predicted);
        if (predicted <= std::max(settings.misfit_tolerance * half, settings.enough)) {
            result.converged = true;
            result.ended = "the misfit no longer changes";
            break;
        }
        if (step.cwiseAbs().maxCoeff() < settings.step_tolerance) {
            result.converged = true;
            result.ended = "the parameters no longer change";
            break;
        }
        if (result.evaluations >= settings.max_evaluations) {
            result.ended = "the limit of evaluations";
            break;
        }
        std::vector<double> trial = point;
        for (Index i = 0; i < n; ++i) {
            trial[static_cast<std::size_t>(i)] = std::clamp(point[static_cast<std::size_t>(i)] + step[i], 0.0, 1.0);
        }
        ++result.evaluations;
        there.jacobian.resize(0, 0);
        there.wants_derivatives = predicted > settings.secant_below || here.limits.size() > 0;
        const Answer answer = objective(trial, there);
        if (answer == Answer::stop) {
            result.stopped = true;
            result.ended = "stopped";
            break;
        }
        const double half_there = answer == Answer::computed ? 0.5 * there.residuals.squaredNorm() : INFINITY;
        const double gain = (half - half_there) / predicted;
        if (!(gain > 1e-4) && is_secant) {
            ++result.evaluations;
            here.wants_derivatives = true;
            if (objective(point, here) != Answer::computed) {
                result.ended = "no derivatives";
                break;
            }
            is_secant = false;
            continue;
        }
        if (!(gain > 1e-4)) {
            damping *= raise;
            raise *= 2.0;
            continue;
        }
        is_secant = there.jacobian.size() == 0;
        if (is_secant) {
            there.jacobian = here.jacobian + (there.residuals - here.residuals - here.jacobian * step) *
                                                 step.transpose() / step.squaredNorm();
        }
        // Secant update of the residuals' curvature along the step.
        const VectorXd y = (there.jacobian - here.jacobian).transpose() * there.residuals;
        const VectorXd change = there.jacobian.transpose() * there.residuals - gradient;
        const double along = change.dot(step);
        const double size = std::abs(step.dot(curvature * step));
        if (size > 0.0) {
            curvature *= std::min(1.0, std::abs(step.dot(y)) / size);
        }
        if (along > 1e-12 * change.norm() * step.norm()) {
            const VectorXd wrong = y - curvature * step;
            curvature += (wrong * change.transpose() + change * wrong.transpose()) / along -
                         step.dot(wrong) / (along * along) * (change * change.transpose());
        }
        // Which model would have predicted this gain better?
        const double plain = -(gradient.dot(step) + 0.5 * step.dot(normal * step));
        const double curved = plain - 0.5 * step.dot(curvature * step);
        with_curvature = std::abs(curved - (half - half_there)) < std::abs(plain - (half - half_there));

        damping *= std::max(1.0 / 10.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
        raise = 2.0;
        point = std::move(trial);
        std::swap(here, there);
        half = half_there;
        is_new = true;
        result.unit = point;
    }
    result.misfit = std::sqrt(2.0 * half);
    return result;
}

} // namespace explore::optimise

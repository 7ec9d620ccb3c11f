#include "analysis/road/road_course.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {
namespace {

// Of the data and of ones in their place: with both, the mean is estimated along with the rest.
using Two = std::array<double, 2>;

struct Filtered {
    std::vector<Two> predicted, state; // mean of f before and after each reading
    std::vector<double> predicted_variance, state_variance;
    double log_determinant = 0.0;
    double yy = 0.0, y1 = 0.0, ones = 0.0; // products of innovations over their variances

    double mean() const { return y1 / ones; }
    double log_likelihood() const { return -0.5 * (log_determinant + yy - y1 * y1 / ones + std::log(ones)); }
};

double kept(std::span<const double> at, std::size_t i, double length) {
    return length > 0.0 ? std::exp(-(at[i] - at[i - 1]) / length) : 0.0;
}

Filtered filter(std::span<const double> at, std::span<const double> y, std::span<const double> variance, double sd,
                double length) {
    Filtered f;
    Two state{0.0, 0.0};
    double p = sd * sd;
    for (std::size_t i = 0; i < at.size(); ++i) {
        if (i > 0) {
            const double rho = kept(at, i, length);
            state = {rho * state[0], rho * state[1]};
            p = rho * rho * p + (1.0 - rho * rho) * sd * sd;
        }
        f.predicted.push_back(state);
        f.predicted_variance.push_back(p);
        const double s = p + variance[i];
        const Two innovation{y[i] - state[0], 1.0 - state[1]};
        f.log_determinant += std::log(s);
        f.yy += innovation[0] * innovation[0] / s;
        f.y1 += innovation[0] * innovation[1] / s;
        f.ones += innovation[1] * innovation[1] / s;
        const double gain = p / s;
        state = {state[0] + gain * innovation[0], state[1] + gain * innovation[1]};
        p *= 1.0 - gain;
        f.state.push_back(state);
        f.state_variance.push_back(p);
    }
    return f;
}

} // namespace

Course course_with(std::span<const double> at, std::span<const double> y, std::span<const double> variance, double sd,
                   double length, double* log_likelihood) {
    const Filtered f = filter(at, y, variance, sd, length);
    if (log_likelihood != nullptr) {
        *log_likelihood = f.log_likelihood();
    }
    const std::size_t n = at.size();
    Course course{.mean = f.mean(),
                  .sd = sd,
                  .length = length,
                  .value = std::vector<double>(n),
                  .variance = std::vector<double>(n)};
    // Backwards (Rauch, Tung and Striebel 1965).
    Two smoothed{};
    double p = 0.0;
    for (std::size_t i = n; i-- > 0;) {
        if (i + 1 == n) {
            smoothed = f.state[i];
            p = f.state_variance[i];
        } else {
            const double before = f.predicted_variance[i + 1];
            const double gain = before > 0.0 ? f.state_variance[i] * kept(at, i + 1, length) / before : 0.0;
            for (const int k : {0, 1}) {
                smoothed[k] = f.state[i][k] + gain * (smoothed[k] - f.predicted[i + 1][k]);
            }
            p = f.state_variance[i] + gain * gain * (p - before);
        }
        course.value[i] = course.mean * (1.0 - smoothed[1]) + smoothed[0];
        course.variance[i] = p + (1.0 - smoothed[1]) * (1.0 - smoothed[1]) / f.ones;
    }
    return course;
}

Course course_of(std::span<const double> at, std::span<const double> y, std::span<const double> variance) {
    double mean = 0.0;
    double squares = 0.0;
    for (const double value : y) {
        mean += value / static_cast<double>(y.size());
    }
    for (const double value : y) {
        squares += (value - mean) * (value - mean) / static_cast<double>(y.size());
    }
    const double spread = std::max(std::sqrt(squares), 1e-12);
    const double reach = std::max(at.back() - at.front(), 1e-12);
    const double nearest = reach / static_cast<double>(at.size());
    const auto likelihood = [&](double log_sd, double log_length) {
        return filter(at, y, variance, std::exp(log_sd), std::exp(log_length)).log_likelihood();
    };
    // On a grid, which is then made finer about the best of it; alone: without a length.
    constexpr int nodes = 15;
    const auto best_on = [&](bool alone) {
        double low[2] = {std::log(1e-3 * spread), std::log(0.3 * nearest)};
        double high[2] = {std::log(10.0 * spread), std::log(3.0 * reach)};
        std::array<double, 3> best{-INFINITY, 0.0, 0.0};
        for (int pass = 0; pass < 4; ++pass) {
            double step[2];
            for (const int k : {0, 1}) {
                step[k] = (high[k] - low[k]) / (nodes - 1);
            }
            for (int a = 0; a < nodes; ++a) {
                for (int b = 0; b < (alone ? 1 : nodes); ++b) {
                    const double sd = low[0] + a * step[0];
                    const double length = alone ? -INFINITY : low[1] + b * step[1];
                    if (const double value = likelihood(sd, length); value > best[0]) {
                        best = {value, sd, length};
                    }
                }
            }
            for (const int k : {0, 1}) {
                low[k] = best[static_cast<std::size_t>(k) + 1] - 1.5 * step[k];
                high[k] = best[static_cast<std::size_t>(k) + 1] + 1.5 * step[k];
            }
        }
        return best;
    };
    const auto found = best_on(false);
    const auto alone = best_on(true);
    Course course = course_with(at, y, variance, std::exp(found[1]), std::exp(found[2]));
    course.p_none = 0.5 * gsl_cdf_chisq_Q(std::max(0.0, 2.0 * (found[0] - alone[0])), 1.0);
    return course;
}

} // namespace explore::analysis

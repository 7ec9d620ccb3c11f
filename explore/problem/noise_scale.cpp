#include "problem/noise_scale.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <numeric>

namespace explore::problem {
namespace {

constexpr double nu = 0.5;
constexpr double tail = 0.025;

} // namespace

double log_of_sought_scale(double sum, std::size_t readings) {
    const double half = 0.5 * (nu + static_cast<double>(readings));
    return 0.5 * nu * std::log(0.5 * nu) - std::lgamma(0.5 * nu) + std::lgamma(half) -
           half * std::log(0.5 * (nu + sum));
}

double sought_variance(double sum, std::size_t readings) {
    return (nu + sum) / (nu + static_cast<double>(readings));
}

double degrees_of_sought_scale(std::size_t readings) {
    return nu + static_cast<double>(readings);
}

NoiseScale noise_scale_of_fit(double sum, int degrees_of_freedom) {
    const auto dof = static_cast<double>(degrees_of_freedom);
    return {.estimate = std::sqrt(sum / dof),
            .low = std::sqrt(sum / gsl_cdf_chisq_Qinv(tail, dof)),
            .high = std::sqrt(sum / gsl_cdf_chisq_Pinv(tail, dof))};
}

NoiseScale noise_scale_of_draws(std::span<const double> sums, std::span<const double> weights, std::size_t readings) {
    const double degrees = degrees_of_sought_scale(readings);
    const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto below = [&](double k) {
        double share = 0.0;
        for (std::size_t i = 0; i < sums.size(); ++i) {
            share += weights[i] / all * gsl_cdf_chisq_Q((nu + sums[i]) / (k * k), degrees);
        }
        return share;
    };
    const auto [least, most] = std::minmax_element(sums.begin(), sums.end());
    const auto quantile = [&](double share) { // bisection in ln k, between those of the least and the largest sum
        double low = 0.5 * std::log((nu + *least) / gsl_cdf_chisq_Pinv(1.0 - share, degrees));
        double high = 0.5 * std::log((nu + *most) / gsl_cdf_chisq_Pinv(1.0 - share, degrees));
        constexpr double enough = 1e-6;
        while (high - low > enough) {
            const double middle = 0.5 * (low + high);
            (below(std::exp(middle)) < share ? low : high) = middle;
        }
        return std::exp(0.5 * (low + high));
    };
    return {.estimate = quantile(0.5), .low = quantile(tail), .high = quantile(1.0 - tail)};
}

} // namespace explore::problem

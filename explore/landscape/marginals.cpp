#include "landscape/marginals.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>
#include <numeric>

namespace explore::landscape {
namespace {

std::vector<std::size_t> ascending(std::span<const double> values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
    return order;
}

double weighted_mean(std::span<const double> values, std::span<const double> weight) {
    double sum = 0.0;
    double total = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        sum += weight[i] * values[i];
        total += weight[i];
    }
    return sum / total;
}

double weighted_covariance(std::span<const double> a, std::span<const double> b, std::span<const double> weight) {
    const double mean_a = weighted_mean(a, weight);
    const double mean_b = weighted_mean(b, weight);
    double sum = 0.0;
    double total = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += weight[i] * (a[i] - mean_a) * (b[i] - mean_b);
        total += weight[i];
    }
    return sum / total;
}

// Quantiles of the standard normal at the ranks; equal values have equal ones.
std::vector<double> rank_normal(std::span<const double> values, std::span<const double> weight) {
    const auto order = ascending(values);
    const double total = std::accumulate(weight.begin(), weight.end(), 0.0);
    std::vector<double> z(values.size());
    double below = 0.0;
    for (std::size_t i = 0; i < order.size();) {
        std::size_t end = i;
        double here = 0.0;
        while (end < order.size() && values[order[end]] == values[order[i]]) {
            here += weight[order[end++]];
        }
        const double share = std::clamp((below + 0.5 * here) / total, 1e-12, 1.0 - 1e-12);
        for (; i < end; ++i) {
            z[order[i]] = gsl_cdf_ugaussian_Pinv(share);
        }
        below += here;
    }
    return z;
}

double potential_scale_reduction(std::span<const double> z, const Descent& descent) {
    std::map<int, std::pair<std::vector<double>, std::vector<double>>> populations;
    for (std::size_t i = 0; i < z.size(); ++i) {
        auto& [values, weight] = populations[descent.population[i]];
        values.push_back(z[i]);
        weight.push_back(descent.weight[i]);
    }
    const auto m = static_cast<double>(populations.size());
    std::vector<double> means;
    double within = 0.0;
    for (const auto& [number, draws] : populations) {
        means.push_back(weighted_mean(draws.first, draws.second));
        within += weighted_covariance(draws.first, draws.first, draws.second) / m;
    }
    const double mean = std::accumulate(means.begin(), means.end(), 0.0) / m;
    double between = 0.0;
    for (const double value : means) {
        between += (value - mean) * (value - mean) / (m - 1.0);
    }
    if (within <= 0.0) {
        return between > 0.0 ? INFINITY : 1.0;
    }
    return std::sqrt(1.0 - m / static_cast<double>(z.size()) + between / within);
}

double effective_draws(std::span<const double> z, const Descent& descent) {
    const double mean = weighted_mean(z, descent.weight);
    std::map<std::pair<int, int>, double> families;
    double total = 0.0;
    double variance = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) {
        const double w = descent.weight[i];
        families[{descent.population[i], descent.ancestor[i]}] += w * (z[i] - mean);
        variance += w * (z[i] - mean) * (z[i] - mean);
        total += w;
    }
    double squares = 0.0;
    for (const auto& [who, sum] : families) {
        squares += sum * sum;
    }
    const auto n = static_cast<double>(families.size());
    const double error = squares / (total * total) * n / std::max(1.0, n - 1.0); // squared, of the mean
    const double most = descent.effective_weights();
    return error > 0.0 ? std::min(most, variance / total / error) : most;
}

} // namespace

double Descent::effective_weights() const {
    double sum = 0.0;
    double squares = 0.0;
    for (const double w : weight) {
        sum += w;
        squares += w * w;
    }
    return squares > 0.0 ? sum * sum / squares : 0.0;
}

double weighted_quantile(std::span<const double> values, std::span<const double> weight, double share) {
    const auto order = ascending(values);
    const double target = share * std::accumulate(weight.begin(), weight.end(), 0.0);
    double before = 0.0; // weight up to the middle of the draw before
    double done = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const double middle = done + 0.5 * weight[order[k]];
        if (middle >= target) {
            if (k == 0) {
                return values[order[0]];
            }
            const double low = values[order[k - 1]];
            return low + (values[order[k]] - low) * (target - before) / (middle - before);
        }
        before = middle;
        done += weight[order[k]];
    }
    return values[order.back()];
}

double weighted_correlation(std::span<const double> a, std::span<const double> b, std::span<const double> weight) {
    const double scale = std::sqrt(weighted_covariance(a, a, weight) * weighted_covariance(b, b, weight));
    return scale > 0.0 ? weighted_covariance(a, b, weight) / scale : 0.0;
}

Marginal marginal(std::span<const double> values, const Descent& descent) {
    Marginal m;
    m.mean = weighted_mean(values, descent.weight);
    m.sd = std::sqrt(weighted_covariance(values, values, descent.weight));
    m.q025 = weighted_quantile(values, descent.weight, 0.025);
    m.q50 = weighted_quantile(values, descent.weight, 0.5);
    m.q975 = weighted_quantile(values, descent.weight, 0.975);
    std::vector<double> folded;
    folded.reserve(values.size());
    for (const double v : values) {
        folded.push_back(std::abs(v - m.q50));
    }
    const auto z = rank_normal(values, descent.weight);
    m.rhat = std::max(potential_scale_reduction(z, descent),
                      potential_scale_reduction(rank_normal(folded, descent.weight), descent));
    m.ess = effective_draws(z, descent);
    return m;
}

} // namespace explore::landscape

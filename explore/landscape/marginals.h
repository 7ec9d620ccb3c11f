// Marginals of a weighted sample from several independent populations, and how far they can be trusted.
#pragma once

#include <span>
#include <vector>

namespace explore::landscape {

// Where the draws of a sample come from. Draws with one ancestor in one population may depend on each other, all others
// are independent.
struct Descent {
    std::vector<double> weight; // of each draw, of any sum
    std::vector<int> population, ancestor;

    std::size_t size() const { return weight.size(); }
    // (sum of weights)^2 / sum of squares: how many draws of equal weight are worth as much (Kish 1965).
    double effective_weights() const;
};

struct Marginal {
    double mean = 0.0, sd = 0.0;
    double q025 = 0.0, q50 = 0.0, q975 = 0.0;
    // Agreement of the populations, of the values and of their distances from the median: the rank-normalised R-hat of
    // Vehtari et al. (2021, Bayesian Analysis 16, doi 10.1214/20-BA1221), without splitting the populations.
    double rhat = 1.0;
    // Independent draws with the same error of the mean rank. That error is estimated from the sums over draws of one
    // ancestor (Lee and Whiteley 2018, Biometrika 105, doi 10.1093/biomet/asy028) about the mean of all populations.
    double ess = 0.0;
};

// values: one a draw, finite. At least two populations.
Marginal marginal(std::span<const double> values, const Descent& descent);

// The value below which this share of the weight lies, linear between the middles of draws.
double weighted_quantile(std::span<const double> values, std::span<const double> weight, double share);
// Correlation coefficient; 0 where one does not vary.
double weighted_correlation(std::span<const double> a, std::span<const double> b, std::span<const double> weight);

} // namespace explore::landscape

// Noise whose size is fitted: k times what is stated, with one k for all readings. With the prior
//     k^2 ~ a scaled inverse chi2 with nu = 1/2 degrees of freedom around 1,
// which counts as half a reading that errs by as much as is stated and is next to flat in ln k over decades, k is
// integrated out exactly: n independent normal errors of k standard deviations with the sum of squares S have the
// density
//     (2 pi)^(-n/2) (nu/2)^(nu/2) / Gamma(nu/2) Gamma((nu + n)/2) ((nu + S)/2)^(-(nu + n)/2),
// a multivariate t (Gelman et al. 2013, Bayesian Data Analysis, 3rd ed., 3.2), and given S
//     k^2 = (nu + S) / chi2(nu + n).
#pragma once

#include <cstddef>
#include <span>

namespace explore::problem {

// The logarithm of that density times (2 pi)^(n/2): what takes the place of -S/2.
double log_of_sought_scale(double sum, std::size_t readings);
// k^2 where normal noise of that size has the same slope of ln density by S: (nu + S) / (nu + n).
double sought_variance(double sum, std::size_t readings);
// Degrees of freedom of the t distribution of one more reading, whose scale is the root of that: nu + n.
double degrees_of_sought_scale(std::size_t readings);

// k, with its 95 % range.
struct NoiseScale {
    double estimate = 1.0;
    double low = 0.0, high = 0.0;
};
// Of a fit that leaves the sum of squares `sum` over: with a flat prior of ln k and of the parameters, of which the
// residuals are linear functions, k^2 = sum / chi2(degrees_of_freedom). degrees_of_freedom: at least 1.
NoiseScale noise_scale_of_fit(double sum, int degrees_of_freedom);
// Of draws of the posterior with these sums and weights: the median and quantiles of the mixture of k given each.
NoiseScale noise_scale_of_draws(std::span<const double> sums, std::span<const double> weights, std::size_t readings);

} // namespace explore::problem

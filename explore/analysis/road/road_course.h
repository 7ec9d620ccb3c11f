// The smooth course along a road of a parameter that each station has for itself.
#pragma once

#include <span>
#include <vector>

namespace explore::analysis {

// Values y at places, each with an error of known variance, as mean + f + error, f a Gaussian process with the
// covariance sd^2 exp(-distance / length).
struct Course {
    double mean = 0.0, sd = 0.0, length = 0.0; // length: of the places
    // p of the hypothesis that neighbours are no more alike than any two stations (length 0): twice the difference of
    // the log likelihoods is then half of a chi2 variable with one degree of freedom (Self and Liang 1987,
    // doi 10.1080/01621459.1987.10478472).
    double p_none = 1.0;
    std::vector<double> value, variance; // of mean + f at the places, in their order
};

// sd and length by restricted maximum likelihood, the rest by universal kriging. at: ascending; at least three places.
// By a Kalman filter and smoother: the cost is linear in the places.
Course course_of(std::span<const double> at, std::span<const double> y, std::span<const double> variance);
// For given sd and length; log_likelihood: restricted, up to a constant. length 0: independent f.
Course course_with(std::span<const double> at, std::span<const double> y, std::span<const double> variance, double sd,
                   double length, double* log_likelihood = nullptr);

} // namespace explore::analysis

// The stated error of a reading, and a residual in units of it.
#pragma once

#include <optional>
#include <string_view>

namespace explore::data {

// The stated error of a reading: its standard deviation is sqrt(absolute^2 + drift^2 + (relative v)^2), v the value
// without error.
//
// A residual in units of it has to have the variance 1 whatever v is, and v is not known: divided by the standard
// deviation at the measured value, low readings weigh more and estimates are biased towards them. So readings are
// compared on the scale on which their noise is the same everywhere (Bartlett 1947, Biometrics 3):
//     h(v) = asinh(relative v / absolute) / relative,   dh/dv = 1 / standard deviation,
// with drift in the absolute part, v / absolute without a relative part, and the logarithm over `relative` where the
// relative part is all there is (an absolute part of a tenth of it keeps h finite through zero). The mean of
// h(measured) lies below h(v) by relative^2 v / (2 standard deviation), to second order: that is added back.
struct Noise {
    double absolute = 0.0; // SI; both 0: not stated
    double relative = 0.0;
    // Errors that the readings of a load have in common. The share of `relative` that is one error for all of them:
    double common_relative = 0.0;
    // The rest of the errors of two readings of one quantity: see own_correlation().
    double correlation_length = 0.0; // m
    double correlation_time = 0.0;   // s
    // SI: what a sensor has drifted by this reading, or its error in all drops alike, times a standard normal number
    // that all readings of the sensor have in common.
    double drift = 0.0;
    // Of Student's t distribution, whose scale the deviations then are: more large errors than a normal one has; 0:
    // normal.
    double degrees = 0.0;
    // Whether the noise is this but for one factor, the same for all readings, that is fitted too.
    bool scale_is_sought = false;

    bool is_stated() const { return absolute > 0.0 || relative > 0.0; }
    double deviation(double value) const;     // standard deviation [SI]
    double own_deviation(double value) const; // without the errors in common
    // The residual of a model's value against a measured one, and its derivative by the model's.
    double residual(double model, double measured) const;
    double slope(double model, double measured) const;
};

// The content of a reading: its value, or that without an error of its own it would lie below or above it: less than an
// instrument tells from nothing ("<12"), more than it can read (">2000").
enum class Censored { no, below, above };
std::string_view sign_of(Censored censored); // "", "<", ">"

// Where a reading was taken, for the correlation of its noise.
struct NoisePlace {
    int load = -1; // index; negative: its noise is correlated with none
    int quantity = 0;
    double x = 0.0, y = 0.0, depth = 0.0; // m
    std::optional<double> time{};         // s; none: of the load as a whole
};
// Whether two readings are of one sensor, at whatever time.
bool is_one_sensor(const NoisePlace& a, const NoisePlace& b);
// Correlation of the errors of two readings without those in common: exp(-distance / length - difference of times /
// time). 0 between readings of different loads or quantities, at different places for length 0, at different times for
// time 0, and where both are 0. Positive definite over places and times that differ (Matern 1960, order 1/2).
double own_correlation(const NoisePlace& a, const NoisePlace& b, double length, double time = 0.0);

} // namespace explore::data

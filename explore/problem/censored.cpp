#include "problem/censored.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_sf_erf.h>
#include <numbers>

namespace explore::problem {
namespace {

constexpr double nothing = -30.0; // of z of a limit from above: rows are below 1e-98

// Of a limit from above, whose mirror image the other is.
double mirrored(double z, data::Censored side) {
    return side == data::Censored::above ? -z : z;
}

double log_below(double z) { // ln Phi(-z)
    return z < 0.0 ? std::log1p(-0.5 * std::erfc(-z / std::numbers::sqrt2))
                   : gsl_sf_log_erfc(z / std::numbers::sqrt2) - std::numbers::ln2;
}

double inverse_mills(double z) {
    return z < 0.0 ? std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi) /
                         (1.0 - 0.5 * std::erfc(-z / std::numbers::sqrt2))
                   : gsl_sf_hazard(z);
}

} // namespace

double censored_row(double z, data::Censored side) {
    const double row = std::sqrt(-2.0 * log_below(mirrored(z, side)));
    return side == data::Censored::above ? -row : row;
}

double censored_row_slope(double z, data::Censored side) {
    const double own = mirrored(z, side);
    return own < nothing ? 0.0 : inverse_mills(own) / std::abs(censored_row(z, side));
}

double censored_information(double z, data::Censored side) {
    const double own = mirrored(z, side);
    const double m = inverse_mills(own);
    return std::clamp(m * (m - own), 0.0, 1.0);
}

} // namespace explore::problem

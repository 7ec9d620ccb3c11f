#include "layered/plate.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pave::layered {

namespace {

// Gauss and Legendre with eight points on [-1, 1]: places and weights of one half.
constexpr std::array<double, 4> places{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr std::array<double, 4> weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

template <class F>
double integral(double low, double high, const F& f) {
    const double middle = 0.5 * (low + high);
    const double half = 0.5 * (high - low);
    double sum = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        sum += weights[i] * (f(middle - half * places[i]) + f(middle + half * places[i]));
    }
    return half * sum;
}

} // namespace

double plate_deflection(Foundation foundation, double radius, double distance, double stiffness) {
    const double a = radius / stiffness;
    const double r = distance / stiffness;
    const bool is_liquid = foundation == Foundation::dense_liquid;
    const auto integrand = [&](double t) {
        const double bessel = ::j0(t * r) * ::j1(t * a);
        return is_liquid ? bessel / (1.0 + t * t * t * t) : bessel / (t * (1.0 + t * t * t));
    };
    // Panels as fine as the Bessel functions and the poles at |t| = 1 ask for, to where t^-4 leaves nothing.
    constexpr double end = 120.0;
    double sum = 0.0;
    for (double low = 0.0; low < end;) {
        const double smooth = std::max(0.25, 0.25 * low);
        const double wave = 2.0 / std::max(a, r);
        const double high = std::min(end, low + std::min(smooth, wave));
        sum += integral(low, high, integrand);
        low = high;
    }
    return (is_liquid ? a : radius) * sum;
}

double flexural_rigidity(double modulus, double thickness, double poisson) {
    return modulus * thickness * thickness * thickness / (12.0 * (1.0 - poisson * poisson));
}

} // namespace pave::layered

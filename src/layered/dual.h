// Numbers that carry their derivatives: forward differentiation of the recursions over the layers.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace pave::layered {

// A value and its derivatives in N directions at once.
template <int N>
struct Dual {
    using Rates = Eigen::Array<double, N, 1>;
    double v = 0.0;
    Rates d = Rates::Zero();

    Dual() = default;
    Dual(double value) : v(value) {} // NOLINT(google-explicit-constructor): constants stand in formulas
    Dual(double value, const Rates& rates) : v(value), d(rates) {}
};

template <int N>
Dual<N> operator+(const Dual<N>& a, const Dual<N>& b) {
    return {a.v + b.v, a.d + b.d};
}
template <int N>
Dual<N> operator-(const Dual<N>& a, const Dual<N>& b) {
    return {a.v - b.v, a.d - b.d};
}
template <int N>
Dual<N> operator-(const Dual<N>& a) {
    return {-a.v, -a.d};
}
template <int N>
Dual<N> operator*(const Dual<N>& a, const Dual<N>& b) {
    return {a.v * b.v, a.d * b.v + a.v * b.d};
}
template <int N>
Dual<N> operator*(double a, const Dual<N>& b) {
    return {a * b.v, a * b.d};
}
template <int N>
Dual<N> operator+(double a, const Dual<N>& b) {
    return {a + b.v, b.d};
}
template <int N>
Dual<N> operator-(double a, const Dual<N>& b) {
    return {a - b.v, -b.d};
}
template <int N>
Dual<N> operator/(const Dual<N>& a, const Dual<N>& b) {
    const double inverse = 1.0 / b.v;
    const double ratio = a.v * inverse;
    return {ratio, (a.d - ratio * b.d) * inverse};
}
template <int N>
Dual<N> operator/(double a, const Dual<N>& b) {
    return Dual<N>(a) / b;
}
template <int N>
Dual<N> operator-(const Dual<N>& a, double b) {
    return {a.v - b, a.d};
}
template <int N>
Dual<N> sqrt(const Dual<N>& a) {
    const double root = std::sqrt(a.v);
    return {root, a.d * (0.5 / root)};
}

inline double value_of(double a) {
    return a;
}
template <int N>
double value_of(const Dual<N>& a) {
    return a.v;
}

} // namespace pave::layered

#include "mechanics/cross_anisotropic.h"

#include <array>

namespace pave::mechanics {
namespace {

// A number with its derivative, enough arithmetic for the formulas below.
struct Dual {
    double v;
    double d;
};
Dual operator+(Dual a, Dual b) {
    return {a.v + b.v, a.d + b.d};
}
Dual operator-(Dual a, Dual b) {
    return {a.v - b.v, a.d - b.d};
}
Dual operator*(Dual a, Dual b) {
    return {a.v * b.v, a.d * b.v + a.v * b.d};
}
Dual operator/(Dual a, Dual b) {
    return {a.v / b.v, (a.d - a.v / b.v * b.d) / b.v};
}

template <class T>
struct Numbers {
    T n, nu12, nu31, shear_ratio;
};

template <class T>
std::array<T, 5> moduli(const Numbers<T>& q, bool given_shear_ratio, bool vertical, T one) {
    const T two = one + one;
    const T e3 = vertical ? one : one / q.n;
    const T e1 = vertical ? q.n : one;
    const T nu13 = q.n * q.nu31;
    const T l = one / (one - q.nu12 * q.nu12 - two * nu13 * q.nu31 - two * q.nu12 * nu13 * q.nu31);
    std::array<T, 5> d;
    d[0] = e1 * (one - nu13 * q.nu31) * l;
    d[1] = e3 * (one - q.nu12 * q.nu12) * l;
    d[2] = e1 * (q.nu12 + q.nu31 * nu13) * l;
    d[3] = e1 * (q.nu31 + q.nu12 * q.nu31) * l;
    d[4] = given_shear_ratio ? q.shear_ratio * e3 : one / (one / e1 + (one + two * q.nu31) / e3);
    return d;
}

// d: D11, D33, D12, D13, G13. D1212 = (D11 - D12)/2 in a plane of isotropy.
Stiffness<6> fill(const std::array<double, 5>& d) {
    Stiffness<6> c = Stiffness<6>::Zero();
    c(0, 0) = c(1, 1) = d[0];
    c(2, 2) = d[1];
    c(0, 1) = c(1, 0) = d[2];
    c(0, 2) = c(2, 0) = c(1, 2) = c(2, 1) = d[3];
    c(3, 3) = c(4, 4) = d[4];
    c(5, 5) = (d[0] - d[2]) / 2.0;
    return c;
}

} // namespace

Stiffness<6> CrossAnisotropy::unit_stiffness() const {
    const Numbers<double> q{n, nu12, nu31, shear_ratio.value_or(0.0)};
    return fill(moduli(q, shear_ratio.has_value(), modulus_is_vertical, 1.0));
}

Stiffness<6> CrossAnisotropy::unit_stiffness_derivative(Variable variable) const {
    const Numbers<Dual> q{{n, variable == Variable::n ? 1.0 : 0.0},
                          {nu12, variable == Variable::nu12 ? 1.0 : 0.0},
                          {nu31, variable == Variable::nu31 ? 1.0 : 0.0},
                          {shear_ratio.value_or(0.0), variable == Variable::shear_ratio ? 1.0 : 0.0}};
    const auto dual = moduli(q, shear_ratio.has_value(), modulus_is_vertical, Dual{1.0, 0.0});
    std::array<double, 5> d{};
    for (std::size_t i = 0; i < 5; ++i) {
        d[i] = dual[i].d;
    }
    return fill(d);
}

std::string CrossAnisotropy::impossible() const {
    if (!(n > 0.0)) {
        return "the modulus ratio n must be positive";
    }
    if (!(nu12 > -1.0 && nu12 < 1.0)) {
        return "Poisson's ratio in the plane must lie between -1 and 1";
    }
    if (!(1.0 - nu12 - 2.0 * n * nu31 * nu31 > 0.0)) {
        return "1 - nu12 - 2 n nu31^2 must be positive, or some strain would cost no energy";
    }
    if (shear_ratio && !(*shear_ratio > 0.0)) {
        return "the shear ratio G13/E3 must be positive";
    }
    if (!shear_ratio && !(1.0 + (1.0 + 2.0 * nu31) * n > 0.0)) {
        return "the shear modulus 1/G13 = 1/E1 + (1 + 2 nu31)/E3 must be positive";
    }
    return {};
}

} // namespace pave::mechanics

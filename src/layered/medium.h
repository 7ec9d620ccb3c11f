// One cross-anisotropic elastic material with a vertical axis under the Hankel transform.
//
// Displacements u_r = U(z) J1(k r), u_z = W(z) J0(k r) and tractions s_rz = T(z) J1(k r), s_zz = S(z) J0(k r) (z down,
// tension positive) obey
//     U' = T/C44 + k W,  W' = (S - C13 k U)/C33,  T' = (C11 - C13^2/C33) k^2 U + (C13/C33) k S,  S' = -k T.
// Decaying downwards: (U, W)(z) = exp(-k z M) (U, W)(0) with (T, S) = k Z (U, W); decaying upwards, it is the
// mirror image: W and T change their signs. M has the eigenvalues l1, l2 with
//     l1 l2 = q = sqrt(C11/C33),  (l1 + l2)^2 = p^2 = (s - C13)(s + C13 + 2 C44)/(C33 C44),  s = sqrt(C11 C33),
// which are equal for an isotropic material and may be a complex pair: the exponential is written without them.
// Formulas: the equations above put into each other; the eigenvalues are those of S. G. Lekhnitskii, "Theory of
// elasticity of an anisotropic body" (1963).
#pragma once

#include "layered/dual.h"

#include <algorithm>

namespace pave::layered {

template <class R>
struct Matrix2 {
    R a11, a12, a21, a22;
};
template <class R>
Matrix2<R> operator*(const Matrix2<R>& a, const Matrix2<R>& b) {
    return {a.a11 * b.a11 + a.a12 * b.a21, a.a11 * b.a12 + a.a12 * b.a22, a.a21 * b.a11 + a.a22 * b.a21,
            a.a21 * b.a12 + a.a22 * b.a22};
}

template <class R>
struct Vector2 {
    R a1, a2;
};
template <class R>
Vector2<R> operator*(const Matrix2<R>& a, const Vector2<R>& b) {
    return {a.a11 * b.a1 + a.a12 * b.a2, a.a21 * b.a1 + a.a22 * b.a2};
}
template <class R>
Vector2<R> operator+(const Vector2<R>& a, const Vector2<R>& b) {
    return {a.a1 + b.a1, a.a2 + b.a2};
}
template <class R>
Vector2<R> operator-(const Vector2<R>& a, const Vector2<R>& b) {
    return {a.a1 - b.a1, a.a2 - b.a2};
}

template <class R>
struct Symmetric2 {
    R a11, a12, a22;
};
template <class R>
Vector2<R> operator*(const Symmetric2<R>& a, const Vector2<R>& b) {
    return {a.a11 * b.a1 + a.a12 * b.a2, a.a12 * b.a1 + a.a22 * b.a2};
}

// exp(-rate x) cosh(sqrt(d) x) and exp(-rate x) sinh(sqrt(d) x)/sqrt(d), for any sign of d: entire functions of d.
// dd_sinh: the derivative of the second by d; wanted where it is not null.
struct Decay {
    double cosh, sinh;
};
inline Decay decay(double x, double rate, double d, double* dd_sinh = nullptr) {
    const double y = d * x * x;
    if (rate * x - std::sqrt(std::max(y, 0.0)) > 300.0) { // of no account
        if (dd_sinh != nullptr) {
            *dd_sinh = 0.0;
        }
        return {0.0, 0.0};
    }
    if (std::abs(y) < 1.0) {
        const double fall = std::exp(-rate * x);
        double term = 1.0; // y^n / (2 n)!
        double cosh = 1.0;
        double sinh = 1.0;
        double slope = 0.0; // sum of n y^(n-1) / (2 n + 1)!
        for (int n = 1; n < 12; ++n) {
            const double before = term / ((2 * n - 1) * (2 * n)); // y^(n-1) / (2 n)!
            term = y * before;
            cosh += term;
            sinh += term / (2 * n + 1);
            slope += n * before / (2 * n + 1);
            if (std::abs(before) < 1e-17) {
                break;
            }
        }
        if (dd_sinh != nullptr) {
            *dd_sinh = fall * x * x * x * slope;
        }
        return {fall * cosh, fall * x * sinh};
    }
    Decay result{};
    const double root = std::sqrt(std::abs(d));
    if (d > 0.0) {
        const double slow = std::exp(-(rate - root) * x);
        const double fast = std::exp(-(rate + root) * x);
        result = {(slow + fast) / 2.0, (slow - fast) / (2.0 * root)};
    } else {
        const double fall = std::exp(-rate * x);
        result = {fall * std::cos(root * x), fall * std::sin(root * x) / root};
    }
    if (dd_sinh != nullptr) {
        *dd_sinh = (x * result.cosh - result.sinh) / (2.0 * d);
    }
    return result;
}

// Of the stiffness, all that an axisymmetric state feels but C12 [Pa].
template <class R>
struct Elastic {
    R c11, c12, c13, c33, c44;
};

template <class R>
class Medium {
public:
    explicit Medium(const Elastic<R>& c) {
        using std::sqrt;
        const R s = sqrt(c.c11 * c.c33);
        const R q = s / c.c33;
        const R p = sqrt((s - c.c13) * (s + c.c13 + 2.0 * c.c44) / (c.c33 * c.c44));
        const R g = c.c13 + c.c44;
        rate_ = 0.5 * p;
        d_ = (s + c.c13) * (s - c.c13 - 2.0 * c.c44) / (4.0 * c.c33 * c.c44);
        const R m11 = (c.c11 + c.c44 * q) / (c.c44 * p + g * g / (c.c33 * p));
        const R m22 = (c.c44 + s) / (c.c33 * p + g * g / (c.c44 * p));
        const R m12 = -(g * m22 / (c.c44 * p));
        n_ = {m11 - rate_, m12, g * m11 / (c.c33 * p), m22 - rate_};
        z_ = {-(c.c44 * m11), -(c.c44 * (1.0 + m12)), -(c.c33 * m22)};
    }

    // Z [Pa]: negative definite.
    const Symmetric2<R>& impedance() const { return z_; }

    // exp(-x M), x = k times a distance.
    Matrix2<R> propagate(const R& x) const {
        const auto [cosh, sinh] = decay_at(x);
        return {cosh - sinh * n_.a11, -(sinh * n_.a12), -(sinh * n_.a21), cosh - sinh * n_.a22};
    }

    // The real part of the eigenvalue of slower decay.
    double slowest() const { return value_of(rate_) - std::sqrt(std::max(value_of(d_), 0.0)); }

private:
    struct Both {
        R cosh, sinh;
    };
    Both decay_at(const R& x) const {
        if constexpr (std::is_same_v<R, double>) {
            const Decay f = decay(x, rate_, d_);
            return {f.cosh, f.sinh};
        } else {
            double dd_sinh = 0.0;
            const Decay f = decay(x.v, rate_.v, d_.v, &dd_sinh);
            return {R(f.cosh, (d_.v * f.sinh - rate_.v * f.cosh) * x.d - (x.v * f.cosh) * rate_.d +
                                  (0.5 * x.v * f.sinh) * d_.d),
                    R(f.sinh, (f.cosh - rate_.v * f.sinh) * x.d - (x.v * f.sinh) * rate_.d + dd_sinh * d_.d)};
        }
    }

    R rate_, d_;   // (l1 + l2)/2 and ((l1 - l2)/2)^2
    Matrix2<R> n_; // M - rate
    Symmetric2<R> z_;
};

} // namespace pave::layered

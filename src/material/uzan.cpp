#include "material/uzan.h"

#include "base/units.h"
#include "mechanics/cross_anisotropic.h"

#include <algorithm>
#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { modulus_axis, k1, k2, k3, n, poisson_12, poisson_31, shear_ratio, delta, eta };

constexpr double pa = unit::reference_pressure;

class Uzan final : public Law {
public:
    std::string_view name() const override { return "uzan"; }
    std::string_view summary() const override {
        return "stress-dependent, cross-anisotropic: E = k1 pa (theta/pa)^k2 (tau/pa + 1)^k3";
    }
    std::span<const ParameterInfo> parameters() const override {
        static const ParameterInfo infos[] = {
            {"modulus_axis", 1.0, 0.0, 1.0, false, 0.0, "which modulus the law gives", {"horizontal", "vertical"}},
            {"k1", 1.0, 0.0, 1e6, true, {}, "modulus at theta = pa without shear, in units of pa = 100 kPa", {}},
            {"k2", 1.0, -5.0, 5.0, false, {}, "exponent of confinement: stiffens when positive", {}},
            {"k3", 1.0, -50.0, 50.0, false, {}, "exponent of shear: softens when negative", {}},
            {"n", 1.0, 0.0, 20.0, true, {}, "horizontal over vertical modulus, E1/E3", {}},
            {"poisson_12", 1.0, -0.99, 0.99, false, {}, "Poisson's ratio in the horizontal plane", {}},
            {"poisson_31", 1.0, -0.99, 2.0, false, {}, "horizontal strain from vertical load", {}},
            {"shear_ratio", 1.0, 0.0, 10.0, true, not_given, "G13/E3; without it 1/G13 = 1/E1 + (1 + 2 nu31)/E3", {}},
            {"tension_smoothing_kPa", unit::kPa, 0.0, 1e3, true, 5.0, "delta, the smooth floor of theta", {}},
            {"shear_floor",
             1.0,
             0.0,
             10.0,
             false,
             not_given,
             "eta, floor of theta in proportion to shear; default 0 incremental, 1 secant",
             {}},
        };
        return infos;
    }
    bool stress_dependent() const override { return true; }
    std::size_t scale_parameter() const override { return k1; }

    Modulus modulus(std::span<const double> p, mechanics::Invariants at) const override {
        const Floor floor(p, at);
        const double e = value(p, at, floor);
        if (!(e < modulus_limit)) {
            return {.value = modulus_limit, .d_theta = 0.0, .d_tau = 0.0, .limited = true};
        }
        return {.value = e,
                .d_theta = e * p[k2] / floor.root,
                .d_tau =
                    e * (p[k2] * 2.0 * p[eta] * p[eta] * at.tau / (floor.root * floor.thp) + p[k3] / (at.tau + pa)),
                .limited = false};
    }

    double modulus_derivative(std::span<const double> p, mechanics::Invariants at, std::size_t i) const override {
        const Floor floor(p, at);
        const double e = value(p, at, floor);
        if (!(e < modulus_limit)) {
            return 0.0;
        }
        switch (i) {
        case k1: return e / p[k1];
        case k2: return e * std::log(floor.thp / pa);
        case k3: return e * std::log1p(at.tau / pa);
        case delta: return e * p[k2] * 2.0 * p[delta] / (floor.root * floor.thp);
        case eta: return e * p[k2] * 2.0 * p[eta] * at.tau * at.tau / (floor.root * floor.thp);
        default: return 0.0;
        }
    }

    mechanics::Stiffness<6> unit_stiffness(std::span<const double> p) const override {
        return directions(p).unit_stiffness();
    }
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, std::size_t i) const override {
        using Variable = mechanics::CrossAnisotropy::Variable;
        switch (i) {
        case n: return directions(p).unit_stiffness_derivative(Variable::n);
        case poisson_12: return directions(p).unit_stiffness_derivative(Variable::nu12);
        case poisson_31: return directions(p).unit_stiffness_derivative(Variable::nu31);
        case shear_ratio: return directions(p).unit_stiffness_derivative(Variable::shear_ratio);
        default: return mechanics::Stiffness<6>::Zero();
        }
    }

    std::string impossible(std::span<const double> p) const override { return directions(p).impossible(); }

private:
    // thp and the square root in it, without cancellation in tension.
    struct Floor {
        double root;
        double thp;
        Floor(std::span<const double> p, mechanics::Invariants at) {
            const double c = p[delta] * p[delta] + p[eta] * p[eta] * at.tau * at.tau;
            root = std::sqrt(at.theta * at.theta + 4.0 * c);
            thp = at.theta >= 0.0 ? (at.theta + root) / 2.0 : 2.0 * c / (root - at.theta);
        }
    };

    static double value(std::span<const double> p, mechanics::Invariants at, const Floor& floor) {
        return p[k1] * pa * std::exp(p[k2] * std::log(floor.thp / pa) + p[k3] * std::log1p(at.tau / pa));
    }

    static mechanics::CrossAnisotropy directions(std::span<const double> p) {
        return {.n = p[n],
                .nu12 = p[poisson_12],
                .nu31 = p[poisson_31],
                .shear_ratio = std::isnan(p[shear_ratio]) ? std::nullopt : std::optional(p[shear_ratio]),
                .modulus_is_vertical = p[modulus_axis] == 1.0};
    }
};

} // namespace

const Law& uzan() {
    static const Uzan law;
    return law;
}

} // namespace pave::material

#include "material/uzan_separate.h"

#include "material/floor.h"
#include "material/uzan.h"
#include "mechanics/cross_anisotropic.h"

#include <algorithm>

namespace pave::material {
namespace {

using mechanics::CrossAnisotropy;
using mechanics::Invariants;
using mechanics::Stiffness;
using Variable = CrossAnisotropy::Variable;

// Three k's a modulus, then what they share.
enum : std::size_t {
    vertical = 0,
    horizontal = 3,
    shear = 6,
    n_lowest = 9,
    n_highest,
    poisson_12,
    poisson_31,
    delta,
    eta
};

// G13/E3 stays within these.
constexpr double lowest_shear_ratio = 1e-3;
constexpr double highest_shear_ratio = 10.0;

// A stress state as the moduli see it.
struct State {
    Floor floor;
    UzanStress stress;
    State(std::span<const double> p, Invariants at) : floor(p[delta], p[eta], at), stress{floor.thp, at.tau} {}

    // Of thp by delta or eta.
    double floor_rate(std::span<const double> p, std::size_t i) const {
        return i == delta ? floor.by_delta(p[i]) : floor.by_eta(p[i], stress.tau);
    }
};

// An exponent of a modulus (1: k2, 2: k3) beyond that of the vertical one, from which it comes where it is not given.
double beyond(std::span<const double> p, std::size_t of, std::size_t exponent) {
    const double own = p[of + exponent];
    return std::isnan(own) ? 0.0 : own - p[vertical + exponent];
}

// A modulus over the vertical one.
struct Ratio {
    double value;
    double d_thp = 0.0;
    double d_tau = 0.0;
    std::optional<std::size_t> limit{}; // which of its limits it stays at
};

Ratio ratio(std::span<const double> p, std::size_t of, const State& s, double lowest, double highest) {
    const double confined = beyond(p, of, 1);
    const double distorted = beyond(p, of, 2);
    const double value = p[of] / p[vertical] * s.stress.factor(confined, distorted);
    if (!(value > lowest)) {
        return {.value = lowest, .limit = n_lowest};
    }
    if (!(value < highest)) {
        return {.value = highest, .limit = n_highest};
    }
    return {.value = value, .d_thp = s.stress.by_thp(value, confined), .d_tau = s.stress.by_tau(value, distorted)};
}

// d(ratio)/dp[i]
double ratio_rate(std::span<const double> p, std::size_t of, const State& s, const Ratio& here, std::size_t i) {
    if (here.limit) {
        return of == horizontal && here.limit == i ? 1.0 : 0.0;
    }
    if (i == delta || i == eta) {
        return here.d_thp * s.floor_rate(p, i);
    }
    const bool of_vertical = i < horizontal;
    if (!of_vertical && (i < of || i > of + 2)) {
        return 0.0;
    }
    const std::size_t exponent = i - (of_vertical ? vertical : of);
    if (exponent > 0 && std::isnan(p[of + exponent])) {
        return 0.0;
    }
    const double logarithm = exponent == 0 ? 1.0 / p[i] : exponent == 1 ? s.stress.confinement : s.stress.distortion;
    return (of_vertical ? -1.0 : 1.0) * here.value * logarithm;
}

// The directions at a stress state.
struct Directions {
    State state;
    Ratio n, g;
    CrossAnisotropy solid;
    Directions(std::span<const double> p, Invariants at)
        : state(p, at),
          n(ratio(p, horizontal, state, p[n_lowest], p[n_highest])),
          g(ratio(p, shear, state, lowest_shear_ratio, highest_shear_ratio)),
          solid{.n = n.value,
                .nu12 = p[poisson_12],
                .nu31 = p[poisson_31],
                .shear_ratio = g.value,
                .modulus_is_vertical = true} {}
};

class UzanSeparate final : public Law {
public:
    std::string_view name() const override { return "uzan-separate"; }
    std::string_view summary() const override {
        return "stress-dependent: uzan for the vertical, the horizontal and the shear modulus, each with its own k's";
    }
    std::span<const ParameterInfo> parameters() const override {
        static constexpr UsualRange lower{30, 6000, 500, true};
        static const ParameterInfo all[] = {
            scale_info("vertical modulus at theta = pa without shear, in units of pa = 100 kPa"),
            confinement_info(UsualRange{0.0, 1.0, 0.7, false}),
            distortion_info("its exponent of shear: softens when negative"),
            {"k1_horizontal", 1.0, 0.0, 1e6, true, {}, "the same of the horizontal modulus", {}, lower},
            {"k2_horizontal", 1.0, -5.0, 5.0, false, not_given, "without it that of the vertical modulus", {}},
            {"k3_horizontal", 1.0, -50.0, 50.0, false, not_given, "without it that of the vertical modulus", {}},
            {"k1_shear", 1.0, 0.0, 1e6, true, {}, "the same of the shear modulus G13", {}, lower},
            {"k2_shear", 1.0, -5.0, 5.0, false, not_given, "without it that of the vertical modulus", {}},
            {"k3_shear", 1.0, -50.0, 50.0, false, not_given, "without it that of the vertical modulus", {}},
            {"n_lowest", 1.0, 0.0, 1.0, true, 0.03, "horizontal over vertical modulus is never below this", {}},
            {"n_highest", 1.0, 0.0, 20.0, true, 1.0, "nor above this", {}},
            poisson_12_info(),
            poisson_31_info(),
            tension_smoothing_info(),
            {"shear_floor",
             1.0,
             0.0,
             10.0,
             false,
             not_given,
             "eta, floor of theta in proportion to shear; default 0",
             {}},
        };
        return all;
    }
    bool stress_dependent() const override { return true; }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t scales[] = {vertical, horizontal, shear};
        return scales;
    }

    Modulus modulus(std::span<const double> p, Invariants at) const override {
        const State s(p, at);
        const double e = p[0] * unit::reference_pressure * s.stress.factor(p[1], p[2]);
        if (!(e < modulus_limit)) {
            return {.value = modulus_limit, .limited = true};
        }
        const double d_thp = s.stress.by_thp(e, p[1]);
        return {
            .value = e, .d_theta = d_thp * s.floor.d_theta, .d_tau = s.stress.by_tau(e, p[2]) + d_thp * s.floor.d_tau};
    }
    double modulus_derivative(std::span<const double> p, Invariants at, const Modulus& here,
                              std::size_t i) const override {
        if (here.limited) {
            return 0.0;
        }
        const State s(p, at);
        switch (i) {
        case 0: return here.value / p[0];
        case 1: return here.value * s.stress.confinement;
        case 2: return here.value * s.stress.distortion;
        case delta:
        case eta: return s.stress.by_thp(here.value, p[1]) * s.floor_rate(p, i);
        default: return 0.0;
        }
    }

    bool turns() const override { return true; }
    Stiffness<6> unit_stiffness(std::span<const double> p, Invariants at) const override {
        return Directions(p, at).solid.unit_stiffness();
    }
    Stiffness<6> unit_stiffness_derivative(std::span<const double> p, Invariants at, std::size_t i) const override {
        const Directions d(p, at);
        if (i == poisson_12 || i == poisson_31) {
            return d.solid.unit_stiffness_derivative(i == poisson_12 ? Variable::nu12 : Variable::nu31);
        }
        return by_ratios(d, ratio_rate(p, horizontal, d.state, d.n, i), ratio_rate(p, shear, d.state, d.g, i));
    }
    UnitGradient unit_stiffness_gradient(std::span<const double> p, Invariants at) const override {
        const Directions d(p, at);
        const Floor& floor = d.state.floor;
        return {.d_theta = by_ratios(d, d.n.d_thp * floor.d_theta, d.g.d_thp * floor.d_theta),
                .d_tau = by_ratios(d, d.n.d_tau + d.n.d_thp * floor.d_tau, d.g.d_tau + d.g.d_thp * floor.d_tau)};
    }

    std::string impossible(std::span<const double> p) const override {
        if (!(p[n_lowest] < p[n_highest])) {
            return "n_lowest must be below n_highest";
        }
        // The larger n, the nearer to the limit.
        return CrossAnisotropy{.n = p[n_highest], .nu12 = p[poisson_12], .nu31 = p[poisson_31], .shear_ratio = 1.0}
            .impossible();
    }

private:
    static Stiffness<6> by_ratios(const Directions& d, double n_rate, double g_rate) {
        return n_rate * d.solid.unit_stiffness_derivative(Variable::n) +
               g_rate * d.solid.unit_stiffness_derivative(Variable::shear_ratio);
    }
};

} // namespace

const Law& uzan_separate() {
    static const UzanSeparate law;
    return law;
}

} // namespace pave::material

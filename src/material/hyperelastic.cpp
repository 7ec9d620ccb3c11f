#include "material/hyperelastic.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pave::material {
namespace {

constexpr double pa = unit::reference_pressure;

enum : std::size_t { axis, k1, k, n, poisson_12, poisson_31, shear_ratio, delta };

class Hyperelastic final : public Law, public Energy {
public:
    std::string_view name() const override { return "hyperelastic"; }
    std::string_view summary() const override {
        return "stress-dependent, cross-anisotropic, gives back what it takes: strain = A stress/E, E = k1 pa "
               "(Q/pa^2)^(k/2), Q = stress : A : stress";
    }
    std::span<const ParameterInfo> parameters() const override {
        static const std::vector<ParameterInfo> infos = [] {
            std::vector<ParameterInfo> list{
                modulus_axis_info(),
                scale_info("secant modulus at Q = pa^2, in units of pa = 100 kPa"),
                {"k",
                 1.0,
                 -1.0,
                 0.99,
                 false,
                 {},
                 "exponent of the root of Q: stiffens when positive",
                 {},
                 UsualRange{0.0, 0.8, 0.5, false},
                 StressPower{"sqrt(Q)"}},
            };
            const auto directions = direction_infos({});
            list.insert(list.end(), directions.begin(), directions.end());
            list.push_back({"stress_smoothing_kPa",
                            unit::kPa,
                            0.0,
                            1e3,
                            true,
                            5.0,
                            "delta, of Q + delta^2: keeps the modulus from zero",
                            {}});
            return list;
        }();
        return infos;
    }
    bool stress_dependent() const override { return true; }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t own[] = {k1};
        return own;
    }

    Modulus modulus(std::span<const double> p, mechanics::Invariants at) const override {
        const Triaxial t(unit_stiffness(p, at), at);
        const Secant s = secant(p, t.q);
        const double by_q = s.value * s.hardening / 2.0;
        return {.value = s.value, .d_theta = by_q * t.d_theta, .d_tau = by_q * t.d_tau, .limited = s.limited};
    }
    double modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus&,
                              std::size_t i) const override {
        const Triaxial t(unit_stiffness(p, at), at);
        const Secant s = secant(p, t.q);
        const double q_rate = -t.strain.dot(unit_stiffness_derivative(p, at, i) * t.strain);
        return s.value * s.hardening / 2.0 * q_rate + secant_rate(p, t.q, s, i).value;
    }

    mechanics::Stiffness<6> unit_stiffness(std::span<const double> p, mechanics::Invariants) const override {
        return cross_anisotropy(p[axis], p.subspan(n)).unit_stiffness();
    }
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants,
                                                      std::size_t i) const override {
        if (i < n || i > shear_ratio) {
            return mechanics::Stiffness<6>::Zero();
        }
        return cross_anisotropy(p[axis], p.subspan(n)).unit_stiffness_derivative(direction_variables[i - n]);
    }
    std::string impossible(std::span<const double> p) const override {
        return cross_anisotropy(p[axis], p.subspan(n)).impossible();
    }

    const Energy* energy() const override { return this; }

    Secant secant(std::span<const double> p, double q) const override {
        const double x = q + p[delta] * p[delta];
        const double e = p[k1] * pa * std::exp(p[k] / 2.0 * std::log(x / (pa * pa)));
        if (!(e < modulus_limit)) {
            return {.value = modulus_limit, .hardening = 0.0, .d_hardening = 0.0, .limited = true};
        }
        return {.value = e, .hardening = p[k] / x, .d_hardening = -p[k] / (x * x), .limited = false};
    }
    SecantRate secant_rate(std::span<const double> p, double q, const Secant& here, std::size_t i) const override {
        if (here.limited) {
            return {};
        }
        const double x = q + p[delta] * p[delta];
        switch (i) {
        case k1: return {.value = here.value / p[k1], .hardening = 0.0};
        case k: return {.value = here.value * std::log(x / (pa * pa)) / 2.0, .hardening = 1.0 / x};
        case delta: return {.value = here.value * p[k] * p[delta] / x, .hardening = -2.0 * p[k] * p[delta] / (x * x)};
        default: return {};
        }
    }

    // ln Q = 2 ln E + ln(strain square), solved for ln E by Newton: convex or concave with a slope between 1 - k and 1,
    // from the side where each step falls short.
    double stress_square(std::span<const double> p, double strain_square) const override {
        if (!(strain_square > 0.0)) {
            return 0.0;
        }
        const double log_square = std::log(strain_square);
        const double log_floor = 2.0 * std::log(p[delta]);
        const double log_scale = std::log(p[k1] * pa);
        const double log_pa = std::log(pa);
        // Without the floor, and at it.
        const double far = (log_scale + p[k] * (log_square / 2.0 - log_pa)) / (1.0 - p[k]);
        const double near = log_scale + p[k] * (log_floor / 2.0 - log_pa);
        double log_e = p[k] > 0.0 ? std::max(far, near) : std::min(far, near);
        for (int iteration = 0; iteration < 100; ++iteration) {
            const double log_q = 2.0 * log_e + log_square;
            const double larger = std::max(log_q, log_floor);
            const double log_x = larger + std::log1p(std::exp(std::min(log_q, log_floor) - larger));
            const double mismatch = log_e - (log_scale + p[k] * (log_x / 2.0 - log_pa));
            const double step = mismatch / (1.0 - p[k] * std::exp(log_q - log_x));
            log_e -= step;
            if (std::abs(step) <= 1e-9) { // what is left is of its square
                break;
            }
        }
        const double e = std::min(std::exp(log_e), modulus_limit);
        return e * e * strain_square;
    }

    double complementary(std::span<const double> p, double q) const override {
        const double floor = p[delta] * p[delta];
        const double power = 1.0 - p[k] / 2.0;
        const double scale = pa / (2.0 * p[k1] * power);
        // From the floor, without the limit of the modulus.
        const auto stored = [&](double to) {
            return scale * (std::pow((to + floor) / (pa * pa), power) - std::pow(floor / (pa * pa), power));
        };
        const double limited = 1.0 / (2.0 * modulus_limit); // by Q
        if (p[k] == 0.0) {
            return std::max(1.0 / (2.0 * p[k1] * pa), limited) * q;
        }
        // Where the limit is met: above it, or for negative k below.
        const double corner = std::max(0.0, pa * pa * std::pow(modulus_limit / (p[k1] * pa), 2.0 / p[k]) - floor);
        if (p[k] > 0.0) {
            return q <= corner ? stored(q) : stored(corner) + limited * (q - corner);
        }
        return q <= corner ? limited * q : limited * corner + stored(q) - stored(corner);
    }

private:
    // Triaxial compression with these theta and tau.
    struct Triaxial {
        mechanics::Voigt<6> strain; // A stress
        double q;
        double d_theta, d_tau; // of q
        Triaxial(const mechanics::Stiffness<6>& unit, mechanics::Invariants at) {
            mechanics::Voigt<6> by_theta = mechanics::Voigt<6>::Zero();
            mechanics::Voigt<6> by_tau = mechanics::Voigt<6>::Zero();
            by_theta[0] = by_theta[1] = by_theta[2] = -1.0 / 3.0;
            by_tau[0] = by_tau[1] = 1.0 / std::numbers::sqrt2;
            by_tau[2] = -std::numbers::sqrt2;
            const mechanics::Voigt<6> stress = at.theta * by_theta + at.tau * by_tau;
            strain = unit.inverse() * stress;
            q = stress.dot(strain);
            d_theta = 2.0 * strain.dot(by_theta);
            d_tau = 2.0 * strain.dot(by_tau);
        }
    };
};

} // namespace

const Law& hyperelastic() {
    static const Hyperelastic law;
    return law;
}

} // namespace pave::material

#include "material/lade_nelson.h"

#include "base/units.h"
#include "material/isotropic.h"

#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { m, lambda, poisson, delta };

constexpr double pa = unit::reference_pressure;

class LadeNelson final : public Isotropic {
public:
    LadeNelson() : Isotropic(poisson) {}
    std::string_view name() const override { return "lade-nelson"; }
    std::string_view summary() const override {
        return "stress-dependent, isotropic, conserves energy: E = m pa ((theta^2 + R J2)/pa^2)^lambda";
    }
    std::span<const ParameterInfo> parameters() const override {
        static const ParameterInfo infos[] = {
            {"m",
             1.0,
             0.0,
             1e6,
             true,
             {},
             "modulus at theta = pa without shear, in units of pa = 100 kPa",
             {},
             UsualRange{200, 12000, 1000, true}},
            {"lambda",
             1.0,
             -2.0,
             2.0,
             false,
             {},
             "exponent; half of an exponent of theta",
             {},
             UsualRange{0.0, 0.5, 0.3, false}},
            {"poisson", 1.0, -0.99, 0.49, false, {}, "Poisson's ratio", {}, {}, {}, "poisson_31"},
            {"tension_smoothing_kPa", unit::kPa, 0.0, 1e3, true, 5.0, "delta, keeps the modulus from zero", {}},
        };
        return infos;
    }
    bool stress_dependent() const override { return true; }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t own[] = {m};
        return own;
    }

    Modulus modulus(std::span<const double> p, mechanics::Invariants at) const override {
        const double x = measure(p, at);
        const double e = p[m] * pa * std::exp(p[lambda] * std::log(x));
        if (!(e < modulus_limit)) {
            return {.value = modulus_limit, .d_theta = 0.0, .d_tau = 0.0, .limited = true};
        }
        const double by_x = e * p[lambda] / (x * pa * pa);
        return {
            .value = e, .d_theta = by_x * 2.0 * at.theta, .d_tau = by_x * 3.0 * ratio(p) * at.tau, .limited = false};
    }
    double modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus&,
                              std::size_t i) const override {
        const double x = measure(p, at);
        const double e = p[m] * pa * std::exp(p[lambda] * std::log(x));
        if (!(e < modulus_limit)) {
            return 0.0;
        }
        switch (i) {
        case m: return e / p[m];
        case lambda: return e * std::log(x);
        case poisson: {
            const double ratio_rate = 18.0 / ((1.0 - 2.0 * p[poisson]) * (1.0 - 2.0 * p[poisson]));
            return e * p[lambda] / x * ratio_rate * 1.5 * at.tau * at.tau / (pa * pa);
        }
        default: return e * p[lambda] / x * 2.0 * p[delta] / (pa * pa);
        }
    }

private:
    static double ratio(std::span<const double> p) { return 6.0 * (1.0 + p[poisson]) / (1.0 - 2.0 * p[poisson]); }
    static double measure(std::span<const double> p, mechanics::Invariants at) {
        return (at.theta * at.theta + 1.5 * ratio(p) * at.tau * at.tau + p[delta] * p[delta]) / (pa * pa);
    }
};

} // namespace

const Law& lade_nelson() {
    static const LadeNelson law;
    return law;
}

} // namespace pave::material

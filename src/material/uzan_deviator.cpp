#include "material/uzan_deviator.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { k1, k2, k3, floor };

constexpr double pa = unit::reference_pressure;

class UzanDeviator final : public StressDependent {
public:
    UzanDeviator()
        : StressDependent(
              {
                  scale_info("modulus at theta = deviator = pa, in units of pa = 100 kPa"),
                  confinement_info(UsualRange{0.0, 1.2, 0.7, false}),
                  {"k3",
                   1.0,
                   -5.0,
                   5.0,
                   false,
                   {},
                   "exponent of the deviator stress: softens when negative",
                   {},
                   UsualRange{-0.8, 0.1, -0.2, false},
                   StressPower{"deviator"}},
                  {"deviator_floor_kPa", unit::kPa, 0.0, 1e3, true, 10.0, "what the deviator does not fall below", {}},
              },
              1.0) {}
    std::string_view name() const override { return "uzan-deviator"; }
    std::string_view summary() const override { return "stress-dependent: E = k1 pa (theta/pa)^k2 (deviator/pa)^k3"; }

private:
    static double deviator(std::span<const double> p, double tau) {
        return std::hypot(deviator_over_tau * tau, p[floor]);
    }
    Terms terms(std::span<const double> p, double thp, double tau) const override {
        const double sd = deviator(p, tau);
        const double e = p[k1] * pa * std::exp(p[k2] * std::log(thp / pa) + p[k3] * std::log(sd / pa));
        return {.value = e,
                .d_thp = e * p[k2] / thp,
                .d_tau = e * p[k3] * deviator_over_tau * deviator_over_tau * tau / (sd * sd)};
    }
    double own_derivative(std::span<const double> p, double thp, double tau, double value,
                          std::size_t i) const override {
        const double sd = deviator(p, tau);
        switch (i) {
        case k1: return value / p[k1];
        case k2: return value * std::log(thp / pa);
        case k3: return value * std::log(sd / pa);
        default: return value * p[k3] * p[floor] / (sd * sd);
        }
    }
};

} // namespace

const Law& uzan_deviator() {
    static const UzanDeviator law;
    return law;
}

} // namespace pave::material

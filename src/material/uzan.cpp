#include "material/uzan.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { k1, k2, k3 };

constexpr double pa = unit::reference_pressure;

class Uzan final : public StressDependent {
public:
    Uzan()
        : StressDependent({
              scale_info("modulus at theta = pa without shear, in units of pa = 100 kPa"),
              confinement_info(UsualRange{0.0, 1.0, 0.7, false}),
              {"k3",
               1.0,
               -50.0,
               50.0,
               false,
               {},
               "exponent of shear: softens when negative",
               {},
               UsualRange{-2.0, 0.0, -0.4, false}},
          }) {}
    std::string_view name() const override { return "uzan"; }
    std::string_view summary() const override {
        return "stress-dependent, cross-anisotropic: E = k1 pa (theta/pa)^k2 (tau/pa + 1)^k3";
    }

private:
    Terms terms(std::span<const double> p, double thp, double tau) const override {
        const double e = p[k1] * pa * std::exp(p[k2] * std::log(thp / pa) + p[k3] * std::log1p(tau / pa));
        return {.value = e, .d_thp = e * p[k2] / thp, .d_tau = e * p[k3] / (tau + pa)};
    }
    double own_derivative(std::span<const double> p, double thp, double tau, double value,
                          std::size_t i) const override {
        switch (i) {
        case k1: return value / p[k1];
        case k2: return value * std::log(thp / pa);
        default: return value * std::log1p(tau / pa);
        }
    }
};

} // namespace

const Law& uzan() {
    static const Uzan law;
    return law;
}

} // namespace pave::material

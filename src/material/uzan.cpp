#include "material/uzan.h"

namespace pave::material {
namespace {

enum : std::size_t { k1, k2, k3 };

class Uzan final : public StressDependent {
public:
    Uzan()
        : StressDependent({
              scale_info("modulus at theta = pa without shear, in units of pa = 100 kPa"),
              confinement_info(UsualRange{0.0, 1.0, 0.7, false}),
              distortion_info("exponent of shear: softens when negative"),
          }) {}
    std::string_view name() const override { return "uzan"; }
    std::string_view summary() const override {
        return "stress-dependent, cross-anisotropic: E = k1 pa (theta/pa)^k2 (tau/pa + 1)^k3";
    }

private:
    Terms terms(std::span<const double> p, double thp, double tau) const override {
        const UzanStress s{thp, tau};
        const double e = p[k1] * unit::reference_pressure * s.factor(p[k2], p[k3]);
        return {.value = e, .d_thp = s.by_thp(e, p[k2]), .d_tau = s.by_tau(e, p[k3])};
    }
    double own_derivative(std::span<const double> p, double thp, double tau, double value,
                          std::size_t i) const override {
        const UzanStress s{thp, tau};
        switch (i) {
        case k1: return value / p[k1];
        case k2: return value * s.confinement;
        default: return value * s.distortion;
        }
    }
};

} // namespace

ParameterInfo distortion_info(std::string_view meaning) {
    return {
        "k3", 1.0, -50.0, 50.0, false, {}, meaning, {}, UsualRange{-2.0, 0.0, -0.4, false}, StressPower{"tau", 1.0}};
}

const Law& uzan() {
    static const Uzan law;
    return law;
}

} // namespace pave::material

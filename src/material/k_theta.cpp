#include "material/k_theta.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { k1, k2 };

constexpr double pa = unit::reference_pressure;

class KTheta final : public StressDependent {
public:
    KTheta()
        : StressDependent(
              {
                  scale_info("modulus at theta = pa, in units of pa = 100 kPa"),
                  confinement_info(UsualRange{0.0, 1.0, 0.6, false}),
              },
              1.0) {}
    std::string_view name() const override { return "k-theta"; }
    std::string_view summary() const override { return "stress-dependent: E = k1 pa (theta/pa)^k2"; }

private:
    Terms terms(std::span<const double> p, double thp, double) const override {
        const double e = p[k1] * pa * std::exp(p[k2] * std::log(thp / pa));
        return {.value = e, .d_thp = e * p[k2] / thp, .d_tau = 0.0};
    }
    double own_derivative(std::span<const double> p, double thp, double, double value, std::size_t i) const override {
        return i == k1 ? value / p[k1] : value * std::log(thp / pa);
    }
};

} // namespace

const Law& k_theta() {
    static const KTheta law;
    return law;
}

} // namespace pave::material

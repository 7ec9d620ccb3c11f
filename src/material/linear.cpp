#include "material/linear.h"

#include "base/units.h"
#include "material/isotropic.h"

namespace pave::material {
namespace {

enum : std::size_t { modulus_MPa, poisson };

class Linear final : public Isotropic {
public:
    Linear() : Isotropic(poisson) {}
    std::string_view name() const override { return "linear"; }
    std::string_view summary() const override { return "isotropic linear elasticity"; }
    std::span<const ParameterInfo> parameters() const override {
        static const ParameterInfo infos[] = {
            {"modulus_MPa",
             unit::MPa,
             0.0,
             1e6,
             true,
             {},
             "Young's modulus",
             {},
             UsualRange{20.0, 3000.0, 300.0, true}},
            {"poisson", 1.0, -0.99, 0.4999, false, {}, "Poisson's ratio", {}},
        };
        return infos;
    }
    bool stress_dependent() const override { return false; }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t own[] = {modulus_MPa};
        return own;
    }

    Modulus modulus(std::span<const double> p, mechanics::Invariants) const override {
        return {.value = p[modulus_MPa]};
    }
    double modulus_derivative(std::span<const double>, mechanics::Invariants, const Modulus&,
                              std::size_t i) const override {
        return i == modulus_MPa ? 1.0 : 0.0;
    }
};

} // namespace

const Law& linear() {
    static const Linear law;
    return law;
}

} // namespace pave::material

#include "material/linear.h"

#include "base/units.h"
#include "material/isotropic.h"

namespace pave::material {
namespace {

enum : std::size_t { modulus_MPa, poisson };

class Linear final : public IsotropicLinear {
public:
    Linear() : IsotropicLinear(modulus_MPa, poisson) {}
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
            {"poisson",
             1.0,
             -0.99,
             0.4999,
             false,
             {},
             "Poisson's ratio; 0.4999 where 0.5 is meant",
             {},
             {},
             {},
             "poisson_31"},
        };
        return infos;
    }
};

} // namespace

const Law& linear() {
    static const Linear law;
    return law;
}

} // namespace pave::material

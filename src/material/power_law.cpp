#include "material/power_law.h"

#include "base/units.h"
#include "material/k_theta.h"
#include "material/uzan.h"

namespace pave::material {

std::optional<PowerLaw> power_law(const Law& law, std::span<const double> parameters) {
    if (&law != &uzan() && &law != &k_theta()) {
        return std::nullopt;
    }
    PowerLaw power;
    const auto take = [&](std::string_view key, double& number, int& index) {
        if (const auto at = law.index_of(key)) {
            index = static_cast<int>(*at);
            number = parameters[*at];
        }
    };
    take("k1", power.k1_pa, power.k1_index);
    take("k2", power.k2, power.k2_index);
    take("k3", power.k3, power.k3_index);
    take("tension_smoothing_kPa", power.delta, power.delta_index);
    take("shear_floor", power.eta, power.eta_index);
    power.k1_pa *= unit::reference_pressure;
    return power;
}

} // namespace pave::material

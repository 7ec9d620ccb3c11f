#include "material/catalog.h"

#include "material/bilinear.h"
#include "material/dresden.h"
#include "material/hyperelastic.h"
#include "material/k_theta.h"
#include "material/lade_nelson.h"
#include "material/linear.h"
#include "material/uzan.h"
#include "material/uzan_deviator.h"
#include "material/uzan_separate.h"
#include "material/viscoelastic.h"

namespace pave::material {

std::span<const Law* const> laws() {
    static const Law* const all[] = {
        &linear(),  &uzan(),        &k_theta(),      &uzan_deviator(), &uzan_separate(),
        &dresden(), &lade_nelson(), &hyperelastic(), &bilinear(),      &viscoelastic(),
    };
    return all;
}

const Law* find_law(std::string_view name) {
    for (const Law* law : laws()) {
        if (law->name() == name) {
            return law;
        }
    }
    return nullptr;
}

std::optional<std::size_t> Law::index_of(std::string_view key) const {
    const auto infos = parameters();
    for (std::size_t i = 0; i < infos.size(); ++i) {
        if (infos[i].key == key) {
            return i;
        }
    }
    return std::nullopt;
}

UnitGradient Law::unit_stiffness_gradient(std::span<const double>, mechanics::Invariants) const {
    return {};
}
std::vector<Relaxation> Law::relaxation(std::span<const double>) const {
    return {};
}
std::vector<Relaxation> Law::relaxation_derivative(std::span<const double>, std::size_t) const {
    return {};
}

} // namespace pave::material

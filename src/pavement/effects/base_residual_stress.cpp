// Horizontal compression locked in by compaction, beyond what the study states.
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        c.layers[l].residual_stress += applied.size * unit::kPa;
    }
}

} // namespace

const Effect& base_residual_stress() {
    static const Effect effect{
        .name = "base-residual-stress",
        .unit = "kPa",
        .null = 0.0,
        .low = 0.0,
        .high = 100.0,
        .typical = 20.0,
        .mechanism =
            "Compaction locks in horizontal compression, which confines the base before any load comes. It stiffens "
            "the lower and outer base most, where weight alone gives little stress.",
        .source = "GT-PAVE examples use 21 kPa (3 psi); Selig (1987) on residual stress after compaction",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("{} kPa of horizontal compression are locked into the base", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

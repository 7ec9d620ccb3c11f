// Under a pulse a layer moves with another mass than the study says.
#include "base/text.h"
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        c.layers[l].density *= applied.size;
    }
}

std::string refuses(const Case& c, const AppliedEffect&) {
    return why_not_in_time(c);
}

} // namespace

const Effect& density() {
    static const Effect effect{
        .name = "density",
        .unit = "factor",
        .null = 1.0,
        .low = 0.5,
        .high = 2.0,
        .log_scale = true,
        .typical = 1.3,
        .mechanism =
            "What moves has inertia: with the density of the layer times the size waves travel through it slower, or "
            "faster, and the section answers later and with more of a swing. Wet, organic or lightweight layers have "
            "other densities than a study that guesses. (That of all layers together reads like another load.)",
        .source = "Roesset and Shao (1985) on dynamic FWD interpretation",
        .acts_on = "the subgrade, under loads with a history",
        .layer = LayerRole::subgrade,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string { return "it has a density " + share_words(a.size); },
    };
    return effect;
}

} // namespace pave::pavement

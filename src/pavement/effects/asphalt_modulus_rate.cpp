// The asphalt modulus differs between loads: times the size under some of them.
#include "pavement/effects/effect.h"

namespace pave::pavement {
namespace {

bool is_under(const Case& c, const AppliedEffect& applied, int load) {
    return applied.load ? *applied.load == load : load > 0 || c.loads.size() == 1;
}

void apply(Case& c, const AppliedEffect& applied, int load) {
    if (is_under(c, applied, load)) {
        for (const std::size_t l : layers_named(c, applied.layer)) {
            scale_modulus(c.layers[l], applied.size);
        }
    }
}

} // namespace

const Effect& asphalt_modulus_rate() {
    static const Effect effect{
        .name = "asphalt-modulus-rate",
        .unit = "factor",
        .null = 1.0,
        .low = 0.1,
        .high = 10.0,
        .log_scale = true,
        .typical = 0.5,
        .mechanism =
            "Asphalt is stiffer under a short pulse and in the cold than under a slow wheel and in the heat: under "
            "some loads its modulus is the study's times the size. Responses under the others do not change.",
        .source = "time-temperature superposition; NCHRP 1-37A guide, dynamic modulus of asphalt",
        .acts_on = "the asphalt, under every load after the first (or the only one)",
        .layer = LayerRole::asphalt,
        .takes_load = true,
        .apply = apply,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return "under the loads it acts on the asphalt has " + stiffness_words(a.size);
        },
    };
    return effect;
}

} // namespace pave::pavement

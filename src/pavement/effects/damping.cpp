// Under a pulse a layer damps more, or less, than the study says.
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        c.layers[l].damping_time *= applied.size;
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (std::string why = why_not_in_time(c); !why.empty()) {
        return why;
    }
    return c.layers[layers_named(c, applied.layer).front()].damping_time > 0.0 ? ""
                                                                               : "the layer has no damping_time_ms";
}

} // namespace

const Effect& damping() {
    static const Effect effect{
        .name = "damping",
        .unit = "factor",
        .null = 1.0,
        .low = 0.1,
        .high = 50.0,
        .log_scale = true,
        .typical = 5.0,
        .mechanism =
            "Soil takes energy out of the waves of a falling weight: its stress is E C (strain + damping time x its "
            "rate), with the damping time of the layer times the size. Deflections come later, are spread in time and "
            "return more slowly.",
        .source = "Roesset and Shao (1985) on dynamic FWD interpretation; Kramer (1996), damping of soils",
        .acts_on = "the subgrade, under loads with a history",
        .layer = LayerRole::subgrade,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("it damps {} times as much as stated", figure(a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

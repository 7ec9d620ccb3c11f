// The base carries less tension: the smooth floor of theta is delta exp(-size).
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::pavement {
namespace {

constexpr std::string_view key = "tension_smoothing_kPa";

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        c.layers[l].parameters[*c.layers[l].law->index_of(key)] *= std::exp(-applied.size);
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    return c.layers[layers_named(c, applied.layer).front()].law->index_of(key)
               ? ""
               : "the law of the layer has no floor of theta";
}

} // namespace

const Effect& base_tension() {
    static const Effect effect{
        .name = "base-tension",
        .unit = "-",
        .null = 0.0,
        .low = -1.0,
        .high = 4.0,
        .typical = 1.5,
        .mechanism =
            "Unbound grains carry no tension: where the load unloads the bottom of the base, its modulus drops towards "
            "zero. The smoothing of that floor becomes tension_smoothing_kPa exp(-size).",
        .source = "smooth floor of theta in equation 1; MEPDG appendix RR on tension cut-off",
        .acts_on = "the base",
        .layer = LayerRole::base,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("the base carries {} tension than stated: its smoothing is {} times the stated one",
                               a.size > 0.0 ? "less" : "more", figure(std::exp(-a.size), 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

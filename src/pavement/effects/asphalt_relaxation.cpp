// Under a pulse the asphalt relaxes: a share of its modulus fades within milliseconds.
#include "base/text.h"
#include "base/units.h"
#include "material/catalog.h"
#include "pavement/effects/effect.h"

#include <fmt/format.h>

namespace pave::pavement {
namespace {

constexpr double time_of_relaxation = 10.0 * unit::ms; // a third of a pulse

void apply(Case& c, const AppliedEffect& applied, int) {
    for (const std::size_t l : layers_named(c, applied.layer)) {
        Layer& layer = c.layers[l];
        const double modulus = layer.parameters[*layer.law->index_of("modulus_MPa")];
        const double poisson = layer.parameters[*layer.law->index_of("poisson")];
        layer.law = material::find_law("viscoelastic");
        layer.parameters.clear();
        for (const material::ParameterInfo& info : layer.law->parameters()) {
            layer.parameters.push_back(info.default_value.value_or(0.0) * info.to_si);
        }
        const auto set = [&](std::string_view key, double value) {
            layer.parameters[*layer.law->index_of(key)] = value;
        };
        set("modulus_MPa", modulus);
        set("poisson", poisson);
        set("g1", applied.size);
        set("tau1_s", time_of_relaxation);
    }
}

std::string refuses(const Case& c, const AppliedEffect& applied) {
    if (std::string why = why_not_in_time(c); !why.empty()) {
        return why;
    }
    const bool is_linear = c.layers[layers_named(c, applied.layer).front()].law->name() == "linear";
    return is_linear ? "" : "the layer is not of law = \"linear\"";
}

} // namespace

const Effect& asphalt_relaxation() {
    static const Effect effect{
        .name = "asphalt-relaxation",
        .unit = "-",
        .null = 0.0,
        .low = 0.0,
        .high = 0.95,
        .typical = 0.5,
        .mechanism = "Bitumen flows: within a pulse a share of the asphalt's modulus, the size, fades with a time of "
                     "10 milliseconds. The deflection near the load lags behind the force and returns late.",
        .source = "Kutay, Chatti and Lei (2011) on asphalt from whole FWD pulses; Ferry (1980)",
        .acts_on = "the asphalt, under loads with a history",
        .layer = LayerRole::asphalt,
        .apply = apply,
        .refuses = refuses,
        .in_words = [](const AppliedEffect& a) -> std::string {
            return fmt::format("{} % of its modulus fades within the pulse", figure(100.0 * a.size, 2));
        },
    };
    return effect;
}

} // namespace pave::pavement

#include "analysis/common/stress_steps.h"

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

// Pressure of the load that the readings of a group are under, Pa; nothing: several loads.
std::optional<double> pressure_of(const study::Study& study, const std::string& group) {
    for (const study::Group& g : study.groups) {
        if (g.name != group || g.rows.empty()) {
            continue;
        }
        const std::string& load = study.readings[g.rows[0]].load;
        const bool one =
            std::all_of(g.rows.begin(), g.rows.end(), [&](std::size_t i) { return study.readings[i].load == load; });
        for (const auto& l : study.model.loads) {
            if (one && l.name == load) {
                return l.pressure * l.factor;
            }
        }
    }
    return std::nullopt;
}

struct Level {
    double pressure = 0.0; // Pa
    double unit = 0.0, standard_error = 0.0;
};

// +1: rises from level to level, -1: falls, 0: neither, or by no more than its errors. Sorted by pressure.
int trend(const std::vector<Level>& levels) {
    constexpr std::size_t least = 2;
    constexpr double clear = 2.0; // standard errors
    if (levels.size() < least) {
        return 0;
    }
    const double moved = levels.back().unit - levels.front().unit;
    const double error = std::hypot(levels.back().standard_error, levels.front().standard_error);
    if (!(std::abs(moved) > clear * error)) {
        return 0;
    }
    for (std::size_t i = 1; i < levels.size(); ++i) {
        if ((levels[i].unit - levels[i - 1].unit) * moved <= 0.0) {
            return 0;
        }
    }
    return moved > 0.0 ? 1 : -1;
}

} // namespace

std::vector<std::string> stress_steps(const study::Study& study, const std::vector<WantedAlone>& alone) {
    std::vector<std::string> steps;
    for (std::size_t k = 0; k < study.parameters.size(); ++k) {
        const auto& parameter = study.parameters[k];
        if (!parameter.law_index || study.has_own_model) {
            continue;
        }
        const auto& layer = study.model.layers[static_cast<std::size_t>(parameter.owner)];
        if (layer.law->name() != "linear" || layer.law->index_of("modulus_MPa") != parameter.law_index) {
            continue;
        }
        std::vector<Level> levels;
        for (const WantedAlone& own : alone) {
            const auto pressure = pressure_of(study, own.group);
            if (pressure && std::isfinite(own.standard_error[k]) && !landscape::is_at_bound(own.unit[k])) {
                levels.push_back({*pressure, own.unit[k], own.standard_error[k]});
            }
        }
        std::sort(levels.begin(), levels.end(), [](const auto& a, const auto& b) { return a.pressure < b.pressure; });
        const bool distinct = std::adjacent_find(levels.begin(), levels.end(), [](const auto& a, const auto& b) {
                                  return b.pressure <= a.pressure;
                              }) == levels.end();
        const int way = distinct ? trend(levels) : 0;
        if (way == 0) {
            continue;
        }
        std::vector<std::string> moduli, pressures;
        for (const Level& level : levels) {
            moduli.push_back(pave::figure(study.space.axes[k].physical(level.unit), 3));
            pressures.push_back(fmt::format("{:.0f}", level.pressure / pave::unit::kPa));
        }
        steps.push_back(fmt::format("The {} {} with load ({} MPa at {} kPa): try law = \"{}\" there.", layer.name,
                                    way > 0 ? "stiffens" : "softens", pave::join(moduli), pave::join(pressures),
                                    way > 0 ? "uzan" : "uzan-deviator"));
    }
    return steps;
}

} // namespace explore::analysis

#include "study/candidates.h"

#include "base/units.h"
#include "pavement/effects/effect.h"
#include "pavement/tie.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace explore::study {

namespace unit = pave::unit;
using pave::pavement::Load;
using pave::pavement::LoadType;
using pave::pavement::Quantity;

namespace {

constexpr double raised = 1.5; // pressure of a second drop

std::vector<data::Reading> readings(const Study& study, const Load& load, bool deflections_only) {
    const auto& layers = study.model.layers;
    std::vector<data::Reading> list;
    const auto add = [&](Quantity quantity, double x_mm, double depth_mm, double gauge_mm) {
        const auto& about = info(quantity);
        data::Reading m{.load = load.name,
                        .quantity = std::string(about.name),
                        .x_mm = x_mm,
                        .depth_mm = depth_mm,
                        .gauge_mm = gauge_mm,
                        .unit = data::unit_named(about.unit),
                        .sigma = std::nullopt,
                        .file = study.file};
        const auto own = study.measured();
        const bool taken = std::any_of(own.begin(), own.end(), [&](const data::Reading& old) {
            return old.load == m.load && old.quantity == m.quantity && std::abs(old.x_mm - m.x_mm) < 1.0 &&
                   old.y_mm == 0.0 && std::abs(old.depth_mm - m.depth_mm) < 1.0;
        });
        if (!taken && (study.possible.empty() || study.is_at_hand(quantity))) {
            list.push_back(std::move(m));
        }
    };
    for (const double x : {0.0, 200.0, 300.0, 450.0, 600.0, 900.0, 1200.0, 1500.0, 1800.0}) {
        add(Quantity::deflection, x, 0.0, 0.0);
    }
    if (deflections_only) {
        return list;
    }
    constexpr double gauge = 75.0;
    const double under = 0.5 * load.spacing / unit::mm; // the centre of a tyre
    double top = 0.0;                                   // mm
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const double thickness = layers[l].thickness / unit::mm;
        const bool last = l + 1 == layers.size();
        if (l == 0 && !last) {
            add(Quantity::strain_xx, under, top + thickness - 1.0, 0.0);
        } else if (thickness > gauge) {
            add(Quantity::strain_zz, under, last ? top + 0.5 * gauge : top + 0.5 * thickness, gauge);
        }
        if (last && thickness > gauge) {
            add(Quantity::stress_zz, under, top + 0.5 * gauge, 0.0);
        }
        top += thickness;
    }
    return list;
}

// A parameter of a load, or what follows one, is as unknown of the same load raised.
void tie_raised(Study& extended, const std::string& load, const Load& second) {
    const auto is_sought = [&](const std::string& path) {
        const auto is_it = [&](const auto& item) { return item.path == path; };
        return std::any_of(extended.parameters.begin(), extended.parameters.end(), is_it) ||
               std::any_of(extended.model.ties.begin(), extended.model.ties.end(), is_it);
    };
    for (const pave::pavement::KeyInfo& key : pave::pavement::load_keys(second)) {
        const std::string own = fmt::format("{}.{}", load, key.key);
        if (is_sought(own)) {
            add_tie(extended.model, fmt::format("{}.{}", second.name, key.key),
                    key.key == "pressure_kPa" ? fmt::format("{} * {}", raised, own) : own, {.file = extended.file});
        }
    }
}

} // namespace

Study candidates(const Study& study, const std::vector<std::size_t>& again) {
    Study extended = study;
    extended.data.noise_common_relative = 0.0; // of what is measured; a candidate's errors are candidate_noise()
    extended.data.noise_correlation_length = 0.0;
    extended.data.noise_correlation_time = 0.0;
    extended.data.noise_drift = 0.0;
    extended.data.noise_degrees = 0.0;
    extended.data.noise_scale_is_sought = false;
    extended.constraints.clear(); // of a fit; they may read outputs, which are not here
    std::vector<data::Reading> list;
    for (const Load& load : study.model.loads) {
        auto more = readings(study, load, false);
        std::move(more.begin(), more.end(), std::back_inserter(list));
    }
    for (const Load& load : study.model.loads) {
        if (load.type == LoadType::plate) {
            Load second = load;
            // Names have no full stop.
            second.name = fmt::format("{} at {:.0f} % of the pressure", load.name, 100.0 * raised);
            second.pressure *= raised;
            extended.model.loads.push_back(second);
            tie_raised(extended, load.name, second);
            auto more = readings(study, second, true);
            std::move(more.begin(), more.end(), std::back_inserter(list));
        }
    }
    for (const std::size_t row : again) {
        list.push_back(study.readings[row]);
        list.back().sigma.reset();
    }
    extended = with_measurements(std::move(extended), std::move(list));
    for (pave::pavement::AppliedEffect& applied :
         extended.model.effects) { // another instrument reads what is not yet there
        if (applied.reading || applied.effect->is_error_of_reading || !applied.offsets.empty()) {
            applied.offsets.clear();
            applied.reading = std::numeric_limits<int>::max();
        }
    }
    return extended;
}

double candidate_noise(Quantity quantity, double value) {
    switch (quantity) {
    case Quantity::deflection: return std::hypot(0.02 * value, 2e-6);
    case Quantity::benkelman: return std::hypot(0.05 * value, 20e-6);
    case Quantity::slope:
    case Quantity::strain_zz:
    case Quantity::strain_xx:
    case Quantity::strain_yy: return std::hypot(0.05 * value, 10e-6);
    default: return std::hypot(0.10 * value, 2.0 * unit::kPa);
    }
}

} // namespace explore::study

#include "study/station.h"

#include "base/error.h"
#include "base/units.h"
#include "data/resolution.h"
#include "pavement/effects/effect.h"
#include "study/readings.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::study {

namespace unit = pave::unit;

Study load_survey_study(const std::string& file) {
    Study study = load_study(file, Readings::elsewhere);
    refuse_own_model(study, "a survey");
    auto& loads = study.model.loads;
    const auto is_plate = [](const pave::pavement::Load& load) { return load.type == pave::pavement::LoadType::plate; };
    const auto plates = std::count_if(loads.begin(), loads.end(), is_plate);
    if (plates != 1) {
        throw pave::Error({.file = file, .key = "loads"}, "a survey needs the load of its deflectometer",
                          fmt::format("{} loads of type \"plate\"", plates), "one load of type \"plate\"");
    }
    for (const auto& parameter : study.parameters) {
        if (parameter.in_load) {
            throw pave::Error({.file = file, .key = parameter.path},
                              "the load of a station is measured and cannot be a parameter of a survey", {},
                              "parameters of layers");
        }
    }
    const auto plate = std::find_if(loads.begin(), loads.end(), is_plate);
    for (auto& applied : study.model.effects) {
        if (applied.load && loads.begin() + *applied.load != plate) {
            throw pave::Error({.file = file, .key = std::string(applied.effect->name)},
                              "a survey knows the load of its deflectometer only", "another load", plate->name);
        }
    }
    // The plate first.
    const auto at = static_cast<int>(plate - loads.begin());
    std::rotate(loads.begin(), plate, plate + 1);
    for (auto& sensor : study.model.sensors) {
        sensor.load = sensor.load == at ? 0 : sensor.load < at ? sensor.load + 1 : sensor.load;
    }
    for (auto& applied : study.model.effects) {
        applied.load = applied.load ? std::optional(0) : std::nullopt;
    }
    return study;
}

namespace {

constexpr double sensor_floor_um = 1.0;
constexpr double sensor_share = 0.01;

// With the thicknesses that a station states.
void set_layers(Study& study, const data::FwdStation& station) {
    for (const auto& [layer, stated] : station.layers) {
        const std::string path = layer + ".thickness_mm";
        const pave::Place place{.file = station.file, .line = station.line, .key = path};
        pave::pavement::find_parameter(study.model, path, place).in(study.model) = stated.mm * unit::mm;
        study.hash += fmt::format(" {} {}", path, stated.mm);
        const auto axis = std::find_if(study.space.axes.begin(), study.space.axes.end(),
                                       [&](const auto& a) { return a.name == path; });
        if (axis == study.space.axes.end()) {
            continue;
        }
        if (!(stated.mm >= axis->low && stated.mm <= axis->high)) {
            throw pave::Error(place, "the stated thickness is beyond the study's bounds",
                              fmt::format("{:g}", stated.mm), fmt::format("{:g} to {:g}", axis->low, axis->high));
        }
        const bool is_log = axis->scale == problem::Scale::log;
        const double sd = stated.sd_mm  ? *stated.sd_mm / (is_log ? stated.mm : 1.0)
                          : axis->prior ? axis->prior->sd
                                        : 0.0;
        axis->start = stated.mm;
        axis->prior = problem::Prior{.mean = stated.mm, .sd = sd};
        study.hash += fmt::format(" {}", sd);
    }
    settle_extent(study);
}

std::vector<double> interface_depths(const pave::pavement::Case& model) { // m
    std::vector<double> bottoms;
    for (const auto& layer : model.layers) {
        bottoms.push_back((bottoms.empty() ? 0.0 : bottoms.back()) + layer.thickness);
    }
    return bottoms;
}

// The outputs that conditions read, behind the readings: under the last load. outputs: the study with all of them.
void add_constrained_outputs(Study& study, const Study& outputs) {
    const auto is_read = [&](const std::string& name) {
        return std::any_of(study.constraints.begin(), study.constraints.end(), [&](const Constraint& constraint) {
            const auto& left = constraint.left.reads();
            const auto& right = constraint.right.reads();
            return std::find(left.begin(), left.end(), name) != left.end() ||
                   std::find(right.begin(), right.end(), name) != right.end();
        });
    };
    for (const std::size_t i : outputs.outputs()) {
        if (is_read(outputs.readings[i].output)) {
            study.model.sensors.push_back(outputs.model.sensors[i]);
            study.model.sensors.back().load = static_cast<int>(study.model.loads.size()) - 1;
            study.readings.push_back(outputs.readings[i]);
            study.readings.back().load = study.model.loads.back().name;
            study.hash += fmt::format(" {}", outputs.readings[i].output);
        }
    }
    settle_extent(study);
}

} // namespace

double bowl_sigma_um(const data::BowlReading& reading, double repeatability) {
    const double share = reading.disagrees ? std::max(repeatability, reading.scatter.value_or(0.0)) : repeatability;
    const double repeats = share * reading.deflection_um;
    return std::sqrt(std::pow(repeats, 2) / reading.drops +
                     data::rounding_variance(reading.resolution_um, repeats, reading.drops) +
                     std::pow(sensor_floor_um, 2) + std::pow(sensor_share * reading.deflection_um, 2));
}

Study station_study(const Study& survey, const data::FwdStation& station,
                    const std::vector<const data::DeflectionBowl*>& bowls, std::optional<double> repeatability) {
    Study study = survey;
    set_layers(study, station);
    const auto plate = study.model.loads[0];
    const auto& ties = study.model.ties;
    study.model.settings.shares_paths = std::none_of(ties.begin(), ties.end(), [&](const pave::pavement::Tie& tie) {
        return pave::pavement::find_parameter(study.model, tie.path, {}).in_load;
    });
    study.hash += study.model.settings.shares_paths ? " on one path" : "";
    study.model.loads.clear();
    for (auto& applied : study.model.effects) {
        applied.load.reset(); // every load of the station is its plate's
    }
    const bool noise_is_stated = study.data.states_noise();
    const bool counts_drops = study.data.noise_of_drops > 0 || study.data.noise_shared_relative > 0.0 ||
                              study.data.noise_shared_common_relative > 0.0;
    std::vector<data::Reading> measurements;
    for (const data::DeflectionBowl* bowl : bowls) {
        auto load = plate;
        load.radius = bowl->radius_mm * unit::mm;
        load.pressure = bowl->pressure_kPa * unit::kPa;
        load.name = bowls.size() == 1 ? plate.name : fmt::format("{} {:.0f} kPa", plate.name, bowl->pressure_kPa);
        study.hash += fmt::format(" {} {}", bowl->radius_mm, bowl->pressure_kPa);
        for (const auto& reading : bowl->readings) {
            measurements.push_back({.load = load.name,
                                    .quantity = "deflection",
                                    .x_mm = reading.offset_mm,
                                    .value = reading.deflection_um,
                                    .unit = data::unit_named("um"),
                                    .sigma = noise_is_stated
                                                 ? std::nullopt
                                                 : std::optional(bowl_sigma_um(reading, repeatability.value_or(0.0))),
                                    .drops = counts_drops ? reading.drops : 0,
                                    .file = station.file,
                                    .line = station.line});
        }
        study.model.loads.push_back(std::move(load));
    }
    study = with_measurements(std::move(study), std::move(measurements));
    if (!study.constraints.empty()) {
        add_constrained_outputs(study, station_outputs(survey, station, *bowls.back()));
    }
    return study;
}

Study station_outputs(const Study& survey, const data::FwdStation& station, const data::DeflectionBowl& bowl) {
    Study study = survey;
    set_layers(study, station);
    const auto from = interface_depths(survey.model);
    const auto to = interface_depths(study.model);
    for (auto& sensor : study.model.sensors) {
        std::size_t l = 0;
        while (l + 1 < from.size() && sensor.depth > from[l]) {
            ++l;
        }
        const double above = l == 0 ? 0.0 : from[l - 1];
        const double now_above = l == 0 ? 0.0 : to[l - 1];
        if (const double width = from[l] - above; sensor.depth == from[l]) {
            sensor.depth = to[l];
        } else {
            const double stretch = width > 0.0 ? (to[l] - now_above) / width : 1.0;
            sensor.depth = now_above + stretch * (sensor.depth - above);
        }
    }
    auto& plate = study.model.loads[0];
    plate.radius = bowl.radius_mm * unit::mm;
    plate.pressure = bowl.pressure_kPa * unit::kPa;
    study.hash += fmt::format(" {} {}", bowl.radius_mm, bowl.pressure_kPa);
    return study;
}

} // namespace explore::study

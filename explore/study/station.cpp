#include "study/station.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::study {

namespace unit = pave::unit;

Study load_survey_study(const std::string& file) {
    Study study = load_study(file, Readings::elsewhere);
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
        applied.load.reset();
    }
    loads = {*plate};
    return study;
}

Study station_study(const Study& survey, const data::FwdStation& station, const data::DeflectionBowl& bowl) {
    Study study = survey;
    auto& plate = study.model.loads[0];
    plate.radius = bowl.radius_mm * unit::mm;
    plate.pressure = bowl.pressure_kPa * unit::kPa;
    study.hash += fmt::format(" {} {}", bowl.radius_mm, bowl.pressure_kPa);
    std::vector<data::Reading> measurements;
    for (const auto& reading : bowl.readings) {
        measurements.push_back({.load = plate.name,
                                .quantity = "deflection",
                                .x_mm = reading.offset_mm,
                                .value = reading.deflection_um,
                                .unit = data::unit_named("um"),
                                .sigma = std::nullopt,
                                .file = station.file,
                                .line = station.line});
    }
    return with_measurements(std::move(study), std::move(measurements));
}

} // namespace explore::study

// Candidates for an error that all stations of a road share, and how their residuals change by it.
#pragma once

#include "analysis/road/road_diagnosis.h"
#include "study/variants.h"

namespace explore::analysis {

struct Lack {
    std::optional<study::Variant> variant{}; // at the first station that has it; none: the scale of a sensor
    std::optional<double> offset_mm{};       // of the sensor that it concerns
    int sense = 0;                           // of its sizes: 1 above the null, -1 below, 0 both
    std::vector<Eigen::VectorXd> change;     // of every member's residuals by its size, unit coordinate or share
};

// Effects of the catalogue, places of sensors and their gains, at none of each. Nothing: interrupted.
std::optional<std::vector<Lack>> lacks_of_road(Session& session, const RoadState& state,
                                               const ProblemOfStation& problem_of);

// Effects that all stations of a study's kind can lack alike: on every load, or at the place of a sensor.
std::vector<study::Variant> effects_of_road(const study::Study& study);

// Alike for the same effect at every station.
std::string key_of(const study::Variant& variant, const study::Study& study);

// The task with effects of free size.
StationTask with_effects(const StationTask& task, const std::vector<study::Variant>& variants,
                         const ProblemOfStation& problem_of);

} // namespace explore::analysis

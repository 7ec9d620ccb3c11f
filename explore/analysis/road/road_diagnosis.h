// Diagnosis of a road: an effect of the catalogue, or a sensor, whose size the stations
// share.
#pragma once

#include "analysis/road/road.h"
#include "analysis/road/road_statistics.h"

namespace explore::analysis {

using ProblemOfStation = std::function<problem::Problem(study::Study)>;

// state: a fitted road; dof: of its chi2. Each candidate's size is one unknown of the whole road. Its score is by
// how many standard deviations the residuals want it, beyond what all parameters of stations and road can follow (to
// first order); chance is that the largest score of all candidates is as large. Where it is due to chance in less than
// one case of twenty, those that promise most are fitted with everything else. Nothing: interrupted.
std::optional<RoadDiagnosis> diagnose_road(Session& session, const RoadState& state, double dof,
                                           const ProblemOfStation& problem_of);

} // namespace explore::analysis

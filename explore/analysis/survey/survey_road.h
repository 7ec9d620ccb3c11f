// The stations of a road together: sections that are alike, the influence of the floor.
#pragma once

#include "analysis/survey/survey_stations.h"

namespace explore::analysis {

// The homogeneous sections of each profile and lane, along the road. Stations without a bowl or a chainage belong to
// none.
std::vector<RoadSection> road_sections(const SurveyResult& result);

// The influence of the floor, at the fitted station with the median D0. tasks: of the result. Nothing: none
// is fitted, or the question does not arise (analysis/common/floor.h).
std::optional<SurveyResult::Floor> floor_of(const SurveyResult& result, const std::vector<StationTask>& tasks);

} // namespace explore::analysis

// What the stations of a road say together: sections that are alike, a sensor that errs everywhere.
#pragma once

#include "analysis/survey_stations.h"

namespace explore::analysis {

// The homogeneous sections of each profile and lane, along the road. Stations without a bowl or a chainage belong to
// none.
std::vector<RoadSection> road_sections(const SurveyResult& result);

// Of the sensors between the centre and the last, the one whose residual ln(model / measured), less that of its two
// neighbours interpolated, is largest in the median, if it is beyond 3 % and has one sign at so many stations that
// chance gives that with p < 0.01 over all sensors (sign test). Needs eight fitted stations.
std::optional<SuspectSensor> suspect_sensor(const SurveyResult& result);

// What the floor does to the answer, at the fitted station with the median D0. tasks: of the result. Nothing: none
// is fitted, or the question does not arise (analysis/floor.h).
std::optional<SurveyResult::Floor> floor_of(const SurveyResult& result, const std::vector<StationTask>& tasks);

} // namespace explore::analysis

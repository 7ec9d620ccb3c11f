// Residuals of a road's fits at its sensors: is one sensor wrong, or the section?
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Of every sensor of the fitted stations.
std::vector<SensorResidual> sensor_residuals(const SurveyResult& result);

// Of every level of load, where stations are fitted to several: the highest of a station beside the highest of others.
std::vector<LoadResidual> load_residuals(const SurveyResult& result);

// Of the sensors between the centre and the last, the one whose residual ln(model / measured), less that of its two
// neighbours interpolated, is largest in the median, if it is beyond 3 % and has one sign at so many stations that
// chance gives that with p < 0.01 over all sensors (sign test). Needs eight fitted stations.
std::optional<SuspectSensor> suspect_sensor(const SurveyResult& result);

// Sensors of one sign along the road if this one is left out of every fit (to first order), which then follows the
// others; nothing: too few sensors are left to tell.
std::optional<std::size_t> left_over_without(const SurveyResult& result, double offset_mm);

// Fills residuals, load_residuals, suspect and section_is_suspect. A wrong sensor pulls the fit, so that its neighbours
// err as well: with it left out they do not. Where others still keep one sign, it is the section that is wrong, or
// several sensors are.
void judge_sensors(SurveyResult& result);

} // namespace explore::analysis

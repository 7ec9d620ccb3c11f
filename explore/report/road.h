// A road fitted as one experiment as JSON, as a table and as text.
#pragma once

#include "analysis/road/road.h"
#include "report/json.h"

namespace explore::report {

// The JSON of survey_json() and what is common, the stations against the road, outliers, the conflict.
Json road_json(const analysis::RoadResult& result);

// A line a station: place, section, chi2, parameters by the road and by the station alone.
std::string road_csv(const analysis::RoadResult& result);

// For people: what is common, findings, and the text of a survey.
std::string road_text(const analysis::RoadResult& result);

} // namespace explore::report

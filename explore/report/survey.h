// A survey's result as JSON, as tables for spreadsheets and maps, and as text.
#pragma once

#include "analysis/survey/survey.h"
#include "report/json.h"

namespace explore::report {

// The deflection ratio, and how D250 is read where no sensor stands there.
inline constexpr const char* ratio_words =
    "deflection ratio: D250/D0, the deflection 250 mm from the load centre over the one "
    "at the centre (as cited from the Austroads Guide to Pavement Technology Part 5)";
inline constexpr const char* interpolation_words =
    "interpolated linearly in ln(deflection) between the nearest sensors";

Json survey_json(const analysis::SurveyResult& result);

// A line a station with everything: place, time, temperatures, drops, deflections, indices, parameters, remarks.
std::string survey_csv(const analysis::SurveyResult& result);

// The stations with a position, as points; nothing: none has one.
std::optional<Json> survey_geojson(const analysis::SurveyResult& result);

// For people: counts, definitions, the table of stations, remarks, charts along the road, sections, findings.
std::string survey_text(const analysis::SurveyResult& result);

} // namespace explore::report

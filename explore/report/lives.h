// Life and overlay along a road as JSON, as columns of tables and as text.
#pragma once

#include "analysis/survey/survey.h"
#include "report/json.h"

namespace explore::report {

// Names of the criteria, as the stations have them; empty: no station has lives.
std::vector<std::string> criteria_names(const analysis::SurveyResult& result);

Json lives_json(const analysis::StationLives& lives);
Json section_life_json(const analysis::SurveyResult& result, const analysis::RoadSection& section);

// Of a table with a line a station; nothing without criteria. lives may be none.
std::vector<std::string> life_columns(const analysis::SurveyResult& result);
std::vector<std::string> life_cells(const analysis::SurveyResult& result, const analysis::StationResult& station);
// Of a map.
void add_life_properties(const analysis::StationResult& station, Json& properties);

std::string life_table(const analysis::SurveyResult& result);
std::string section_life_table(const analysis::SurveyResult& result);

} // namespace explore::report

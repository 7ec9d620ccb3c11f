// Condition classes, structural numbers, indices at a reference temperature and the characteristic deflection of a
// surveyed road, as JSON.
#pragma once

#include "analysis/survey/survey.h"
#include "report/json.h"

namespace explore::report {

// Classes of a station with a bowl for each kind of base; null: another plate.
Json condition_json(const analysis::StationResult& station);
// By AASHTO 1993 with the study's layers above the last, the station's own where it states them; null: no study, or
// nothing that tells.
Json structural_json(const analysis::SurveyResult& result, const analysis::StationResult& station);
// Null: no reference temperature, or no temperature of the asphalt.
Json reference_json(const analysis::SurveyResult& result, const analysis::StationResult& station);
// Mean + k s of the normalised D0 of these stations, k = 1.645 (95 % of a normal distribution).
Json characteristic_json(const analysis::SurveyResult& result, const analysis::RoadSection& section);

} // namespace explore::report

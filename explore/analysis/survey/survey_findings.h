// The findings of a survey, in words.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// By its deflection ratio: "pass", "fail", or "" without one.
std::string_view verdict(const StationResult& station);

// Why there is none, of a station with a bowl; "": there is one.
std::string why_no_ratio(const StationResult& station);

// Why a station is not "ok"; "": it is.
std::string reason_of(const StationResult& station);

// Remarks on a station besides its numbers: on its file, its readings, its drops, its fit.
std::vector<std::string> remarks_of(const SurveyResult& result, const StationResult& station);

// On the road as a whole, most important first.
std::vector<std::string> findings_of(const SurveyResult& result);

} // namespace explore::analysis

// Stations that are copies of others.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Stations whose drops have all numbers of another's, as measuring twice does not give: in words; "": none.
std::string copied_stations(const SurveyResult& result);

} // namespace explore::analysis

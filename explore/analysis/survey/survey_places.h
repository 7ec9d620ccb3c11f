// Do the stations lie where the file says? By their chainages alone.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Stations closer together than a loading plate is wide, or places in kilometres beside places in metres: a question;
// "": neither.
std::string doubtful_places(const SurveyResult& result);

} // namespace explore::analysis

// Why stations of a road have no bowl.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// How many there are, the reason of the first, and where most of the road is rejected the fault of the file that they
// all show (sensors exchanged or in reverse order, another unit); "": none is rejected.
std::string rejected_words(const SurveyResult& result);

} // namespace explore::analysis

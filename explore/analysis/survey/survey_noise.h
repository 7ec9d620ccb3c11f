// The noise of the readings, as the fits of all stations show it.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// How many times larger than it is taken the noise is at the median station: the root of the median over the stations
// of chi2 by the median that its degrees of freedom have; 1 where it is no larger, or where chance puts as many
// stations above that median in more than 1 % (sign test). One station has too few readings to tell, a road has many.
double noise_factor(const SurveyResult& result);

// "the stated noise": of what the study states; else of what is taken.
std::string_view noise_words(const SurveyResult& result);
// Empty: it is as large as it is taken.
std::string noise_factor_words(const SurveyResult& result);

} // namespace explore::analysis

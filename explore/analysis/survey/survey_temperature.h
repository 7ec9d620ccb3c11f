// How warm the asphalt was at a station, and its indices and modulus at the temperature that is asked for.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Of a station with a bowl and indices: its asphalt temperature, and with reference_C its indices there.
void take_to_reference(StationResult& s, const SurveyOptions& options, std::optional<double> asphalt_mm);
// After the fits: the modulus of the top layer, where it is a parameter and determined.
void take_moduli_to_reference(SurveyResult& result);

// What was not taken to the reference temperature, or beyond what the curve was made for.
std::vector<std::string> reference_findings(const SurveyResult& result);
std::vector<std::string> reference_remarks(const SurveyResult& result, const StationResult& s);

} // namespace explore::analysis

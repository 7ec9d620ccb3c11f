// How warm the asphalt was at a station, and its indices and modulus at a reference temperature.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Of a station with a bowl and indices: its asphalt temperature, and with reference_C its indices there.
void take_to_reference(StationResult& s, const SurveyOptions& options, std::optional<double> asphalt_mm);
// After the fits: the modulus of the top layer, where it is a parameter and determined.
void take_moduli_to_reference(SurveyResult& result);

// More than any asphalt has at this temperature: 25 GPa up to 20 C, beyond by the curve.
double stiffest_asphalt_MPa(data::TemperatureCurve curve, double celsius);

// In sentences: where nothing could be taken to the reference temperature, and where the curve was not made for it.
std::vector<std::string> reference_findings(const SurveyResult& result);
std::vector<std::string> reference_remarks(const SurveyResult& result, const StationResult& s);

} // namespace explore::analysis

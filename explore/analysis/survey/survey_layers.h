// The layers that the stations of a road state, as the study's.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// Names the thicknesses of the stations as the study does, adds those of a table by chainage (""; none) where a station
// states none, and remarks what was done and what names no layer. Without a study they are not used. Throws pave::Error
// for a table without a study or without a layer of it, and for thicknesses that the study seeks but whose error nobody
// states, or that it takes for common.
void set_layers(SurveyResult& result, const std::string& table);

} // namespace explore::analysis

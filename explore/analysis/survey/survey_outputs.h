// The [[outputs]] of a road's study at the fits of its stations.
#pragma once

#include "analysis/survey/survey_stations.h"

namespace explore::analysis {

// Of every fitted station: one run of the full model with derivatives at the best fit, under the load of the station
// that counts and the study's other loads. False: interrupted; what was computed is in the store. Without outputs
// nothing is computed.
bool predict_outputs(Session& session, SurveyResult& result, const std::vector<StationTask>& tasks);

} // namespace explore::analysis

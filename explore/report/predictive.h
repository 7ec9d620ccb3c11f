// Predicted readings as JSON and text.
#pragma once

#include "analysis/sample/prior_check.h"
#include "report/answer.h"

namespace explore::report {

// [{"load", "quantity", ..., "measured", "unit", "low", "median", "high", "pit", "inside"}], as place_json.
Json predicted_json(const study::Study& study, const std::vector<analysis::PredictedReading>& readings);
// A row a reading.
std::string predicted_table(const study::Study& study, const std::vector<analysis::PredictedReading>& readings);

Json prior_check_json(const analysis::PriorCheck& check, const analysis::RunOptions& run);
Answer prior_check_answer(const analysis::PriorCheck& check, const analysis::RunOptions& run);
std::string prior_check_text(const analysis::PriorCheck& check);

} // namespace explore::report

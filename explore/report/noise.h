// The noise of FWD readings as JSON, as a page, and as it stands in a study.
#pragma once

#include "analysis/survey/noise.h"
#include "report/answer.h"

namespace explore::report {

// The table [data.noise] of a study.
std::string noise_block(const analysis::NoiseResult& result);

Json noise_json(const analysis::NoiseResult& result);
Answer noise_answer(const analysis::NoiseResult& result);
std::string noise_text(const analysis::NoiseResult& result);

} // namespace explore::report

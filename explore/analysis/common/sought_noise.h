// The size of the noise where it is fitted, in words.
#pragma once

#include "problem/noise_scale.h"
#include "study/study.h"

#include <string>

namespace explore::analysis {

// "The noise is 1.4 times what is stated (95 %: 1.1 to 2.2)."
std::string noise_scale_words(const study::Study& study, const problem::NoiseScale& scale);

} // namespace explore::analysis

// The assumptions of a study's model, in sentences.
#pragma once

#include "study/study.h"

#include <string>

namespace explore::report {

// Directions of the materials, interfaces, what the last layer stands on, how the loads act and which effects are
// added.
std::string model_words(const study::Study& study);

} // namespace explore::report

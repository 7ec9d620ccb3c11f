// Rows of measurements that agree in every cell: two readings, or one that was copied?
#pragma once

#include "study/study.h"

#include <string>

namespace explore::analysis {

// The rows that agree, in a sentence; "" if no two do.
std::string repeated_rows_words(const study::Study& study);

} // namespace explore::analysis

// Whether the constraints of a study can be met at all.
#pragma once

#include "study/study.h"

namespace explore::analysis {

// Of the constraints that read no output. Throws pave::Error, naming those that contradict each other or the bounds,
// when searches from many points of the box end with some of them not met.
void refuse_contradictions(const study::Study& study);

} // namespace explore::analysis

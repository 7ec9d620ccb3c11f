// Whether the constraints of a study can be met at all.
#pragma once

#include "study/study.h"

namespace explore::analysis {

// Checks the constraints that use no output. Throws pave::Error, naming those that contradict each other or the
// bounds, when every search from many points of the box ends with a constraint violated.
void refuse_contradictions(const study::Study& study);

} // namespace explore::analysis

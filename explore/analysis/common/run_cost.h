// The cost of a run of a study, estimated before any run is made.
#pragma once

#include "pavement/forward.h"
#include "study/study.h"

namespace explore::analysis {

// The cost of one run on one thread (ForwardModel::cost). Throws pave::Error where runs on so many threads at once need
// more memory than this process may have.
pave::pavement::ForwardModel::Cost affordable_cost(const study::Study& study, int threads);

} // namespace explore::analysis

// The cost of a run of a study, known before the first.
#pragma once

#include "pavement/forward.h"
#include "study/study.h"

namespace explore::analysis {

// Of one run on one thread (ForwardModel::cost). Throws pave::Error where runs on so many threads at once need more
// memory than this process may have.
pave::pavement::ForwardModel::Cost affordable_cost(const study::Study& study, int threads);

} // namespace explore::analysis

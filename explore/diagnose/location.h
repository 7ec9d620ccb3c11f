// Where no effect of the catalogue explains the data: where, in which variable and by how much does the model err?
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

// Adds corrections to the baseline, best evidence first (diagnose/evidence.h), while the next one is due to chance in
// less than one case of twenty, and fits the full model with them after each. The verdict becomes `located` where there
// is one and
// - no effect of the catalogue explains the data, or one that leaves more than noise or is at the end of its range, and
//   the corrections come as near, or
// - two effects are named, and one correction comes as near, or
// - one is named, but a correction finds more beside it and corrections come as near.
// False: interrupted.
bool locate(const DiagnosisTask& task, Diagnosis& diagnosis);

} // namespace explore::diagnose

// Where no effect of the catalogue explains the data: where, in which variable and by how much does the model err?
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

// Adds corrections to the baseline, best evidence first (diagnose/evidence.h), while the next one is due to chance in
// less than one case of twenty, and fits the full model with them after each. Where the diagnosis names nothing that
// leaves noise only and there is a correction, its verdict becomes `located`. False: interrupted.
bool locate(const DiagnosisTask& task, Diagnosis& diagnosis);

} // namespace explore::diagnose

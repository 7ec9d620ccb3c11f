// Where no effect of the catalogue explains the data: where, in which variable and by how much does the model err?
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

// Adds corrections to the baseline, best evidence first (diagnose/evidence.h), while the next one is due to chance in
// less than one case of twenty, and fits the full model with them after each. By AICc, in which each coefficient counts
// as far as the data set it free, the verdict becomes `located` where
// - no effect of the catalogue explains the data, or
// - one does that leaves more than noise, or that was named, and corrections are clearly better and say something else,
//   or
// - one does that is at the end of its range, or it takes two, and corrections, of two effects a single one, are not
//   clearly worse.
// What was named is `ambiguous` where corrections are not clearly worse and say something else, or are clearly better
// and say the same of the same layer in another shape, where a correction finds more beside it, and where it takes two
// effects: one thing that a catalogue lacks may do as much. False: interrupted.
bool locate(const DiagnosisTask& task, Diagnosis& diagnosis);

} // namespace explore::diagnose

// Where no effect of the catalogue explains the data: where, in which variable and by how much does the model err?
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

// Adds corrections to the baseline, best evidence first (diagnose/evidence.h), while the next one is due to chance in
// less than one case of twenty, and fits the full model with them after each; nothing in the location: none, or none
// whose AICc, in which each coefficient counts as far as the data set it free, promises to come below `worth`. False:
// interrupted.
bool find_corrections(const DiagnosisTask& task, const Diagnosis& d, double worth, std::optional<Location>& location);

// p: of every channel, the chance that noise makes as much of a correction beside this model as there is. False:
// interrupted.
bool test_beside(const DiagnosisTask& task, const Diagnosis& d, const Model& base, std::vector<double>& p);

} // namespace explore::diagnose

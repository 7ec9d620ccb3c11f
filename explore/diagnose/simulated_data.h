// How much does an effect gain by chance, where it is not there?
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

struct SimulationSettings {
    int simulations = 40;      // at most: few where they leave no doubt
    double noise_factor = 1.0; // by which the noise would have to be larger for what the best explanation leaves
    int number = 0;            // of the first evaluation that is kept; one each, and one more
};

// Data that the baseline makes, with noise, fitted with and without the single effect that explains most: what it gains
// in them says how much its gain in the measured ones is worth (bartlett, p_evidence). False: interrupted.
bool weigh_evidence(const DiagnosisTask& task, Diagnosis& d, const SimulationSettings& settings);

} // namespace explore::diagnose

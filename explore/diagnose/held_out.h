// Readings that were left out of the fit, predicted by a model with what it lacked and without.
#pragma once

#include "diagnose/diagnosis.h"

namespace explore::diagnose {

// A point of the baseline's sample.
struct Explored {
    std::vector<double> unit;
    Eigen::VectorXd residuals; // on the coarse mesh
};

struct LeftOutTask {
    const DiagnosisTask& task;
    const Diagnosis& d;
    const Judged& extended; // the model that predicts
    const Target& pull;     // what holds its coefficients
    const std::vector<Explored>& explored;
};

// Every fold is left out once and predicted by the baseline and by the extended model, both fitted to the rest from
// points that know nothing of the fold. A reading that an effect declares wrong is nobody's to predict. number: of the
// first evaluation that is kept; 10 a fold. For each of the divisions into folds; nothing where no reading is left to
// predict, or interrupted.
std::vector<std::optional<HeldOut>> predict_left_out(const LeftOutTask& asked,
                                                     const std::vector<std::vector<Fold>>& divisions, int number);

} // namespace explore::diagnose

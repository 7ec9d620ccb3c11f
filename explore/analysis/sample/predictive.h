// Readings as parameter sets predict them, with their noise, beside what was read (Gelman et al. 2013, Bayesian Data
// Analysis, 3rd ed., 6.3).
#pragma once

#include "problem/problem.h"
#include "study/study.h"

namespace explore::analysis {

struct PredictedReading {
    std::size_t row = 0;                        // of the study's readings
    double low = 0.0, median = 0.0, high = 0.0; // SI; low to high: 95 %
    // The probability of a reading below the one that was taken (probability integral transform): over many readings
    // that took no part in the fit it is uniform from 0 to 1 where model and noise are right.
    double below = 0.5;
    bool is_inside() const { return below >= 0.025 && below <= 0.975; }
};

// Parameter sets that predict, and what each counts.
struct Predictions {
    std::vector<std::vector<double>> responses; // SI, of the study's sensors, readings first
    std::vector<double> weight;
};

// Of the readings that the problem compares, in its order. A reading is normal around the response (of Student's noise
// t distributed) with the deviation that is stated for it there, each by itself. Where the size of the noise is fitted,
// it is integrated out given each set. predictions: at least one.
std::vector<PredictedReading> predicted(const problem::Problem& problem, const study::Study& study,
                                        const Predictions& predictions);

} // namespace explore::analysis

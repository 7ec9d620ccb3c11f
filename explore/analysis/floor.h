// Does the answer hang on the floor? The same fit once more, of a section whose last layer goes on for ever.
#pragma once

#include "study/problems.h"

namespace explore::analysis {

struct WithoutFloor {
    double misfit = 0.0;            // of the study's kind
    std::vector<double> parameters; // file units
};

// From a fitted point in unit coordinates. Nothing: the question does not arise (no floor, its depth is free or an
// effect's matter, a load in three dimensions), or there is no answer without it.
std::optional<WithoutFloor> fit_without_floor(const study::Study& study, const std::vector<double>& unit);

// Says by how much parameters would differ, where one does by more than a tenth; else "". fitted: file units.
std::string floor_words(const study::Study& study, const std::vector<double>& fitted, double misfit,
                        const WithoutFloor& without);

} // namespace explore::analysis

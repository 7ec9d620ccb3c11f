// Does the answer hang on the floor? The same fit once more, of a section whose last layer goes on for ever.
#pragma once

#include "landscape/minima.h"
#include "study/problems.h"

namespace explore::analysis {

// The study with a last layer that goes on for ever. Nothing: the question does not arise (no floor, its depth is free
// or an effect's matter, a load in three dimensions).
std::optional<study::Study> without_floor(const study::Study& study);

struct WithoutFloor {
    double misfit = 0.0;            // of the study's kind
    std::vector<double> parameters; // file units
};

// "there is no floor, subgrade goes on for ever ..."
std::string no_floor_words(const study::Study& study);

// For an answer that says of a section without a floor that it stiffens with depth: another section that would read so.
std::string rock_words(const study::Study& study);

// From a fitted point in unit coordinates. Nothing: the question does not arise, or there is no answer without it.
std::optional<WithoutFloor> fit_without_floor(const study::Study& study, const std::vector<double>& unit);

// Says that the readings want the floor, or by how much parameters would differ without it, where one does by more than
// a tenth and by more than its standard error; else "". local: of the fitted minimum.
std::string floor_words(const study::Study& study, const landscape::Minimum& fitted,
                        const landscape::LocalAnalysis& local, const WithoutFloor& without);

} // namespace explore::analysis

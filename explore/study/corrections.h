// Corrections of a study's model: read, offered to `diagnose`, written.
#pragma once

#include "study/study.h"

#include <toml++/toml.h>

namespace explore::study {

// [[corrections]]. Throws pave::Error for what is wrong with it, and for a second one on the same variable of the same
// layer.
void read_correction(const toml::table& table, Study& study);

// Every channel on which the model may be corrected and is not yet, all factors 1. Places: in a layer up to its bottom,
// closer where more is read; of stresses where pavements have them; of readings where they are.
std::vector<pave::pavement::Correction> correction_channels(const Study& study);

// The study with these corrections, each factor a further parameter ("NAME.factor_1", from 1/20 to 20) after the
// study's own.
Study with_free_corrections(Study study, const std::vector<pave::pavement::Correction>& corrections);

// A correction in a study file; strength: the standard deviation of ln(factor) known beforehand, written with
// its parameters; none: factors that stay.
std::string correction_text(const pave::pavement::Correction& correction, std::optional<double> strength,
                            double neighbour_correlation);

} // namespace explore::study

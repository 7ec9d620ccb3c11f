// How much thicker the top layer must be for every criterion to last.
#pragma once

#include "analysis/design/design_life.h"

namespace explore::analysis {

// Thicknesses that are tried [mm].
inline constexpr double thickest_overlay = 400.0;
inline constexpr double thinnest_top = 20.0; // that milling leaves

// The life of every criterion, ln of repetitions, with a top layer thicker by so much [mm], at physical values of the
// parameters, by a run of its own. Empty: no answer.
std::vector<double> lives_with_overlay(const CriticalPlaces& places, const std::vector<Life>& lives,
                                       const std::vector<double>& parameters, double added_mm);

// For each of several demands at one parameter set: the thinnest overlay such that it and all thicker ones that were
// tried last; below 0: that much may be milled off. None where no thickness lasts or there is no answer. required: the
// repetitions that each life must allow, one list for each demand.
std::vector<std::optional<double>> overlays_needed(const CriticalPlaces& places, const std::vector<Life>& lives,
                                                   const std::vector<std::vector<double>>& required,
                                                   const std::vector<double>& parameters);

} // namespace explore::analysis

// Would another section describe the bowls? Tried at a few stations of a road, with linear layers, where it takes no
// time.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

inline constexpr double tried_percent = 5.0;     // median RMS beyond which something else is tried
inline constexpr std::size_t least_stations = 3; // by which a trial is judged
inline constexpr double clearly_better = 0.9;    // of the squared misfit

struct Trial {
    double misfit = 0.0; // weighted
    double rms_percent = 0.0;
};

// A bowl of a station fitted once, from each of these starts, with a study in place of the survey's. Nothing: no
// answer. Throws pave::Error where the study does not suit the bowl.
std::optional<Trial> try_fit(const SurveyResult& result, const study::Study& study, const StationResult& station,
                             const data::DeflectionBowl& bowl, const std::vector<std::vector<double>>& starts);

// The bowl that counts in trials: of the highest level that was fitted.
const data::DeflectionBowl& bowl_to_try(const StationResult& station);
// With a fit, of the layout that most have, over all D0; `most` of them.
std::vector<const StationResult*> stations_to_try(const SurveyResult& result, std::size_t most);

// Where the residuals are the section's, or the median RMS is beyond what sensors err (5 %): the last layer parted 0.5,
// 1 or 2 m below its top (the best of these), a half-space in place of the floor, a floor in place of the half-space;
// the one with the lowest misfit first. Empty: not tried (stress-dependent layers, constraints, effects), or no reason
// to.
std::vector<SectionTrial> section_trials(const SurveyResult& result);

// Where no single sensor explains residuals of one sign along the road: what does.
std::string suspected_instead(const SurveyResult& result);

// The trial that helps, and by how much; "": nothing was tried.
std::string trial_words(const SurveyResult& result);

} // namespace explore::analysis

// A load level that a road is not fitted to but predicts.
#pragma once

#include "analysis/road/road_statistics.h"

namespace explore::analysis {

// The levels of one station near a load, taken out of the fit.
struct WithheldBowls {
    std::size_t station = 0; // its number in the survey
    std::vector<data::DeflectionBowl> bowls;
};

// Takes the levels within a tenth of this load out of all stations; a station without another level is `failed`.
// Throws pave::Error where no station has such a level.
std::vector<WithheldBowls> withhold(SurveyResult& survey, const LoadLevel& level);

// The members' predictions of them. make_problem: of a station's study, in units of noise. Nothing: interrupted.
std::optional<WithheldLevel> predict(const RoadState& state, const SurveyResult& survey,
                                     const std::vector<WithheldBowls>& withheld,
                                     const std::function<problem::Problem(const study::Study&)>& make_problem,
                                     double noise_factor);

} // namespace explore::analysis

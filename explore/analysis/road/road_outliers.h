// Why a station does not belong to its road.
#pragma once

#include "analysis/road/road_statistics.h"

namespace explore::analysis {

// The likely cause of each outlier among the judged: whichever explains its misfit best, by the probability of what
// then remains. One sensor: the misfit without its readings, to first order. A material of its own: the misfit by
// itself. Where neither leaves more than 1 %, parameters of its own that are far from those of the five stations on
// either side (by more than 5 times their median deviation and a third of their median) may tell.
std::vector<RoadOutlier> explain_outliers(const RoadState& state, const std::vector<RoadStation>& judged,
                                          const std::vector<RoadPoint>& alone, double noise_factor);

} // namespace explore::analysis

// What a fitted road says: ranges, stations that do not belong, the conflict between stations and road.
#pragma once

#include "analysis/road.h"
#include "analysis/road_stations.h"

namespace explore::analysis {

inline constexpr double road_familywise = 0.05;

// A road in the middle of being fitted: of every task its point; which tasks the common unknowns are of.
struct RoadState {
    RoadStations& stations;
    const std::vector<StationTask>& tasks;
    const RoadLayout& layout;
    std::vector<RoadPoint> points;
    std::vector<std::size_t> members; // tasks
    RoadEnd end;                      // of the members

    optimise::ArrowCovariance covariance() const {
        return optimise::arrow_covariance(end.blocks, end.search.normal);
    }
};

// chi2, dof and p of every task, and the factor by which the median station misses more than the noise (at least 1).
// A station that is no member is judged by what the members predict of the common unknowns.
double judge(const RoadState& state, std::vector<RoadStation>& judged);

// Ranges of common and station parameters, and everything else that is said of the fit. judged: one a task, with its
// point by itself.
void conclude(const RoadState& state, const std::vector<RoadStation>& judged, const std::vector<RoadPoint>& alone,
              RoadResult& result);

} // namespace explore::analysis

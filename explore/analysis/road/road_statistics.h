// Statistics of a fitted road: ranges, stations that do not belong, the conflict between stations and road.
#pragma once

#include "analysis/road/road.h"
#include "analysis/road/road_stations.h"

namespace explore::analysis {

// A road in the middle of being fitted: of every task its point; which tasks the common unknowns are of.
struct RoadState {
    RoadStations& stations;
    const std::vector<StationTask>& tasks;
    const RoadLayout& layout;
    std::vector<RoadPoint> points;
    std::vector<std::size_t> members; // tasks
    RoadEnd end;                      // of the members
};

// The unknowns of a station, its own eliminated. Unit coordinates; residuals in units of their noise.
struct StationInformation {
    StationInformation(const RoadState& state, std::size_t i); // of task i at its point

    std::vector<Eigen::Index> own, shared, to; // axes, axes, and which of the common unknowns the latter are
    Eigen::MatrixXd normal;                    // of all axes
    Eigen::MatrixXd alone;                     // covariance of its own for fixed common ones
    Eigen::MatrixXd following;                 // how they follow those: own x shared
    Eigen::MatrixXd schur;                     // its information on the common ones
    Eigen::VectorXd pull;                      // and its gradient by them

    // Of all axes, for a covariance of all common unknowns.
    Eigen::MatrixXd covariance(const Eigen::MatrixXd& common) const;
};

// The covariance of the common unknowns as the members give it; of those that no member has, all but infinite.
Eigen::MatrixXd common_covariance(const RoadState& state);

// The covariance of unknowns of which something is known beforehand, once readings with this information on them are
// added: (C^-1 + I)^-1 = (1 + C I)^-1 C, without inverting C, which may be as small or as nearly singular as it likes.
Eigen::MatrixXd informed(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& information);

// Corrects p values of a family of tests: p times the number of those not smaller, never falling (Holm 1979).
void holm(const std::vector<double*>& p);

// chi2, dof and p of every task, and the factor by which the median station misses more than the noise (at least 1).
// A station that is no member is judged by what the members predict of the common unknowns.
double judge(const RoadState& state, std::vector<RoadStation>& judged);

// Ranges of common and station parameters, and everything else that is said of the fit. judged: one a task, with its
// point by itself.
void conclude(const RoadState& state, const std::vector<RoadStation>& judged, const std::vector<RoadPoint>& alone,
              RoadResult& result);

} // namespace explore::analysis

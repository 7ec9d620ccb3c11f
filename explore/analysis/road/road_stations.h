// The stations of a road as the blocks of one least-squares problem: what they answer, in parallel and kept.
#pragma once

#include "analysis/survey/survey_stations.h"
#include "optimise/arrow_gauss_newton.h"

#include <atomic>

namespace explore::analysis {

// An unknown of several stations.
struct CommonUnknown {
    std::size_t axis = 0;
    std::optional<std::size_t> section{}; // of the survey's, whose own it is; nothing: the road's
};

// Which unknowns are whose.
struct RoadLayout {
    std::vector<CommonUnknown> common;
    std::vector<optimise::ArrowBlock> blocks; // of every task, over the study's axes

    std::vector<std::size_t> own_axes(std::size_t i) const; // of task i
};

// A station somewhere in its box.
struct RoadPoint {
    std::vector<double> unit;
    problem::Evaluation evaluation; // with jacobian
};

// Where a search over several stations ended.
struct RoadEnd {
    optimise::ArrowResult search;
    std::vector<optimise::ArrowBlock> blocks; // of search: the stations, then one of the priors of common unknowns
};

// The numbers that a station's evaluations are kept under (run::RunNumber::start), one a search; those below are of
// search_batch. A search over several stations takes one every round.
namespace kept_as {
inline constexpr int alone = 90;
inline constexpr int own = 100;
inline constexpr int together = 1000;
} // namespace kept_as

// Everything that is computed at the stations. Nothing that it returns depends on the number of threads.
class RoadStations {
public:
    // runs: of the store, one a task. All must outlive this.
    RoadStations(Session& session, const std::vector<StationTask>& tasks, const std::vector<int>& runs,
                 const RoadLayout& layout);

    // Calls body(i) for every i < count in parallel. False: interrupted.
    bool for_each(std::size_t count, const std::function<void(std::size_t)>& body);

    // Searches station i over these of its axes, the others held; without any it is evaluated. Nothing: interrupted. A
    // point whose evaluation is not converged: `from` has no answer.
    std::optional<RoadPoint> search(std::size_t i, const std::vector<double>& from,
                                    const std::vector<std::size_t>& axes, int number);

    // All of these stations at once. points: of every station; those of `which` are where the search begins and then
    // where it ended. Nothing: interrupted.
    std::optional<RoadEnd> search_together(const std::vector<std::size_t>& which, std::vector<RoadPoint>& points,
                                           int number);

    // d(rows)/d(unit coordinates) transposed times itself, and times the rows.
    Eigen::MatrixXd normal(std::size_t i, const RoadPoint& point) const;
    Eigen::VectorXd gradient(std::size_t i, const RoadPoint& point) const;

    std::int64_t computed() const { return computed_; } // by this process

private:
    std::optional<problem::Evaluation> evaluate(std::size_t i, std::span<const double> unit, int number);

    Session& session_;
    const std::vector<StationTask>& tasks_;
    const std::vector<int>& runs_;
    const RoadLayout& layout_;
    std::atomic<std::int64_t> computed_{0};
};

} // namespace explore::analysis

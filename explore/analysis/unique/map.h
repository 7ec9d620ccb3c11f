// The misfit landscape over a grid or a space-filling design.
#pragma once

#include "analysis/common/session.h"
#include "landscape/adaptive_map.h"

namespace explore::analysis {

// Points of a sample when nothing else is requested.
inline constexpr int map_points = 1024;
// At so many of the lowest points what only outputs need is computed too.
inline constexpr int map_lowest = 10;

enum class MapDesign { automatic, grid, sobol, adaptive };

struct MapOptions {
    ModelOptions model{};
    MapDesign design = MapDesign::automatic; // grid when every parameter states its points, else sobol
    int points = 0;                          // grid: an axis; others: in all
};

struct MapResult {
    struct Low {
        std::size_t number = 0;         // of the point
        problem::Evaluation evaluation; // by the full model where that confirms; every response but by the reduced one
    };
    study::Study study;
    MapOptions options;
    search::Design design;
    bool is_grid = false; // of a value of every axis with every other
    std::vector<problem::Evaluation> evaluations;
    std::vector<Low> lowest;                     // by misfit; empty: not one point has an answer
    std::optional<landscape::Explored> explored; // of an adaptive map
    std::optional<ReducedProblem> reduced;
    run::Tally tally;

    bool failed() const { return lowest.empty(); }
    std::string reason() const {
        return "not one point of the map has an answer; the first says: " + evaluations.front().reason;
    }
};

// Whether some load is only requested, or held out: a map explores without it.
bool has_more_to_predict(const study::Study& study);

// The lowest point in a sentence; none: the map failed.
std::vector<std::string> findings(const MapResult& result);

// Throws pave::Error for a grid without points or with too many. Nothing: interrupted.
std::optional<MapResult> map(Session& session, const study::Study& study, const MapOptions& options);

} // namespace explore::analysis

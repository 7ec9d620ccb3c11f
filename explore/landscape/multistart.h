// The main job: explore, refine the best distinct starts, group the ends into minima.
#pragma once

#include "landscape/minima.h"

namespace explore::landscape {

struct MultistartSettings {
    int starts = 12;
    double start_distance = 0.25; // between starts, Euclid in the unit cube
    std::string method = "gauss-newton";
    optimise::SearchSettings search{};
    int first_kept = 0; // the search from point i of the design is kept as start first_kept + i
};

struct MultistartResult {
    std::vector<problem::Evaluation> explored;
    std::vector<run::Endpoint> ends;
    std::vector<Minimum> minima; // best first; empty: not one point has an answer
};

// Of all the searches together.
int search_evaluations(const std::vector<run::Endpoint>& ends);

// Nothing: interrupted.
std::optional<MultistartResult> multistart(run::Engine& engine, const problem::Problem& problem,
                                           const search::Design& design, const MultistartSettings& settings);

// The same from points that are explored already: their misfit is that of `problem`. also: further starts.
std::optional<MultistartResult> refine(run::Engine& engine, const problem::Problem& problem,
                                       const search::Design& design, std::vector<problem::Evaluation> explored,
                                       const std::vector<std::vector<double>>& also,
                                       const MultistartSettings& settings);

} // namespace explore::landscape

// A map that puts its points where the landscape bends, and says how much of the box it knows.
#pragma once

#include "run/engine.h"

namespace explore::landscape {

// How well the misfit at a point drawn at random from the box is predicted from the points of a map.
struct Explored {
    std::size_t checks = 0;    // points that were drawn, uniform and independent
    std::size_t predicted = 0; // of them: the misfit within `tolerance` of itself, or rightly no answer
    double low = 0.0;          // share of the box that is predicted: 95 % interval (Clopper and Pearson 1934)
    double high = 1.0;
    double median_error = 0.0; // of the misfit, relative
    static constexpr double tolerance = 0.1;
};

// The misfit at each of some points of the unit cube from what was evaluated elsewhere: a plane through the logarithms
// at the nearest of those, by least squares. Not a number: the nearest has no answer, nor will this one.
std::vector<double> predict(const std::vector<std::vector<double>>& at, const std::vector<std::vector<double>>& points,
                            const std::vector<problem::Evaluation>& evaluations, int threads);
// Whether that is within Explored::tolerance of what was then evaluated, or rightly no answer.
bool is_predicted(double predicted, const problem::Evaluation& evaluation);

struct AdaptiveMap {
    search::Design design;
    std::vector<problem::Evaluation> evaluations;
    Explored explored; // by all but the checks, which are the last points of the map
};

inline constexpr int least_adaptive = 50;
// The name of its design.
std::string adaptive_name(int points, std::uint64_t seed);

// The first quarter is a Sobol sequence. Then, round by round: every point is left out in turn and its misfit predicted
// from the others; the next points lie where that errs most, where there is room, and where the misfit is predicted to
// be low (as LOLA-Voronoi designs, Crombecq et al. 2011, doi 10.1016/j.ejor.2011.05.032, with this error in place of
// theirs and with a preference for the bottom). The last tenth is uniform and random and tells what the map before it
// is worth. The map is fixed by the problem, the number of points (at least `least_adaptive`) and the seed. Nothing:
// interrupted.
std::optional<AdaptiveMap> adaptive_map(run::Engine& engine, const problem::Problem& problem, int points,
                                        std::uint64_t seed, int threads);

} // namespace explore::landscape

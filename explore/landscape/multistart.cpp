#include "landscape/multistart.h"

#include <numeric>

namespace explore::landscape {

int search_evaluations(const std::vector<run::Endpoint>& ends) {
    return std::accumulate(ends.begin(), ends.end(), 0,
                           [](int sum, const run::Endpoint& end) { return sum + end.search.evaluations; });
}

std::optional<MultistartResult> multistart(run::Engine& engine, const problem::Problem& problem,
                                           const search::Design& design, const MultistartSettings& settings) {
    auto explored = engine.evaluate(design);
    if (!explored) {
        return std::nullopt;
    }
    return refine(engine, problem, design, std::move(*explored), {}, settings);
}

std::optional<MultistartResult> refine(run::Engine& engine, const problem::Problem& problem,
                                       const search::Design& design, std::vector<problem::Evaluation> explored,
                                       const std::vector<std::vector<double>>& also,
                                       const MultistartSettings& settings) {
    // By the point that it starts from: more points or starts continue a run.
    constexpr int first_of_also = 100'000'000;
    std::vector<std::vector<double>> starts;
    std::vector<int> kept_as;
    for (const std::size_t i : run::distinct_starts(design, explored, settings.starts, settings.start_distance)) {
        kept_as.push_back(settings.first_kept + static_cast<int>(i));
        starts.push_back(design.points[i]);
    }
    for (const auto& start : also) {
        kept_as.push_back(first_of_also + static_cast<int>(&start - also.data()));
        starts.push_back(start);
    }
    auto ends = engine.search(starts, *optimise::find_method(settings.method), settings.search, 0, kept_as);
    if (!ends) {
        return std::nullopt;
    }
    auto minima = distinct_minima(*ends, problem);
    return MultistartResult{std::move(explored), std::move(*ends), std::move(minima)};
}

} // namespace explore::landscape

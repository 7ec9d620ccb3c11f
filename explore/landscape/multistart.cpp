#include "landscape/multistart.h"

namespace explore::landscape {

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
    std::vector<std::vector<double>> starts;
    for (const std::size_t i : run::distinct_starts(design, explored, settings.starts, settings.start_distance)) {
        starts.push_back(design.points[i]);
    }
    starts.insert(starts.end(), also.begin(), also.end());
    auto ends = engine.search(starts, *optimise::find_method(settings.method), settings.search);
    if (!ends) {
        return std::nullopt;
    }
    auto minima = distinct_minima(*ends, problem);
    return MultistartResult{std::move(explored), std::move(*ends), std::move(minima)};
}

} // namespace explore::landscape

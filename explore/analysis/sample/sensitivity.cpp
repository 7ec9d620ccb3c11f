#include "analysis/sample/sensitivity.h"

#include "base/error.h"
#include "study/problems.h"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

namespace explore::analysis {
namespace {

// Takes the parameters that were not requested out of the study: they stay at its own values.
void choose_parameters(study::Study& study, const std::vector<std::string>& wanted) {
    std::vector<std::string> names;
    for (const auto& axis : study.space.axes) {
        names.push_back(axis.name);
    }
    for (const std::string& name : wanted) {
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            const std::string near = pave::nearest_name(name, names);
            throw pave::Error({.file = study.file, .key = "--parameter"},
                              "this is not a parameter of the study" +
                                  (near.empty() ? "" : ", did you mean \"" + near + "\"?"),
                              "\"" + name + "\"", pave::join(names));
        }
    }
    for (std::size_t k = names.size(); k-- > 0;) {
        if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), names[k]) == wanted.end()) {
            study.parameters.erase(study.parameters.begin() + static_cast<std::ptrdiff_t>(k));
            study.space.axes.erase(study.space.axes.begin() + static_cast<std::ptrdiff_t>(k));
        }
    }
}

// The parameter space of the curves: around each own value, whatever the bounds of the study are.
problem::ParameterSpace space_around(const problem::ParameterSpace& space, double range) {
    problem::ParameterSpace around = space;
    for (auto& axis : around.axes) {
        const double change = axis.start * range / 100.0;
        axis.low = axis.start - change;
        axis.high = axis.start + change;
        axis.scale = problem::Scale::linear;
    }
    return around;
}

} // namespace

std::optional<SensitivityResult> sensitivity(Session& session, study::Study study, const SensitivityOptions& options) {
    choose_parameters(study, options.parameters);
    const problem::Problem problem = study::make_prediction_problem(study);
    const int dimension = problem.space.dimension();
    if (options.samples > 0 && dimension > search::most_radial_dimensions) {
        throw pave::Error(
            {.file = study.file, .key = "parameters"}, "too many parameters for global indices",
            fmt::format("{}", dimension),
            fmt::format("at most {}: choose some (--parameter), or --samples 0", search::most_radial_dimensions));
    }
    std::vector<std::string> names;
    std::vector<std::size_t> curved; // a parameter of zero has no percentage
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        names.push_back(problem.space.axes[k].name);
        if (problem.space.axes[k].start != 0.0) {
            curved.push_back(k);
        }
    }
    SensitivityResult s{.study = study, .options = options, .responses = study.outputs()};
    if (s.responses.empty()) {
        s.responses.resize(study.readings.size());
        std::iota(s.responses.begin(), s.responses.end(), std::size_t{0});
    }

    problem::Problem around = problem;
    around.space = space_around(problem.space, options.range);
    const auto curves_design = search::one_at_a_time(dimension, curved, options.points);
    {
        auto engine =
            session.engine(around, session.begin(study, "sensitivity-curves",
                                                 fmt::format("{} over +-{:g} % of {}", curves_design.run_name(),
                                                             options.range, pave::join(names))));
        s.own = engine.evaluate_one(std::vector<double>(names.size(), 0.5));
        if (s.failed()) {
            return s;
        }
        const auto evaluations = engine.evaluate(curves_design);
        if (!evaluations) {
            return std::nullopt;
        }
        for (std::size_t c = 0; c < curved.size(); ++c) {
            const auto first = evaluations->begin() + static_cast<std::ptrdiff_t>(c) * options.points;
            s.curves.push_back({curved[c], {first, first + options.points}});
        }
        s.tally = engine.tally();
    }
    for (int p = 0; p < options.points; ++p) {
        s.changes.push_back(options.range * (2.0 * p / (options.points - 1) - 1.0));
    }
    s.elasticity = landscape::elasticities(s.own);
    if (options.samples > 0) {
        const auto design = search::radial(dimension, options.samples, session.options().seed);
        auto engine =
            session.engine(problem, session.begin(study, "sensitivity",
                                                  fmt::format("{} of {}", design.run_name(), pave::join(names))));
        auto evaluations = engine.evaluate(design);
        if (!evaluations) {
            return std::nullopt;
        }
        s.sample = std::move(*evaluations);
        s.global = landscape::sobol_indices(s.sample, names.size(), s.responses, session.options().seed);
        s.tally.computed += engine.tally().computed;
        s.tally.kept += engine.tally().kept;
        s.tally.seconds += engine.tally().seconds;
    }
    return s;
}

} // namespace explore::analysis

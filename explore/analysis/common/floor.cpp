#include "analysis/common/floor.h"

#include "base/error.h"
#include "base/text.h"
#include "inference/quantiles.h"
#include "optimise/gauss_newton.h"
#include "pavement/effects/effect.h"
#include "run/least_squares.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace explore::analysis {

std::optional<study::Study> without_floor(const study::Study& study) {
    const auto is_of_the_floor = [&](const pave::pavement::Parameter& parameter) {
        return parameter.changes_geometry() && !parameter.in_load && !parameter.in_effect && !parameter.in_correction &&
               parameter.owner + 1 == static_cast<int>(study.model.layers.size());
    };
    const auto is_plane = [](const pave::pavement::Load& load) { return load.is_axisymmetric(); };
    const auto moves_floor = [](const pave::pavement::AppliedEffect& applied) {
        return applied.effect->name == "floor-depth";
    };
    if (study.has_own_model || study.model.half_space ||
        std::any_of(study.parameters.begin(), study.parameters.end(), is_of_the_floor) ||
        std::any_of(study.model.effects.begin(), study.model.effects.end(), moves_floor) ||
        !std::all_of(study.model.loads.begin(), study.model.loads.end(), is_plane)) {
        return std::nullopt;
    }
    study::Study endless = study;
    endless.model.half_space = true;
    return endless;
}

std::string no_floor_words(const study::Study& study) {
    return fmt::format("there is no floor, {} goes on for ever (bottom = \"half-space\" under [section])",
                       study.model.layers.back().name);
}

std::string rock_words(const study::Study& study) {
    return fmt::format("In this study the last layer goes on for ever; rock or anything stiff below looks alike: "
                       "bottom = \"rigid\" under [section], with {}.thickness_mm as a parameter, tells whether that "
                       "fits better (give the layer a thickness_mm to begin with).",
                       study.model.layers.back().name);
}

std::optional<WithoutFloor> fit_without_floor(const study::Study& study, const std::vector<double>& unit) {
    std::optional<study::Study> endless = without_floor(study);
    if (!endless) {
        return std::nullopt;
    }
    endless->model.settings.layered = true;
    WithoutFloor best{.misfit = std::numeric_limits<double>::infinity(), .parameters = {}};
    try {
        const problem::Problem problem = study::make_problem(*endless, study::Scope::fitted);
        const auto workspace = problem.function->make_workspace();
        optimise::SearchSettings settings;
        settings.max_evaluations = 25;
        optimise::gauss_newton(
            unit,
            [&](std::span<const double> point, optimise::Sample& sample) {
                const auto e = problem.evaluate(point, true, *workspace);
                if (!e.converged()) {
                    return optimise::Answer::no_answer;
                }
                sample = run::sample_of(problem, e);
                if (e.misfit < best.misfit) {
                    best = {e.misfit, e.parameters};
                }
                return optimise::Answer::computed;
            },
            settings);
    } catch (const pave::Error&) { // a section of this kind cannot be without a floor
        return std::nullopt;
    }
    return best.parameters.empty() ? std::nullopt : std::optional(std::move(best));
}

std::string floor_words(const study::Study& study, const landscape::Minimum& minimum,
                        const landscape::LocalAnalysis& local, const WithoutFloor& without) {
    const problem::Evaluation& fitted = minimum.evaluation;
    const auto stands = [&] {
        double depth = 0.0;
        for (const auto& layer : study.model.layers) {
            depth += layer.thickness;
        }
        return pave::figure(depth);
    };
    const double rise = std::pow(without.misfit, 2) - std::pow(fitted.misfit, 2);
    if (constexpr double accepted = inference::chi2_95;
        rise > accepted * local.noise * local.noise && local.noise > 0.0) { // chi2 of one degree, 95 %
        return fmt::format("Without the floor at {} m the model fits worse (misfit {} instead of {}): something stiff "
                           "there is likely.",
                           stands(), pave::figure(without.misfit), pave::figure(fitted.misfit));
    }
    constexpr double clear = 0.1;
    std::vector<std::string> changes;
    for (std::size_t k = 0; k < without.parameters.size(); ++k) {
        const double moved = std::abs(study.space.axes[k].unit(without.parameters[k]) - minimum.unit[k]);
        if (std::abs(without.parameters[k] - fitted.parameters[k]) > clear * std::abs(fitted.parameters[k]) &&
            (moved > local.standard_error[k] || !(local.noise > 0.0))) {
            changes.push_back(fmt::format("{} {} instead of {}", study.space.axes[k].name,
                                          pave::figure(without.parameters[k]), pave::figure(fitted.parameters[k])));
        }
    }
    if (changes.empty()) {
        return "";
    }
    return fmt::format(
        "The answer hangs on the floor at {} m. If the last layer went on for ever: {}, misfit {} instead of {}. Where "
        "the "
        "depth of something stiff is not known, bottom = \"half-space\" under [section] leaves it out, and "
        "{}.thickness_mm as a parameter looks for it.",
        stands(), pave::join(changes), pave::figure(without.misfit), pave::figure(fitted.misfit),
        study.model.layers.back().name);
}

} // namespace explore::analysis

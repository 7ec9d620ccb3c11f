#include "study/problems.h"

#include "base/error.h"
#include "study/constraints.h"
#include "study/own_effects.h"
#include "study/pavement_function.h"
#include "study/readings.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace explore::study {
namespace {

problem::Misfit misfit_of(const Study& study, const std::vector<std::size_t>& rows, const std::vector<double>& factor) {
    std::vector<problem::Misfit::Term> terms;
    const auto largest = largest_of_group(study);
    const bool stated = study.noise != NoiseSource::estimated;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const std::size_t i = rows[k];
        const auto& m = study.readings[i];
        problem::Misfit::Term term{.response = i,
                                   .measured = m.measured(),
                                   .factor = factor[k],
                                   .noise = m.noise,
                                   .place = noise_place(study.model.sensors[i]),
                                   .censored = m.censored};
        switch (study.data.misfit) {
        case problem::MisfitKind::log: term.scale = study.data.log_floor * largest[i]; break;
        case problem::MisfitKind::relative: term.scale = std::abs(term.measured); break;
        case problem::MisfitKind::weighted:
            term.scale = stated ? m.noise.deviation(term.measured) : std::abs(term.measured);
            break;
        case problem::MisfitKind::noise: break; // of no study
        }
        if (!(term.scale > 0.0)) {
            throw pave::Error(
                {.file = m.file, .line = m.line, .key = "value"}, "a reading of zero has no place in this misfit",
                fmt::format("{}", m.value),
                "another value, a sigma with misfit = \"weighted\", or a group with some reading that is not zero");
        }
        terms.push_back(term);
    }
    // Weighed by noise that depends on the value: by its own scale.
    const bool by_noise = study.data.misfit == problem::MisfitKind::weighted && stated;
    return {by_noise ? problem::MisfitKind::noise : study.data.misfit, std::move(terms)};
}

// Each reading with weight 1.
problem::Misfit misfit_of(const Study& study, const std::vector<std::size_t>& rows) {
    return misfit_of(study, rows, std::vector<double>(rows.size(), 1.0));
}

std::vector<bool> with_constrained(std::vector<bool> loads, const Study& study) {
    const std::vector<bool> constrained = constrained_loads(study);
    std::transform(loads.begin(), loads.end(), constrained.begin(), loads.begin(), std::logical_or<>());
    return loads;
}

problem::Problem problem_of(const Study& study, const std::vector<bool>& loads, problem::Misfit misfit) {
    if (study.parameters.empty()) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "this command needs parameters to change", {},
                          "at least one [[parameters]]");
    }
    if (study.space.axes.size() > most_parameters) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "too many parameters",
                          fmt::format("{}", study.space.dimension()), fmt::format("at most {}", most_parameters));
    }
    const std::vector<bool> needed = loads.empty() ? loads : with_constrained(loads, study); // empty: all
    problem::Problem problem(study.space, function_of(study, study.parameters, needed), std::move(misfit));
    problem.limits = limits_of(study);
    return problem;
}

} // namespace

std::shared_ptr<const problem::ForwardFunction> function_of(const Study& study,
                                                            const std::vector<pave::pavement::Parameter>& parameters,
                                                            const std::vector<bool>& loads) {
    if (!study.has_own_model) {
        return make_function(study.model, parameters, loads);
    }
    return own_function(study, parameters);
}

pave::Outcome<pave::pavement::Response> own_response(const Study& study, const pave::pavement::Case& at,
                                                     bool with_jacobian) {
    const auto function = function_of(study, study.parameters, {});
    std::vector<double> values;
    for (const auto& parameter : study.parameters) {
        values.push_back(parameter.get(at));
    }
    auto outcome = function->evaluate(values, with_jacobian, *function->make_workspace());
    if (!outcome) {
        return outcome.failure();
    }
    problem::Prediction prediction = std::move(outcome).value();
    pave::pavement::Response response;
    response.values = std::move(prediction.responses);
    response.jacobian = std::move(prediction.jacobian);
    response.warnings = std::move(prediction.warnings);
    return response;
}

problem::Problem make_prediction_problem(const Study& study) {
    return problem_of(study, {}, problem::Misfit(study.data.misfit, {}));
}

problem::Problem make_prediction_problem(const Study& study, const std::vector<bool>& loads) {
    return {study.space, function_of(study, study.parameters, loads), problem::Misfit(study.data.misfit, {})};
}

std::vector<bool> computed_loads(const Study& study) {
    return with_constrained(fitted_loads(study), study);
}

std::vector<bool> fitted_loads(const Study& study) {
    std::vector<bool> loads(study.model.loads.size(), false);
    for (const Group& group : study.groups) {
        if (!group.held_out) {
            loads[static_cast<std::size_t>(study.model.sensors[group.rows[0]].load)] = true;
        }
    }
    return loads;
}

problem::Problem make_problem(const Study& study, Scope scope) {
    if (study.measured().empty()) {
        throw pave::Error({.file = study.file, .key = "data"}, "this command needs measurements", {},
                          "[data] files = [...]");
    }
    std::vector<std::size_t> rows;
    std::vector<double> factor;
    const std::vector<bool> loads =
        scope == Scope::everything ? std::vector<bool>(study.model.loads.size(), true) : fitted_loads(study);
    for (const Group& group : study.groups) {
        if (!group.held_out) {
            rows.insert(rows.end(), group.rows.begin(), group.rows.end());
            factor.insert(factor.end(), group.rows.size(), std::sqrt(group.weight));
        }
    }
    problem::Problem problem = problem_of(study, loads, misfit_of(study, rows, factor));
    if (const auto known = problem.priors();
        !known.empty() && (study.data.misfit != problem::MisfitKind::weighted || !problem.noise_is_stated())) {
        throw pave::Error(
            {.file = study.file, .key = "parameter \"" + study.space.axes[known[0]].name + "\" prior"},
            "what is known of a parameter is weighed against the noise of the readings",
            problem.noise_is_stated()         ? fmt::format("misfit = \"{}\"", to_string(study.data.misfit))
            : problem.noise_scale_is_sought() ? "[data.noise] scale = \"sought\""
                                              : "readings without stated noise",
            "misfit = \"weighted\" and a sigma of every reading, or [data.noise], of a size that is known");
    }
    return problem;
}

problem::Problem make_noise_problem(const Study& study, Scope scope) {
    return make_problem(study, scope).in_units_of_noise();
}

problem::Problem make_problem(const Study& study, const Group& group) {
    std::vector<bool> loads(study.model.loads.size(), false);
    loads[static_cast<std::size_t>(study.model.sensors[group.rows[0]].load)] = true;
    return problem_of(study, loads, misfit_of(study, group.rows)).without_priors();
}

double group_rms(const Study& study, const Group& group, const std::vector<double>& responses) {
    const auto residuals = misfit_of(study, group.rows).residuals(responses);
    return residuals.norm() / std::sqrt(static_cast<double>(residuals.size()));
}

} // namespace explore::study

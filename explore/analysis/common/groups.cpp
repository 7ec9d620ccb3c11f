#include "analysis/common/groups.h"

#include <algorithm>
#include <cmath>

namespace explore::analysis {

Predictor::Predictor(const study::Study& study) : problem_(study::make_problem(study)) {}

void Predictor::complete(problem::Evaluation& evaluation) const {
    const bool complete = std::none_of(evaluation.responses.begin(), evaluation.responses.end(),
                                       [](double value) { return std::isnan(value); });
    if (complete) {
        return;
    }
    const auto workspace = problem_.function->make_workspace();
    auto outcome = problem_.function->evaluate(evaluation.parameters, false, *workspace);
    if (outcome) {
        evaluation.responses = outcome->responses;
        evaluation.warnings = outcome->warnings;
    } else {
        evaluation.warnings.push_back("not all loads have an answer here: " + outcome.failure().reason);
    }
}

std::vector<double> group_rms(const study::Study& study, const problem::Evaluation& evaluation) {
    std::vector<double> rms;
    for (const auto& group : study.groups) {
        rms.push_back(study::group_rms(study, group, evaluation.responses));
    }
    return rms;
}

GroupFit group_fit(const study::Study& study, const Predictor& predictor, std::string fitted,
                   const problem::Problem& problem, landscape::Minimum minimum) {
    GroupFit fit{.fitted = std::move(fitted), .minimum = std::move(minimum), .local = {}, .best = {}, .rms = {}};
    fit.local = landscape::analyse(fit.minimum, problem);
    fit.best = fit.minimum.evaluation;
    predictor.complete(fit.best);
    fit.rms = group_rms(study, fit.best);
    return fit;
}

std::optional<std::vector<GroupFit>> fit_alone(Session& session, const study::Study& study, const Predictor& predictor,
                                               const search::Design& design, const landscape::MultistartResult& joint,
                                               const std::string& settings, landscape::MultistartSettings multistart) {
    std::vector<GroupFit> fits;
    if (study.groups_fitted().size() < 2) {
        return fits;
    }
    // The joint answer is one of the starts, and the points were explored for the joint fit: a third is enough.
    multistart.starts = std::max(2, multistart.starts / 3);
    for (const auto& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        const problem::Problem own = study::make_problem(study, group);
        std::vector<problem::Evaluation> explored = joint.explored;
        for (auto& evaluation : explored) {
            if (evaluation.converged()) {
                evaluation.misfit = own.misfit(evaluation);
            }
        }
        auto engine = session.engine(own, session.begin(study, "fit", settings + "; " + group.name + " alone"));
        auto result = landscape::refine(engine, own, design, std::move(explored), {joint.minima[0].unit}, multistart);
        if (!result) {
            return std::nullopt;
        }
        fits.push_back(group_fit(study, predictor, group.name, own, std::move(result->minima[0])));
    }
    return fits;
}

} // namespace explore::analysis

#include "analysis/compare/compare.h"

#include "base/error.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using pave::figure;

std::vector<std::string> findings(const CompareResult& result) {
    const std::vector<FittedLaw>& laws = result.laws;
    const std::string& layer = result.layer;
    std::vector<std::string> text;
    const FittedLaw& first = laws[0];
    if (!first.failed.empty()) {
        return {result.is_of_studies() ? "No study has an answer." : "No law has an answer."};
    }
    const std::string kind = result.is_of_studies() ? "study" : "law";
    const std::string kinds = result.is_of_studies() ? "studies" : "laws";
    const std::string in_layer = result.is_of_studies() ? "" : fmt::format(" in \"{}\"", layer);
    if (!result.same_noise) {
        text.emplace_back("The studies state different noise for the same readings: chi2 and AICc have units of their "
                          "own and are not compared. The evidence is the density of the same readings under each.");
    } else if (!std::isfinite(first.aicc)) {
        text.emplace_back(
            fmt::format("There are too few readings for so many parameters: no criterion can weigh the {}. "
                        "Hold parameters, or add readings.",
                        kinds));
    } else {
        std::vector<std::string> alive;
        std::vector<std::string> out;
        std::vector<std::string> unweighed;
        for (const FittedLaw& f : laws) {
            if (f.failed.empty()) {
                (!std::isfinite(f.aicc) ? unweighed : f.weight >= 0.05 ? alive : out).emplace_back(f.name());
            }
        }
        if (alive.size() == 1) {
            text.push_back(fmt::format("{} data prefer {}{}.",
                                       result.is_of_studies() ? "The" : fmt::format("In \"{}\" the", layer), alive[0],
                                       out.empty() ? ""
                                                   : fmt::format(": the AICc of the next best, {}, is {} higher",
                                                                 out[0], figure(laws[1].aicc - first.aicc))));
        } else {
            text.push_back(fmt::format("The data cannot tell these {}{} apart: {}.{}", kinds, in_layer,
                                       pave::join(alive),
                                       out.empty() ? "" : " They speak against " + pave::join(out) + "."));
            if (!first.study.outputs().empty()) {
                text.push_back(fmt::format("What an output may be lies within the ranges of all of these {}.", kinds));
            }
        }
        if (!unweighed.empty()) {
            text.push_back(fmt::format("That is among the {} that AICc can weigh: for so few readings {} {} too many "
                                       "parameters.",
                                       kinds, pave::join(unweighed), unweighed.size() == 1 ? "has" : "have"));
        }
    }
    const auto most = std::max_element(laws.begin(), laws.end(), [](const FittedLaw& a, const FittedLaw& b) {
        return (a.evidence ? a.evidence->weight : -1.0) < (b.evidence ? b.evidence->weight : -1.0);
    });
    if (most->evidence) {
        text.push_back(fmt::format("By evidence {} is the most probable {} ({:.0f} % among these, alike before). It "
                                   "depends on the ranges and priors of the parameters, AICc does not.",
                                   most->name(), kind, 100.0 * most->evidence->weight));
        for (const FittedLaw& f : laws) {
            if (f.evidence && !f.evidence->missing.empty()) {
                text.push_back(fmt::format("The sample of {} has {}: its evidence is no more than a hint.", f.name(),
                                           f.evidence->missing));
            }
        }
    }
    const auto fits = [](const FittedLaw& f) { return f.failed.empty() && f.p_value && *f.p_value >= 0.05; };
    if (std::any_of(laws.begin(), laws.end(), [](const FittedLaw& f) { return f.p_value.has_value(); })) {
        std::vector<std::string> names;
        for (const FittedLaw& f : laws) {
            if (fits(f)) {
                names.emplace_back(f.name());
            }
        }
        text.push_back(names.empty() ? "None fits within the stated noise: something else is missing (diagnose)."
                                     : "Within the stated noise fit: " + pave::join(names) + ".");
    }
    const auto best_predictor = std::min_element(laws.begin(), laws.end(), [](const FittedLaw& a, const FittedLaw& b) {
        return a.by_place.value_or(INFINITY) < b.by_place.value_or(INFINITY);
    });
    if (best_predictor->by_place) {
        text.push_back(fmt::format("Readings left out place by place are predicted best by {} ({}{}).",
                                   best_predictor->name(), figure(*best_predictor->by_place),
                                   best_predictor->p_value ? " standard deviations" : ""));
    }
    return text;
}

} // namespace explore::analysis

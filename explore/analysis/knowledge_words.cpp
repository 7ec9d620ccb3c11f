#include "analysis/knowledge_words.h"

#include "analysis/unique.h"

#include "base/error.h"
#include "base/text.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using pave::figure;

std::string prior_words(const problem::Axis& axis) {
    return axis.scale == problem::Scale::log
               ? fmt::format("{}, times or divided by {:.3g}", figure(axis.prior->mean), std::exp(axis.prior->sd))
               : fmt::format("{} +- {}", figure(axis.prior->mean), figure(axis.prior->sd));
}

std::vector<std::string> prior_findings(const problem::Problem& problem, const landscape::PriorInfluence& influence) {
    std::vector<std::string> text;
    const auto& axes = problem.space.axes;
    constexpr double level = 0.05;
    if (influence.degrees_of_freedom > 0) {
        std::size_t worst = problem.priors()[0];
        const auto pull = [&](std::size_t k) { return std::abs(axes[k].pull(influence.readings_want[k])); };
        for (const std::size_t k : problem.priors()) {
            worst = pull(k) > pull(worst) ? k : worst;
        }
        text.push_back(
            influence.p_value < level
                ? fmt::format("The readings contradict what is known beforehand (p = {:.2g}): by themselves they call "
                              "for {} = {}, where the prior says {}.",
                              influence.p_value, axes[worst].name, figure(influence.readings_want[worst]),
                              prior_words(axes[worst]))
                : fmt::format("The readings do not contradict what is known beforehand (p = {:.2g}).",
                              influence.p_value));
    }
    if (!influence.only.empty()) {
        text.push_back(fmt::format("Without the priors the readings do not determine {}.",
                                   pave::join(names_of(problem.space, influence.only))));
    }
    std::vector<std::string> shares;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        constexpr double worth_saying = 0.05;
        if (influence.share[k] >= worth_saying) {
            shares.push_back(fmt::format("{} ({:.0f} %)", axes[k].name, 100.0 * influence.share[k]));
        }
    }
    text.push_back(shares.empty() ? "The priors add less than 5 % to what the readings say of any parameter."
                                  : "Of what is known, this share comes from the priors: " + pave::join(shares) + ".");
    return text;
}

std::string constraint_words(const problem::Problem& problem, const problem::Evaluation& answer) {
    std::vector<std::string> texts;
    for (const std::size_t i : problem.active_limits(answer)) {
        texts.push_back(problem.limits[i]->text());
    }
    return texts.empty()
               ? ""
               : fmt::format("This constraint is active at the answer: {}. Without it the readings may call for "
                             "other values.",
                             pave::join(texts));
}

} // namespace explore::analysis

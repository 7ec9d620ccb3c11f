#include "analysis/common/knowledge_words.h"

#include "analysis/unique/unique.h"

#include "base/error.h"
#include "base/text.h"

#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {

using pave::figure;
using pave::p_words;

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
                ? fmt::format(
                      "The readings contradict what is known beforehand ({}): by themselves they call "
                      "for {} = {}, where the prior says {}. Check that it is of this place and widen it if not; "
                      "diagnose looks for what the model lacks.",
                      p_words(influence.p_value), axes[worst].name, figure(influence.readings_want[worst]),
                      prior_words(axes[worst]))
                : fmt::format("The readings do not contradict what is known beforehand ({}).",
                              p_words(influence.p_value)));
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

ActiveConstraints active_constraints(const problem::Problem& problem, const landscape::Minimum& answer) {
    std::vector<std::string> texts;
    for (const std::size_t i : problem.active_limits(answer.evaluation)) {
        texts.push_back(problem.limits[i]->text());
    }
    if (texts.empty()) {
        return {};
    }
    const bool is_one = texts.size() == 1;
    std::string words = fmt::format("{} active at the answer: {}.",
                                    is_one ? "This constraint is" : "These constraints are", pave::join(texts));
    const problem::Problem by_noise = problem.in_units_of_noise();
    if (!answer.alone || !by_noise.noise_is_stated() || !by_noise.priors().empty()) {
        return {words + fmt::format(" Without {} the readings may call for other values.", is_one ? "it" : "them")};
    }
    const double rise =
        std::pow(by_noise.misfit(answer.evaluation), 2) - by_noise.of_readings().residuals(*answer.alone).squaredNorm();
    const double p = gsl_cdf_chisq_Q(std::max(0.0, rise), static_cast<double>(texts.size()));
    std::string wanted;
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        wanted += fmt::format("{}{} = {}", k == 0 ? "" : ", ", problem.space.axes[k].name,
                              figure(answer.alone->parameters[k]));
    }
    constexpr double level = 0.05;
    const bool contradicts = p < level;
    words += fmt::format(" The readings {} (chi2 is {} lower without, {}){}.",
                         !contradicts ? (is_one ? "do not contradict it" : "do not contradict them")
                                      : (is_one ? "contradict what it demands" : "contradict what they demand"),
                         figure(rise), p_words(p),
                         contradicts ? fmt::format("; by themselves they call for {}: loosen {}, or look for what the "
                                                   "model lacks (diagnose)",
                                                   wanted, is_one ? "it" : "them")
                                     : "");
    return {std::move(words), contradicts};
}

} // namespace explore::analysis

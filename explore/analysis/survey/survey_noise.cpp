#include "analysis/survey/survey_noise.h"

#include "data/median.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {

double noise_factor(const SurveyResult& result) {
    std::vector<double> shares; // of the median chi2
    unsigned above = 0;
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        const landscape::LocalAnalysis& local = s.fit->local;
        const bool is_normal = local.expected_chi2 == local.degrees_of_freedom; // of Student's it is simulated
        if (local.noise_is_stated && local.degrees_of_freedom > 0 && is_normal) {
            shares.push_back(local.chi2 / gsl_cdf_chisq_Pinv(0.5, local.degrees_of_freedom));
            above += shares.back() > 1.0 ? 1 : 0;
        }
    }
    const auto n = static_cast<unsigned>(shares.size());
    if (above == 0 || gsl_cdf_binomial_Q(above - 1, 0.5, n) > landscape::contradicted) {
        return 1.0;
    }
    return std::max(1.0, std::sqrt(data::median(std::move(shares))));
}

std::string_view noise_words(const SurveyResult& result) {
    return result.study->data.states_noise() ? "the stated noise"
                                             : "the noise of the readings (their repeats, 1 um and 1 % of a sensor)";
}

std::string noise_factor_words(const SurveyResult& result) {
    constexpr double told = 1.05;
    return result.noise_factor < told
               ? ""
               : fmt::format("At the median station the fit leaves {:.1f} times {}: sensors err more than that, or the "
                             "section is not quite right. The ranges of all stations are widened for it.",
                             result.noise_factor, noise_words(result));
}

} // namespace explore::analysis

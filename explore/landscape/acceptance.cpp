#include "landscape/acceptance.h"

#include "landscape/readings_alone.h"

#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {

double Acceptance::noise() const {
    return std::sqrt(variance);
}

problem::NoiseScale noise_scale_of(const Acceptance& acceptance) {
    return problem::noise_scale_of_fit(acceptance.variance * acceptance.degrees_of_freedom,
                                       acceptance.degrees_of_freedom);
}

std::optional<Acceptance> acceptance_of(const problem::Problem& problem, const Minimum& best) {
    constexpr double level = 0.95;
    Acceptance a;
    a.noise_is_stated = problem.noise_is_stated();
    const JudgedFit fit = judged_fit(problem, best);
    a.degrees_of_freedom = fit.degrees_of_freedom;
    const double dof = a.degrees_of_freedom;
    double expected = dof;
    if (a.noise_is_stated) {
        const Goodness goodness = goodness_of(fit.problem, *fit.at, fit.sum, a.degrees_of_freedom);
        a.chi2 = fit.sum;
        a.p_value = goodness.p_value;
        a.widened = a.p_value < contradicted;
        expected = goodness.expected;
    } else if (a.degrees_of_freedom <= 0) {
        return std::nullopt;
    }
    if (a.noise_is_stated && !a.widened) {
        a.threshold = gsl_cdf_chisq_Pinv(level, 1.0);
    } else {
        a.variance = std::max(fit.sum / expected, 1e-24);
        a.threshold = gsl_cdf_fdist_Pinv(level, 1.0, dof);
    }
    return a;
}

} // namespace explore::landscape

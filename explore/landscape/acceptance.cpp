#include "landscape/acceptance.h"

#include "landscape/goodness.h"

#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {

double Acceptance::noise() const {
    return std::sqrt(variance);
}

std::optional<Acceptance> acceptance_of(const problem::Problem& problem, const Minimum& best) {
    constexpr double level = 0.95;
    Acceptance a;
    a.noise_is_stated = problem.noise_is_stated();
    a.degrees_of_freedom = problem.degrees_of_freedom(problem.space.axes.size() - best.on_bound.size() -
                                                      problem.active_limits(best.evaluation).size());
    const double sum = best.evaluation.misfit * best.evaluation.misfit;
    const double dof = a.degrees_of_freedom;
    double expected = dof;
    if (a.noise_is_stated) {
        const Goodness goodness = goodness_of(problem, best.evaluation, sum, a.degrees_of_freedom);
        a.chi2 = sum;
        a.p_value = goodness.p_value;
        a.widened = a.p_value < contradicted;
        expected = goodness.expected;
    } else if (a.degrees_of_freedom <= 0) {
        return std::nullopt;
    }
    if (a.noise_is_stated && !a.widened) {
        a.threshold = gsl_cdf_chisq_Pinv(level, 1.0);
    } else {
        a.variance = std::max(sum / expected, 1e-24);
        a.threshold = gsl_cdf_fdist_Pinv(level, 1.0, dof);
    }
    return a;
}

} // namespace explore::landscape

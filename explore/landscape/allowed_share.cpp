#include "landscape/allowed_share.h"

#include "base/random.h"
#include "landscape/minima.h"

#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::landscape {

std::optional<AllowedShare> allowed_share(const problem::Problem& problem, std::uint64_t seed) {
    if (problem.limits.empty()) {
        return std::nullopt;
    }
    problem::Problem known(problem.space, nullptr, problem::Misfit(problem::MisfitKind::noise, {}));
    known.limits = problem.limits;
    if (problem.priors().empty()) {
        known = known.without_priors();
    }
    const auto& axes = problem.space.axes;
    const auto priors = known.priors();
    problem::Evaluation at; // without responses
    at.status = pave::Status::converged;
    const pave::RandomStream random(seed, 0x5a4a0000ULL);
    std::uint64_t next = 0;
    double sum = 0.0;
    double squares = 0.0;
    const auto draw = [&] {
        std::vector<double> unit;
        for (std::size_t k = 0; k < axes.size(); ++k) {
            unit.push_back(random.uniform(next++));
        }
        double independent = 0.0; // logarithm of the priors' density there, over what is uniform in the box
        for (const std::size_t k : priors) {
            const problem::Axis& axis = axes[k];
            const double low = gsl_cdf_ugaussian_P(axis.pull(axis.low));
            const double high = gsl_cdf_ugaussian_P(axis.pull(axis.high));
            const double pull = gsl_cdf_ugaussian_Pinv(low + unit[k] * (high - low));
            if (std::isfinite(pull)) {
                const double here = (pull - axis.pull(axis.low)) / (axis.pull(axis.high) - axis.pull(axis.low));
                unit[k] = std::min(1.0, std::max(0.0, here));
            }
            independent += std::log(axis.d_pull() / (high - low)) - 0.5 * std::log(2.0 * M_PI) -
                           0.5 * axis.pull(axis.physical(unit[k])) * axis.pull(axis.physical(unit[k]));
        }
        at.parameters = problem.space.physical(unit);
        const double weight = std::exp(known.log_density(at) - independent);
        sum += weight;
        squares += weight * weight;
        return std::isfinite(weight);
    };
    constexpr std::uint64_t first = 1U << 15U;
    constexpr std::uint64_t most = 1U << 19U;
    constexpr double wanted = 400.0; // effective draws
    std::uint64_t drawn = 0;
    while (drawn < most && (drawn < first || sum * sum < wanted * squares)) {
        if (!draw()) {
            return std::nullopt;
        }
        ++drawn;
    }
    constexpr double least = 20.0;
    if (!(sum * sum >= least * squares) || sum == 0.0) {
        return std::nullopt;
    }
    const auto n = static_cast<double>(drawn);
    return AllowedShare{.log = std::log(sum / n), .error = std::sqrt(std::max(0.0, squares / (sum * sum) - 1.0 / n))};
}

} // namespace explore::landscape

#include "landscape/readings_alone.h"

#include "landscape/rank.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

namespace explore::landscape {

bool find_alone(run::Engine& engine, const problem::Problem& problem, Minimum& minimum, int first) {
    minimum.alone.reset();
    if (problem.priors().empty() && problem.active_limits(minimum.evaluation).empty()) {
        return true;
    }
    const problem::Problem alone = problem.of_readings();
    problem::Evaluation at = minimum.evaluation;
    at.misfit = alone.misfit(at);
    const bool finished = engine.chain("readings alone", first, [&](run::Chain& chain) {
        const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
            problem::Evaluation e = chain.at(unit);
            if (!e.converged()) {
                return optimise::Answer::no_answer;
            }
            sample = run::sample_of(alone, e);
            if (const double misfit = sample.residuals.norm(); misfit < at.misfit) {
                at = std::move(e);
                at.misfit = misfit;
            }
            return optimise::Answer::computed;
        };
        optimise::gauss_newton(minimum.unit, objective, {});
    });
    minimum.alone = std::move(at);
    return finished;
}

JudgedFit judged_fit(const problem::Problem& problem, const Minimum& minimum) {
    if (!minimum.alone) {
        const std::size_t held = minimum.on_bound.size() + problem.active_limits(minimum.evaluation).size();
        return {.problem = problem,
                .at = &minimum.evaluation,
                .sum = problem.residuals(minimum.evaluation).squaredNorm(),
                .degrees_of_freedom = problem.degrees_of_freedom(problem.space.axes.size() - held)};
    }
    JudgedFit fit{.problem = problem.of_readings(), .at = &*minimum.alone};
    fit.sum = fit.problem.residuals(*fit.at).squaredNorm();
    const Eigen::MatrixXd free =
        off_bounds(fit.problem.information_jacobian(*fit.at), bounds_met(problem.space.unit(fit.at->parameters)));
    const auto moved = static_cast<int>((free.colwise().squaredNorm().array() > 0.0).count());
    fit.degrees_of_freedom = static_cast<int>(fit.problem.readings() - fit.problem.censored()) -
                             (problem.noise_is_stated() ? rank_of(free) : moved);
    return fit;
}

} // namespace explore::landscape

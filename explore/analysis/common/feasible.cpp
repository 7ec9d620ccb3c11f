#include "analysis/common/feasible.h"

#include "base/error.h"
#include "base/text.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"
#include "search/design.h"
#include "study/constraints.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

void refuse_contradictions(const study::Study& study) {
    const problem::ParameterSpace& space = study.space;
    if (study.constraints.empty() || space.axes.empty()) {
        return;
    }
    problem::Problem problem =
        problem::Problem(space, nullptr, problem::Misfit(study.data.misfit, {})).without_priors();
    std::vector<int> lines;
    problem::Evaluation at; // without responses
    at.jacobian.setZero(0, static_cast<Eigen::Index>(space.axes.size()));
    at.parameters = space.physical(std::vector<double>(space.axes.size(), 0.5));
    const auto all = study::limits_of(study);
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (std::isfinite(all[i]->value(at.parameters, at.responses))) { // it reads no output
            problem.limits.push_back(all[i]);
            lines.push_back(study.constraints[i].line);
        }
    }
    const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
        at.parameters = space.physical(unit);
        sample = run::sample_of(problem, at);
        return sample.residuals.allFinite() ? optimise::Answer::computed : optimise::Answer::no_answer;
    };
    constexpr int starts = 64;
    std::vector<double> nearest;
    double lowest = std::numeric_limits<double>::infinity();
    for (const auto& start : search::sobol(space, starts, 1).points) {
        const auto found = optimise::gauss_newton(start, objective, {});
        if (!found.unit.empty() && found.misfit < lowest) {
            lowest = found.misfit;
            nearest = found.unit;
        }
        if (lowest < 1.0) { // within the tolerance of each
            return;
        }
    }
    std::vector<std::string> unmet;
    int line = 0;
    std::string found;
    if (!nearest.empty()) {
        at.parameters = space.physical(nearest);
        const Eigen::VectorXd beyond = problem.residuals(at);
        for (std::size_t i = 0; i < problem.limits.size(); ++i) {
            constexpr double slightly = 0.1;
            if (std::abs(beyond[static_cast<Eigen::Index>(i)]) > slightly) {
                unmet.push_back(fmt::format("\"{}\"", problem.limits[i]->text()));
                line = lines[i];
            }
        }
        for (std::size_t k = 0; k < at.parameters.size(); ++k) {
            found += fmt::format("{}{} = {}", k == 0 ? "" : ", ", space.axes[k].name, pave::figure(at.parameters[k]));
        }
    }
    throw pave::Error({.file = study.file, .line = line, .key = "[[constraints]] that"},
                      unmet.size() == 1 ? "this constraint cannot be met within the bounds of the parameters"
                                        : "these constraints contradict each other within the bounds of the parameters",
                      pave::join(unmet) + (found.empty() ? "" : "; nearest to it: " + found),
                      "constraints that some point of the box meets");
}

} // namespace explore::analysis

#include "analysis/feasible.h"

#include "base/error.h"
#include "base/text.h"
#include "optimise/gauss_newton.h"
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
    const auto all = study::limits_of(study);
    const std::vector<double> no_responses;
    std::vector<std::size_t> known; // without outputs
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (std::isfinite(all[i]->value(space.physical(std::vector<double>(space.axes.size(), 0.5)), no_responses))) {
            known.push_back(i);
        }
    }
    const auto rows = static_cast<Eigen::Index>(known.size());
    const auto n = static_cast<Eigen::Index>(space.axes.size());
    const optimise::Objective objective = [&](std::span<const double> unit, optimise::Sample& sample) {
        const auto parameters = space.physical(unit);
        sample.residuals.setZero(rows);
        sample.jacobian.setZero(rows, n);
        for (Eigen::Index i = 0; i < rows; ++i) {
            const problem::Limit& limit = *all[known[static_cast<std::size_t>(i)]];
            const double value = limit.value(parameters, no_responses);
            if (!std::isfinite(value)) {
                return optimise::Answer::no_answer;
            }
            if (value > 0.0 || limit.is_equality()) {
                sample.residuals[i] = value;
                sample.jacobian.row(i) = limit.gradient(parameters, no_responses, Eigen::MatrixXd());
                for (Eigen::Index k = 0; k < n; ++k) {
                    sample.jacobian(i, k) *=
                        space.axes[static_cast<std::size_t>(k)].d_physical(unit[static_cast<std::size_t>(k)]);
                }
            }
        }
        return optimise::Answer::computed;
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
        const auto parameters = space.physical(nearest);
        for (const std::size_t i : known) {
            const double value = all[i]->value(parameters, no_responses);
            constexpr double slightly = 0.1;
            if (value > slightly || (all[i]->is_equality() && std::abs(value) > slightly)) {
                unmet.push_back("\"" + all[i]->text() + "\"");
                line = study.constraints[i].line;
            }
        }
        for (std::size_t k = 0; k < parameters.size(); ++k) {
            found += fmt::format("{}{} = {}", k == 0 ? "" : ", ", space.axes[k].name, pave::figure(parameters[k]));
        }
    }
    throw pave::Error({.file = study.file, .line = line, .key = "[[constraints]] that"},
                      unmet.size() == 1 ? "this constraint cannot be met within the bounds of the parameters"
                                        : "these constraints contradict each other within the bounds of the parameters",
                      pave::join(unmet) + (found.empty() ? "" : "; nearest to it: " + found),
                      "constraints that some point of the box meets");
}

} // namespace explore::analysis

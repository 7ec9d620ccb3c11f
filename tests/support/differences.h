// Derivatives of a forward model by differences.
#pragma once

#include "pavement/forward.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace test {

struct Differences {
    std::vector<double> rates; // of every sensor, SI per file unit of the parameter
    bool same_path = true;     // the secant equilibrium was continued through the same loads at all points
};

// Of fourth order, central, from points h apart [file units]. exact: the response at c. A failure is that of a point.
inline pave::Outcome<Differences> central_differences(const pave::pavement::ForwardModel& model,
                                                      const pave::pavement::Case& c,
                                                      const pave::pavement::Parameter& parameter, double h,
                                                      const pave::pavement::Response& exact,
                                                      pave::pavement::ForwardModel::Workspace& workspace) {
    const std::pair<double, double> stencil[] = {{-2, 1.0 / 12}, {-1, -8.0 / 12}, {1, 8.0 / 12}, {2, -1.0 / 12}};
    Differences found;
    found.rates.resize(c.sensors.size(), 0.0);
    for (const auto& [offset, weight] : stencil) {
        pave::pavement::Case moved = c;
        parameter.in(moved) = (parameter.get(c) + offset * h) * parameter.to_si;
        const auto there = model.run(moved, {}, workspace);
        if (!there) {
            return there.failure();
        }
        found.same_path = found.same_path && there->statistics.load_steps == exact.statistics.load_steps;
        for (std::size_t i = 0; i < found.rates.size(); ++i) {
            found.rates[i] += weight * there->values[i] / h;
        }
    }
    return found;
}

// Column p of a jacobian against differences, as relative change of the response when the parameter changes by `range`:
// the largest disagreement, and the largest of the differences.
struct Disagreement {
    double worst = 0.0;
    double scale = 0.0;
};
inline Disagreement disagreement(const pave::pavement::Response& exact, std::size_t p, double range,
                                 const std::vector<double>& rates) {
    Disagreement d;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        const double unit = std::abs(range / exact.values[i]);
        const double found = exact.jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p));
        d.worst = std::max(d.worst, std::abs(rates[i] - found) * unit);
        d.scale = std::max(d.scale, std::abs(rates[i]) * unit);
    }
    return d;
}

// Derivatives of every reading of a pulse by these parameters, against differences from points a thousandth apart.
inline void expect_exact_derivatives(const pave::pavement::Case& c, std::initializer_list<const char*> paths,
                                     double tolerance) {
    const pave::pavement::ForwardModel model(c);
    const auto workspace = model.make_workspace();
    std::vector<pave::pavement::Parameter> parameters;
    for (const char* path : paths) {
        parameters.push_back(find_parameter(c, path, {}));
    }
    const auto exact = model.run(c, parameters, *workspace);
    ASSERT_TRUE(exact) << exact.failure().reason;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double value = parameters[p].get(c);
        const double range = value == 0.0 ? 1.0 : std::abs(value);
        const auto differences = central_differences(model, c, parameters[p], 1e-3 * range, *exact, *workspace);
        ASSERT_TRUE(differences);
        const auto d = disagreement(*exact, p, range, differences->rates);
        EXPECT_LT(d.worst, tolerance * std::max(d.scale, 0.1)) << parameters[p].path;
        EXPECT_GT(d.scale, 1e-6) << parameters[p].path;
    }
}

} // namespace test

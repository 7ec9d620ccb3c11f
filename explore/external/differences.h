// Derivatives of a model that offers none: differences of runs, in steps that its own noise asks for.
#pragma once

#include "external/simulator.h"
#include "problem/parameter_space.h"

#include <functional>
#include <vector>

namespace explore::external {

struct Differences {
    std::vector<double> steps; // of each coordinate of the unit cube
    bool central = true;       // else one-sided
    double noise = 0.0;        // of the responses, by their change over the whole range; 0: could not be estimated
    int runs = 0;              // that the estimate took

    // "Derivatives are by central differences ..."
    std::string words() const;
};

// The standard deviation of the errors (rounding, printed digits, tolerances) of a smooth function at points of equal
// distance, by the table of their differences (More and Wild 2011, SIAM Journal on Scientific Computing 33, 1292).
// Nothing: not to be told at this distance.
std::optional<double> noise_of(std::vector<double> values);

// run: the responses at a point of the unit cube, or nothing. start: the point around which it is estimated, on a line
// towards the middle of the cube. The step of a coordinate whose changes of that size the model does not see as such
// (it reads its input with fewer digits) is widened until it does.
using RunAt = std::function<std::optional<std::vector<double>>(const std::vector<double>& unit)>;
Differences estimate_differences(const RunAt& run, const std::vector<double>& start);

// Points whose responses make the derivative by coordinate k at `unit`, and their weights. The responses at `unit`
// itself are weighed by the negative sum of the weights.
struct Stencil {
    std::vector<double> at, weights;
};
// The k-th coordinate `at` where it is; all points lie in the cube where it does.
Stencil stencil_at(double at, const Differences& differences, std::size_t k);

} // namespace explore::external

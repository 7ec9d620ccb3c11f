// Ranges and walks that agree about what the data accept.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::landscape {

// A set that the data accept, met by one walk, beyond where those of a parameter or an output ended: what ended them
// was of their own neighbourhood (a point without an answer, a lower minimum aside, a fold of the output).
struct Beyond {
    std::size_t quantity = 0; // number of the parameter, or of the output
    int sign = 1;             // beyond the upper end; -1: the lower
    ProfilePoint point;       // its value: the quantity's
};

// The furthest of each parameter and side, more than a hair beyond its end.
std::vector<Beyond> beyond_ends(const problem::ParameterSpace& space, const Uniqueness& u);

// The same of outputs, at the ends of the walks of parameters. responses: which they are; everything: evaluates them,
// where `expected` of them, if known, lies beyond. What is a hair beyond an end is taken as the end. Nothing:
// interrupted.
using Expected = std::function<Eigen::VectorXd(const std::vector<double>& unit)>;
std::optional<std::vector<Beyond>> outputs_beyond(const std::vector<std::size_t>& responses, const Expected& expected,
                                                  run::Engine& everything, int first, Uniqueness& u);

// The range goes on from that point by the walk that began there. to: its end, as the range has it.
void walked_on(const problem::ParameterSpace& space, Beyond from, Branch walked, double to, Range& range);

// Ranges reach as far as any set that a walk met and the data accept: what is a hair beyond an end needs no walk.
void reach_accepted(const problem::ParameterSpace& space, Uniqueness& u);

} // namespace explore::landscape

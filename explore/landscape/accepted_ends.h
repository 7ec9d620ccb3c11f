// Ranges and walks that agree about what the data accept.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::landscape {

// A set that the data accept, met by one walk, beyond where the profile of a parameter ended: what ended that was of
// its own neighbourhood (a point without an answer, a lower minimum aside).
struct Beyond {
    std::size_t axis = 0;
    int sign = 1; // beyond the upper end; -1: the lower
    ProfilePoint point;
};

// The furthest of each parameter and side, more than a hair beyond its end.
std::vector<Beyond> beyond_ends(const problem::ParameterSpace& space, const Uniqueness& u);

// The profile goes on from that point by the walk that began there.
void walked_on(const problem::Problem& problem, Beyond from, Branch walked, Range& range);

// Ranges reach as far as any set that a walk met and the data accept: what is a hair beyond an end needs no walk.
void reach_accepted(const problem::ParameterSpace& space, Uniqueness& u);

} // namespace explore::landscape

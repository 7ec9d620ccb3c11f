// Two stores of the same command lines: where do they differ first?
#pragma once

#include "run/store.h"

namespace explore::run {

struct StoreDifference {
    std::size_t runs = 0;
    std::size_t evaluations = 0; // compared
    std::string first{};         // difference, in words; "": none
};

// The names of the two that are compared, in words.
struct Sides {
    std::string_view first, second;
};

// Where the bits of two evaluations of one point differ first, and which point it is; "": nowhere.
std::string difference_of(const RunHeader& run, RunNumber number, const problem::Evaluation& first,
                          const problem::Evaluation& second, const Sides& sides);

// Bit by bit: every evaluation of `then` must stand in `now`, and none else.
StoreDifference difference_of(const Store& then, const Store& now);

} // namespace explore::run

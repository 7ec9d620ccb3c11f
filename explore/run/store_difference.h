// Two stores of the same command lines: where do they differ first?
#pragma once

#include "run/store.h"

namespace explore::run {

struct StoreDifference {
    std::size_t runs = 0;
    std::size_t evaluations = 0; // compared
    std::string first{};         // difference, in words; "": none
};

// Bit by bit: every evaluation of `then` must stand in `now`, and none else.
StoreDifference difference_of(const Store& then, const Store& now);

} // namespace explore::run

// Where a range that was walked differs from what the best point promises to first order, and why.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::analysis {

struct RangeShape {
    double gaussian_low = 0.0, gaussian_high = 0.0; // physical: value -+ the accepted rise to first order, in the box
    double ratio = 1.0;                             // of the walked range to it, on the parameter's scale
    std::string reason{};                           // why they differ by more than a fifth; "": they do not
};

// Of every parameter; nothing where a first-order range is not finite or no range was walked. problem: residuals in
// units of their noise, where that is stated.
std::vector<std::optional<RangeShape>> range_shapes(const problem::Problem& problem, const landscape::Uniqueness& u);

// Which ranges differ so, in a sentence; "": none.
std::string shape_words(const problem::Problem& problem, const landscape::Uniqueness& u);

} // namespace explore::analysis

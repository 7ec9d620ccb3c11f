// Where a walked range differs from the first-order range around the best point, and why.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::analysis {

struct RangeShape {
    // Physical: what the accepted rise leaves to first order (held_ranges.h), in the box.
    double gaussian_low = 0.0, gaussian_high = 0.0;
    double ratio = 1.0;   // of the walked range to it, on the parameter's scale
    std::string reason{}; // why they differ by more than a fifth; "": they do not
};

// Ranges that differ by more than this share of their width are said to differ.
inline constexpr double range_matters = 0.2;

// Why a walked range is not that of a normal distribution: more than one minimum, or what ended its walks; "": neither.
std::string what_shapes(const problem::Problem& problem, const landscape::Uniqueness& u, const landscape::Range& range);
// "skew: it reaches 1.4 times as far up as down"; "": by less than a fifth. below, above: of the middle.
std::string skew_words(double below, double above);

// Of every parameter; nothing where a first-order range is not finite or no range was walked. problem: residuals in
// units of their noise, where that is stated.
std::vector<std::optional<RangeShape>> range_shapes(const problem::Problem& problem, const landscape::Uniqueness& u);

// The ranges that differ, in a sentence; "" if none do.
std::string shape_words(const problem::Problem& problem, const landscape::Uniqueness& u);

} // namespace explore::analysis

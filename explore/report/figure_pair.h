// The rise of chi2 over a pair of parameters, all others fitted, as `unique` leaves it.
#pragma once

#include "report/contours.h"
#include "report/figure_corner.h"

namespace explore::report {

struct Pair {
    std::size_t x = 0, y = 0; // parameters
    Grid grid;                // unit coordinates; z the rise, not a number: no answer
    bool has_answers() const;
};
// Of {"x", "y", "x_values", "y_values", "rise": rows of y}.
Pair pair_of(const Json& json, const std::vector<Parameter>& parameters);

// Roots of the rises, which are nearly linear around a minimum, on a grid so many times finer. Values without one are
// the mean of their neighbours', from the edge of a hole inwards: contours end at the hole as they came.
Grid fine_roots(const Grid& rises, int times);

} // namespace explore::report

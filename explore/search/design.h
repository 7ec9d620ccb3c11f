// Sets of points of the unit cube, by run number.
#pragma once

#include "problem/parameter_space.h"

#include <cstdint>
#include <span>
#include <vector>

namespace explore::search {

// Points of the unit cube; point k is fixed by the design alone, so any thread may compute any of them.
struct Design {
    std::string name; // "grid 9 x 9 x 9 x 9", "sobol 256 (seed 1)"
    std::vector<std::vector<double>> points;
    // Designs of one family begin with the same points, however many there are; empty: it is the only one of its kind.
    std::string family{};

    const std::string& run_name() const { return family.empty() ? name : family; }
};

// Of two points of the unit cube.
double squared_distance(std::span<const double> a, std::span<const double> b);

// Every combination of axis.points (or `points_per_axis` when positive) equally spaced values of each axis, the last
// axis fastest. An axis with one point is held at its start value.
// Throws pave::Error where that makes more than `most_grid_points`.
inline constexpr std::int64_t most_grid_points = 100'000'000;
Design full_grid(const problem::ParameterSpace& space, int points_per_axis = 0);

// Number of points full_grid would have; 0 when an axis does not state its points; the largest number there is where no
// number holds them.
std::int64_t full_grid_size(const problem::ParameterSpace& space, int points_per_axis = 0);

// Sobol's sequence (Bratley and Fox, by GSL; at most 40 dimensions) shifted as a whole by an amount drawn from the
// seed (Cranley and Patterson).
Design sobol(const problem::ParameterSpace& space, int count, std::uint64_t seed);

// For each of `axes` in turn: `points` equally spaced values of that coordinate, the others in the middle of the cube.
Design one_at_a_time(int dimension, const std::vector<std::size_t>& axes, int points);

// The radial design of Saltelli et al. (2010, doi 10.1016/j.cpc.2009.09.018, section 4): two samples A and B, and A
// with one column at a time taken from B. Row j of the design is the points j (d + 2) + 0: A_j, + 1: B_j, + 2 + i: A_j
// with coordinate i of B_j. A and B are the halves of one shifted Sobol sequence in 2 d dimensions, so d is at most
// `most_radial_dimensions`. A design of more rows begins with the rows of a smaller one.
inline constexpr int most_radial_dimensions = 20;
Design radial(int dimension, int rows, std::uint64_t seed);

} // namespace explore::search

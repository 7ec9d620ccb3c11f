// One-dimensional graded subdivisions: the lines of a structured mesh.
#pragma once

#include <vector>

namespace pave::mesh {

// Near `at` cells shall not be larger than `size` [m].
struct Feature {
    double at;
    double size;
};

// How cells grow away from features: size = feature size + growth * distance, at most max_size [m].
struct Grading {
    double growth = 0.3;
    double max_size = 1.0;
};

// Lines from breaks.front() to breaks.back(): every break is a line, and between breaks the cells follow the wanted
// size (the number of cells is the integral of 1/size, rounded up but for a twentieth of a cell). breaks: increasing,
// at least two.
std::vector<double> graded_lines(const std::vector<double>& breaks, const std::vector<Feature>& features,
                                 const Grading& grading);

// Breaks but those nearer to the break before them, or to the last, than a tenth of a cell as wanted there. The first
// and the last always stay.
std::vector<double> without_slivers(const std::vector<double>& breaks, const std::vector<Feature>& features,
                                    const Grading& grading);

} // namespace pave::mesh

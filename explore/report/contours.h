// Contours of values on a grid of lines.
#pragma once

#include <vector>

namespace explore::report {

struct Grid {
    std::vector<double> x, y; // lines, rising
    std::vector<double> z;    // at their crossings, x fastest
};

// A grid so many times finer: between lines by monotone cubics (Fritsch and Carlson 1980, SIAM J. Numer. Anal. 17; the
// slopes of Fritsch and Butland 1984), along x, then along y. All values must be finite.
Grid refined(const Grid& grid, int times);

// One closed line around where z < level (`below`), or around a hole of that.
struct Contour {
    std::vector<double> x, y; // the first point is not repeated
    double level = 0.0;
    bool below = true; // what it encloses lies below the level
    double area = 0.0;
};

// Every contour of every level, z linear along the edges of the grid; where z < level at the border, the contour runs
// along it. The largest first: painted in this order, each over the others, they fill the bands between the levels.
std::vector<Contour> contours(const Grid& grid, const std::vector<double>& levels);

} // namespace explore::report

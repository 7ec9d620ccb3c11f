#include "report/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace explore::report {
namespace {

// Values of the monotone cubic through (x, y) at the places `at`, rising.
std::vector<double> cubic(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& at) {
    const std::size_t n = x.size();
    std::vector<double> slope(n, 0.0);
    const auto secant = [&](std::size_t i) { return (y[i + 1] - y[i]) / (x[i + 1] - x[i]); };
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = secant(i - 1);
        const double after = secant(i);
        if (before * after > 0.0) { // weighted harmonic mean
            const double a = x[i] - x[i - 1];
            const double b = x[i + 1] - x[i];
            slope[i] = 3.0 * (a + b) / ((2.0 * b + a) / before + (b + 2.0 * a) / after);
        }
    }
    slope.front() = secant(0);
    slope.back() = secant(n - 2);
    std::vector<double> values;
    std::size_t i = 0;
    for (const double place : at) {
        while (i + 2 < n && place > x[i + 1]) {
            ++i;
        }
        const double h = x[i + 1] - x[i];
        const double t = (place - x[i]) / h;
        const double u = 1.0 - t;
        values.push_back(y[i] * u * u * (1.0 + 2.0 * t) + slope[i] * h * t * u * u +
                         y[i + 1] * t * t * (3.0 - 2.0 * t) - slope[i + 1] * h * t * t * u);
    }
    return values;
}

std::vector<double> finer(const std::vector<double>& lines, int times) {
    std::vector<double> all;
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        for (int k = 0; k < times; ++k) {
            all.push_back(lines[i] + (lines[i + 1] - lines[i]) * k / times);
        }
    }
    all.push_back(lines.back());
    return all;
}

} // namespace

Grid refined(const Grid& grid, int times) {
    Grid fine{finer(grid.x, times), finer(grid.y, times), {}};
    const std::size_t nx = grid.x.size();
    const std::size_t ny = grid.y.size();
    std::vector<std::vector<double>> rows;
    for (std::size_t j = 0; j < ny; ++j) {
        const auto begin = grid.z.begin() + static_cast<std::ptrdiff_t>(j * nx);
        rows.push_back(cubic(grid.x, {begin, begin + static_cast<std::ptrdiff_t>(nx)}, fine.x));
    }
    fine.z.resize(fine.x.size() * fine.y.size());
    for (std::size_t i = 0; i < fine.x.size(); ++i) {
        std::vector<double> column;
        column.reserve(rows.size());
        for (const auto& row : rows) {
            column.push_back(row[i]);
        }
        const auto values = cubic(grid.y, column, fine.y);
        for (std::size_t j = 0; j < fine.y.size(); ++j) {
            fine.z[j * fine.x.size() + i] = values[j];
        }
    }
    return fine;
}

std::vector<Contour> contours(const Grid& grid, const std::vector<double>& levels) {
    // A ring of high values on the border closes every contour.
    const std::size_t nx = grid.x.size() + 2;
    const std::size_t ny = grid.y.size() + 2;
    const auto x = [&](std::size_t i) { return grid.x[std::clamp<std::size_t>(i, 1, nx - 2) - 1]; };
    const auto y = [&](std::size_t j) { return grid.y[std::clamp<std::size_t>(j, 1, ny - 2) - 1]; };
    const auto z = [&](std::size_t i, std::size_t j) {
        const bool outside = i == 0 || j == 0 || i == nx - 1 || j == ny - 1;
        return outside ? 1e300 : grid.z[(j - 1) * grid.x.size() + i - 1];
    };
    std::vector<Contour> all;
    for (const double level : levels) {
        // Edges by number: 2 node along x from the node, 2 node + 1 along y. Segments have the low side on their left.
        std::map<std::size_t, std::size_t> next;
        for (std::size_t j = 0; j + 1 < ny; ++j) {
            for (std::size_t i = 0; i + 1 < nx; ++i) {
                const std::array<double, 4> corner{z(i, j), z(i + 1, j), z(i + 1, j + 1), z(i, j + 1)};
                const std::array<std::size_t, 4> edge{2 * (j * nx + i), 2 * (j * nx + i + 1) + 1,
                                                      2 * ((j + 1) * nx + i), 2 * (j * nx + i) + 1};
                std::vector<std::size_t> out; // where the way around the cell leaves the low side
                std::vector<std::size_t> in;
                for (std::size_t e = 0; e < 4; ++e) {
                    const bool low = corner[e] < level;
                    const bool then = corner[(e + 1) % 4] < level;
                    if (low != then) {
                        (low ? out : in).push_back(e);
                    }
                }
                if (out.size() == 1) {
                    next[edge[out[0]]] = edge[in[0]];
                } else if (out.size() == 2) {
                    const bool joined = 0.25 * (corner[0] + corner[1] + corner[2] + corner[3]) < level;
                    for (const std::size_t e : out) {
                        next[edge[e]] = edge[(e + (joined ? 1 : 3)) % 4];
                    }
                }
            }
        }
        while (!next.empty()) {
            Contour contour;
            contour.level = level;
            const std::size_t first = next.begin()->first;
            std::size_t edge = first;
            do {
                const std::size_t node = edge / 2;
                const std::size_t i = node % nx;
                const std::size_t j = node / nx;
                const std::size_t i2 = i + (edge % 2 == 0 ? 1 : 0);
                const std::size_t j2 = j + (edge % 2 == 0 ? 0 : 1);
                const double share = (level - z(i, j)) / (z(i2, j2) - z(i, j));
                contour.x.push_back(x(i) + share * (x(i2) - x(i)));
                contour.y.push_back(y(j) + share * (y(j2) - y(j)));
                const auto following = next.find(edge);
                edge = following->second;
                next.erase(following);
            } while (edge != first);
            double twice = 0.0;
            for (std::size_t k = 0; k < contour.x.size(); ++k) {
                const std::size_t m = (k + 1) % contour.x.size();
                twice += contour.x[k] * contour.y[m] - contour.x[m] * contour.y[k];
            }
            contour.below = twice > 0.0;
            contour.area = 0.5 * std::abs(twice);
            if (contour.area > 0.0) {
                all.push_back(std::move(contour));
            }
        }
    }
    // Contours of several levels may all be the border: the highest then lies under the others. What they enclose
    // differs by rounding, which is no size.
    const double whole = (grid.x.back() - grid.x.front()) * (grid.y.back() - grid.y.front());
    const auto size = [&](const Contour& c) { return std::llround(c.area / whole * 1e9); };
    std::stable_sort(all.begin(), all.end(), [&](const Contour& a, const Contour& b) {
        return size(a) != size(b) ? size(a) > size(b) : a.below ? a.level > b.level : a.level < b.level;
    });
    return all;
}

} // namespace explore::report

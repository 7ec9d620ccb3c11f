#include "report/density.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace explore::report {
namespace {

constexpr std::size_t most_counted = 1000; // more are thinned out evenly
constexpr std::size_t lines = 97;          // of the grid along each side
constexpr double reach = 5.0;              // of a kernel, in its standard deviations

struct Point {
    double x = 0.0, y = 0.0, weight = 0.0;
    double way = 1.0; // of the slope of its kernel: -1 mirrored at one edge
    std::size_t of = 0;
};

struct Kernels {
    std::vector<Point> points{}; // with those that are mirrored near the square
    double sx = 0.0, sy = 0.0, slope = 0.0;

    // Of all but one, up to a factor that is the same everywhere.
    double density(double x, double y, std::size_t without) const {
        double sum = 0.0;
        for (const Point& p : points) {
            const double u = (x - p.x) / sx;
            const double v = (y - p.y) / sy;
            if (p.of == without || std::abs(u) > reach || std::abs(v) > reach) {
                continue;
            }
            sum += p.weight * std::exp(-0.5 * (u * u - 2.0 * p.way * slope * u * v + v * v) / (1.0 - slope * slope));
        }
        return sum;
    }
};

Kernels kernels_of(const std::vector<Point>& own) {
    double sum = 0.0;
    double squares = 0.0;
    std::array<double, 2> mean{};
    for (const Point& p : own) {
        sum += p.weight;
        squares += p.weight * p.weight;
        mean[0] += p.weight * p.x;
        mean[1] += p.weight * p.y;
    }
    mean = {mean[0] / sum, mean[1] / sum};
    double xx = 0.0;
    double yy = 0.0;
    double xy = 0.0;
    for (const Point& p : own) {
        xx += p.weight / sum * (p.x - mean[0]) * (p.x - mean[0]);
        yy += p.weight / sum * (p.y - mean[1]) * (p.y - mean[1]);
        xy += p.weight / sum * (p.x - mean[0]) * (p.y - mean[1]);
    }
    constexpr double least = 1e-4; // of a spread
    constexpr double steepest = 0.995;
    Kernels kernels;
    const double width = std::pow(sum * sum / squares, -1.0 / 6.0);
    kernels.sx = width * std::max(least, std::sqrt(xx));
    kernels.sy = width * std::max(least, std::sqrt(yy));
    kernels.slope = std::clamp(xy / std::max(least * least, std::sqrt(xx * yy)), -steepest, steepest);
    for (const Point& p : own) {
        for (const double x : {p.x, -p.x, 2.0 - p.x}) {
            for (const double y : {p.y, -p.y, 2.0 - p.y}) {
                const bool near = x > -reach * kernels.sx && x < 1.0 + reach * kernels.sx && y > -reach * kernels.sy &&
                                  y < 1.0 + reach * kernels.sy;
                if (near) {
                    kernels.points.push_back({x, y, p.weight, (x == p.x) == (y == p.y) ? 1.0 : -1.0, p.of});
                }
            }
        }
    }
    return kernels;
}

// Over the points with the reach of their kernels, within the square.
std::vector<double> lines_over(const std::vector<Point>& points, double Point::*along, double spread) {
    double low = 1.0;
    double high = 0.0;
    for (const Point& p : points) {
        low = std::min(low, p.*along);
        high = std::max(high, p.*along);
    }
    low = std::max(0.0, low - reach * spread);
    high = std::min(1.0, high + reach * spread);
    std::vector<double> at;
    for (std::size_t i = 0; i < lines; ++i) {
        at.push_back(low + (high - low) * static_cast<double>(i) / (lines - 1));
    }
    return at;
}

} // namespace

std::vector<Contour> densest_region(std::span<const double> x, std::span<const double> y,
                                    std::span<const double> weight, double share) {
    std::vector<Point> own;
    const std::size_t count = std::min(most_counted, x.size());
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = k * x.size() / count;
        if (weight[i] > 0.0) {
            own.push_back({x[i], y[i], weight[i], 1.0, own.size()});
        }
    }
    constexpr std::size_t fewest = 10;
    if (own.size() < fewest) {
        return {};
    }
    const Kernels kernels = kernels_of(own);
    std::vector<std::pair<double, double>> ranked; // density, weight
    double sum = 0.0;
    for (const Point& p : own) {
        ranked.emplace_back(kernels.density(p.x, p.y, p.of), p.weight);
        sum += p.weight;
    }
    std::sort(ranked.begin(), ranked.end());
    double below = 0.0;
    double level = ranked.front().first;
    for (const auto& [density, of_point] : ranked) {
        level = density;
        below += of_point;
        if (below > (1.0 - share) * sum) {
            break;
        }
    }
    Grid grid{lines_over(own, &Point::x, kernels.sx), lines_over(own, &Point::y, kernels.sy), {}};
    // The logarithm, which is nearly a paraboloid; low is dense.
    const auto height = [](double density) { return -std::log(std::max(density, 1e-300)); };
    for (const double at_y : grid.y) {
        for (const double at_x : grid.x) {
            grid.z.push_back(height(kernels.density(at_x, at_y, own.size())));
        }
    }
    return contours(grid, {height(level)});
}

} // namespace explore::report

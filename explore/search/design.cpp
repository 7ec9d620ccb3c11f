#include "search/design.h"

#include "base/error.h"
#include "base/random.h"

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gsl/gsl_qrng.h>
#include <limits>
#include <memory>
#include <numeric>

namespace explore::search {
namespace {

std::vector<std::vector<double>> shifted_sobol(unsigned dimension, int count, std::uint64_t seed) {
    const std::unique_ptr<gsl_qrng, decltype(&gsl_qrng_free)> generator(gsl_qrng_alloc(gsl_qrng_sobol, dimension),
                                                                        &gsl_qrng_free);
    const pave::RandomStream shift(seed, 0);
    std::vector<std::vector<double>> points;
    for (int k = 0; k < count; ++k) {
        std::vector<double> point(dimension);
        gsl_qrng_get(generator.get(), point.data());
        for (unsigned a = 0; a < dimension; ++a) {
            point[a] += shift.uniform(a);
            point[a] -= std::floor(point[a]);
        }
        points.push_back(std::move(point));
    }
    return points;
}

} // namespace

std::int64_t full_grid_size(const problem::ParameterSpace& space, int points_per_axis) {
    std::int64_t size = 1;
    for (const auto& axis : space.axes) {
        const std::int64_t points = points_per_axis > 0 && axis.points != 1 ? points_per_axis : axis.points;
        if (__builtin_mul_overflow(size, points, &size)) {
            return std::numeric_limits<std::int64_t>::max();
        }
    }
    return size;
}

double squared_distance(std::span<const double> a, std::span<const double> b) {
    return std::transform_reduce(a.begin(), a.end(), b.begin(), 0.0, std::plus<>(),
                                 [](double x, double y) { return (x - y) * (x - y); });
}

Design full_grid(const problem::ParameterSpace& space, int points_per_axis) {
    Design design;
    design.name = "grid";
    std::vector<int> count;
    for (const auto& axis : space.axes) {
        count.push_back(points_per_axis > 0 && axis.points != 1 ? points_per_axis : axis.points);
        design.name += fmt::format("{}{}", count.size() == 1 ? " " : " x ", count.back());
    }
    const std::int64_t size = full_grid_size(space, points_per_axis);
    if (size > most_grid_points) {
        throw pave::Error({.key = "points"}, "the full grid has too many points", design.name,
                          fmt::format("at most {} in all, or a sample (--design sobol)", most_grid_points));
    }
    for (std::int64_t k = 0; k < size; ++k) {
        std::vector<double> point(count.size());
        std::int64_t rest = k;
        for (std::size_t a = count.size(); a-- > 0;) {
            const auto i = static_cast<int>(rest % count[a]);
            rest /= count[a];
            point[a] = count[a] == 1 ? space.axes[a].unit(space.axes[a].start)
                                     : static_cast<double>(i) / static_cast<double>(count[a] - 1);
        }
        design.points.push_back(std::move(point));
    }
    return design;
}

Design sobol(const problem::ParameterSpace& space, int count, std::uint64_t seed) {
    return {.name = fmt::format("sobol {} (seed {})", count, seed),
            .points = shifted_sobol(static_cast<unsigned>(space.dimension()), count, seed),
            .family = fmt::format("sobol (seed {})", seed)};
}

Design one_at_a_time(int dimension, const std::vector<std::size_t>& axes, int points) {
    Design design;
    design.name = fmt::format("one at a time, {} points", points);
    for (const std::size_t a : axes) {
        for (int k = 0; k < points; ++k) {
            std::vector<double> point(static_cast<std::size_t>(dimension), 0.5);
            point[a] = static_cast<double>(k) / static_cast<double>(points - 1);
            design.points.push_back(std::move(point));
        }
    }
    return design;
}

Design radial(int dimension, int rows, std::uint64_t seed) {
    const auto d = static_cast<std::size_t>(dimension);
    Design design;
    design.name = fmt::format("radial {} x {} (seed {})", rows, dimension + 2, seed);
    design.family = fmt::format("radial (seed {})", seed);
    for (const auto& both : shifted_sobol(2 * static_cast<unsigned>(dimension), rows, seed)) {
        const auto middle = both.begin() + dimension;
        const std::vector<double> a(both.begin(), middle);
        design.points.push_back(a);
        design.points.emplace_back(middle, both.end());
        for (std::size_t i = 0; i < d; ++i) {
            design.points.push_back(a);
            design.points.back()[i] = both[d + i];
        }
    }
    return design;
}

} // namespace explore::search

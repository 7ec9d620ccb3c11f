#include "mesh/solid.h"

#include "base/error.h"
#include "mesh/grading.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace pave::mesh {

std::array<std::vector<double>, 2> patch_breaks(const SolidDemand& demand) {
    std::array<std::vector<double>, 2> breaks;
    breaks[0] = {0.0};
    if (demand.is_dual) {
        breaks[0].push_back(demand.x_inner);
    }
    breaks[0].insert(breaks[0].end(), {demand.x_outer, demand.extent});
    breaks[1] = {0.0, demand.y_outer, demand.extent};
    return breaks;
}

SolidMesh solid_mesh(const SolidDemand& demand) {
    const double fine = 1.0 / demand.refine;
    // Half the size of the patch, the length scale of everything below it.
    const double half = (demand.is_round ? 0.65 : 1.0) *
                        std::min((demand.x_outer - demand.x_inner) / (demand.is_dual ? 2.0 : 1.0), demand.y_outer);

    std::vector<double> bottoms(demand.thickness.size());
    std::partial_sum(demand.thickness.begin(), demand.thickness.end(), bottoms.begin());
    const double depth = bottoms.back();

    // A reading at a point sees changes over its depth, or nearer to the surface over the top layer; the edges of
    // the patch matter to it the less the farther away they are.
    std::vector<double> point_size;
    for (const double z : demand.point_depths) {
        point_size.push_back(0.8 * std::max(z, std::min(bottoms.front(), 0.4 * half)));
    }
    const auto lateral = [&](const std::vector<double>& edges, const std::vector<double>& gauges,
                             const std::vector<double>& points, const std::vector<double>& surface) {
        std::vector<Feature> features{{0.0, half * fine}};
        for (const double x : edges) {
            double size = 0.65 * half;
            for (std::size_t i = 0; i < points.size(); ++i) {
                size = std::min(size, std::max(point_size[i], 0.12 * std::abs(x - points[i])));
            }
            features.push_back({x, size * fine});
        }
        for (const double x : gauges) {
            features.push_back({x, 0.8 * half * fine});
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            features.push_back({points[i], std::min(0.5 * half, point_size[i]) * fine});
        }
        for (const double x : surface) {
            features.push_back({x, std::max(half, 0.33 * x) * fine});
        }
        return features;
    };
    std::vector<Feature> z_features{{0.0, 0.65 * half * fine}};
    for (std::size_t i = 0; i + 1 < bottoms.size(); ++i) {
        const double size = std::max(0.8 * half, 0.33 * bottoms[i]);
        z_features.push_back({bottoms[i], std::min(size, demand.thickness[i]) * fine});
    }
    for (const double z : demand.gauge_depths) {
        z_features.push_back({z, std::max(0.8 * half, 0.27 * z) * fine});
    }
    for (const double z : demand.point_depths) {
        z_features.push_back({z, std::max(0.1 * half, 0.12 * z) * fine});
    }
    std::vector<double> z_breaks{0.0};
    z_breaks.insert(z_breaks.end(), bottoms.begin(), bottoms.end());

    const double growth = demand.point_depths.empty() ? 0.8 : 0.6;
    const Grading lateral_grading{.growth = growth * fine, .max_size = demand.extent / 2.5 * fine};
    const Grading z_grading{.growth = 0.45 * fine, .max_size = depth / 3.0 * fine};
    const auto breaks = patch_breaks(demand);
    std::vector<double> x_edges{demand.x_outer};
    if (demand.is_dual) {
        x_edges.push_back(demand.x_inner);
    }
    const auto lines = [&](const std::vector<double>& along, const std::vector<Feature>& features) {
        return graded_lines(without_slivers(along, features, lateral_grading), features, lateral_grading);
    };
    return solid_mesh(lines(breaks[0], lateral(x_edges, demand.gauge_x, demand.point_x, demand.surface_x)),
                      lines(breaks[1], lateral({demand.y_outer}, demand.gauge_y, demand.point_y, demand.surface_y)),
                      graded_lines(z_breaks, z_features, z_grading), bottoms);
}

SolidMesh solid_mesh(std::vector<double> x_lines, std::vector<double> y_lines, std::vector<double> z_lines,
                     const std::vector<double>& layer_bottoms) {
    const double cells =
        static_cast<double>(x_lines.size()) * static_cast<double>(y_lines.size()) * static_cast<double>(z_lines.size());
    constexpr double most_cells = 2e6; // their factor would take terabytes
    if (cells > most_cells) {
        throw Error({.key = "mesh.refine"}, "a mesh in three dimensions would have too many cells",
                    fmt::format("{:.0f} cells", cells),
                    fmt::format("{:.0f}: a smaller refine or extent_m", most_cells));
    }
    SolidMesh mesh;
    mesh.x_lines = std::move(x_lines);
    mesh.y_lines = std::move(y_lines);
    mesh.z_lines = std::move(z_lines);
    mesh.layers = static_cast<int>(layer_bottoms.size());

    // Node numbers on the doubled grid: corners and the middles of edges only.
    const int rows_y = 2 * mesh.y_cells() + 1;
    const int rows_z = 2 * mesh.z_cells() + 1;
    const auto coordinate = [](const std::vector<double>& lines, int k) {
        return k % 2 == 0 ? lines[k / 2] : (lines[k / 2] + lines[k / 2 + 1]) / 2.0;
    };
    std::vector<int> number(static_cast<std::size_t>(2 * mesh.x_cells() + 1) * rows_y * rows_z, -1);
    const auto place = [&](int i, int j, int k) { return (static_cast<std::size_t>(i) * rows_y + j) * rows_z + k; };
    for (int i = 0; i <= 2 * mesh.x_cells(); ++i) {
        for (int j = 0; j < rows_y; ++j) {
            for (int k = 0; k < rows_z; ++k) {
                if (i % 2 + j % 2 + k % 2 < 2) {
                    number[place(i, j, k)] = static_cast<int>(mesh.nodes.size());
                    mesh.nodes.push_back(
                        {coordinate(mesh.x_lines, i), coordinate(mesh.y_lines, j), coordinate(mesh.z_lines, k)});
                }
            }
        }
    }
    // Offsets on the doubled grid of the local nodes, in the order of fe/hex20.h.
    static constexpr int offsets[20][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                                           {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
                                           {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};
    for (int i = 0; i < mesh.x_cells(); ++i) {
        for (int j = 0; j < mesh.y_cells(); ++j) {
            for (int k = 0; k < mesh.z_cells(); ++k) {
                std::array<int, 20> nodes{};
                for (int n = 0; n < 20; ++n) {
                    nodes[n] = number[place(2 * i + offsets[n][0], 2 * j + offsets[n][1], 2 * k + offsets[n][2])];
                }
                mesh.elements.push_back(nodes);
                const double middle = (mesh.z_lines[k] + mesh.z_lines[k + 1]) / 2.0;
                const auto above = std::upper_bound(layer_bottoms.begin(), layer_bottoms.end(), middle);
                mesh.layer.push_back(std::min(mesh.layers - 1, static_cast<int>(above - layer_bottoms.begin())));
            }
        }
    }
    return mesh;
}

} // namespace pave::mesh

#include "mesh/axisymmetric.h"

#include "mesh/grading.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace pave::mesh {

AxisymmetricMesh axisymmetric_mesh(const AxisymmetricDemand& demand) {
    const double a = demand.load_radius;
    const double fine = 1.0 / demand.refine;

    std::vector<double> bottoms(demand.thickness.size());
    std::partial_sum(demand.thickness.begin(), demand.thickness.end(), bottoms.begin());
    const double depth = bottoms.back();

    // A reading sees changes over its depth, or nearer to the surface over the top layer; the edge of the load
    // matters to it the less the farther away it is.
    const auto reading_size = [&](double z) {
        return demand.follows_gauges ? 0.35 * std::max(z, std::min(bottoms.front(), 0.2 * a))
                                     : std::numeric_limits<double>::infinity();
    };
    double edge_size = demand.edge_size * a;
    std::vector<Feature> r_features{{0.0, 0.15 * a * fine}};
    for (std::size_t i = 0; i < demand.gauge_radii.size(); ++i) {
        const double r = demand.gauge_radii[i];
        const double size = reading_size(demand.gauge_depths[i]);
        edge_size = std::min(edge_size, std::max(size, 0.1 * std::abs(r - a)));
        r_features.push_back({r, std::min(0.2 * a, size) * fine});
    }
    r_features.push_back({a, edge_size * fine});
    for (const double r : demand.surface_radii) {
        r_features.push_back({r, std::max(0.3 * a, 0.12 * r) * fine});
    }
    std::vector<Feature> z_features{{0.0, std::min(0.2, 1.25 * demand.edge_size) * a * fine}};
    for (std::size_t i = 0; i + 1 < bottoms.size(); ++i) {
        // An interface is felt the more, the nearer it lies to the load and the thinner the layer above it is.
        const double size = std::max(0.25 * a, 0.25 * bottoms[i]);
        z_features.push_back({bottoms[i], std::min(size, 0.7 * demand.thickness[i]) * fine});
    }
    for (const double z : demand.gauge_depths) {
        z_features.push_back({z, std::min(std::max(0.25 * a, 0.15 * z), reading_size(z)) * fine});
    }
    std::vector<double> z_breaks{0.0};
    z_breaks.insert(z_breaks.end(), bottoms.begin(), bottoms.end());

    const Grading r_grading{.growth = 0.3 * fine, .max_size = demand.extent / 8.0 * fine};
    const Grading z_grading{.growth = 0.25 * fine, .max_size = depth / 4.0 * fine};
    std::vector<double> r_breaks{0.0};
    if (a < demand.extent) {
        r_breaks.push_back(a);
    }
    r_breaks.push_back(demand.extent);
    return axisymmetric_mesh(graded_lines(r_breaks, r_features, r_grading),
                             graded_lines(z_breaks, z_features, z_grading), bottoms);
}

AxisymmetricMesh axisymmetric_mesh(std::vector<double> r_lines, std::vector<double> z_lines,
                                   const std::vector<double>& layer_bottoms) {
    AxisymmetricMesh mesh;
    mesh.r_lines = std::move(r_lines);
    mesh.z_lines = std::move(z_lines);
    mesh.layers = static_cast<int>(layer_bottoms.size());
    const int nr = mesh.r_cells();
    const int nz = mesh.z_cells();

    // Node numbers on the doubled grid (2 nr + 1) x (2 nz + 1), cell centres left out.
    const auto coordinate = [](const std::vector<double>& lines, int k) {
        return k % 2 == 0 ? lines[k / 2] : (lines[k / 2] + lines[k / 2 + 1]) / 2.0;
    };
    const int rows = 2 * nz + 1;
    std::vector<int> number((2 * nr + 1) * rows, -1);
    for (int i = 0; i <= 2 * nr; ++i) {
        for (int j = 0; j <= 2 * nz; ++j) {
            if (i % 2 == 0 || j % 2 == 0) {
                number[i * rows + j] = static_cast<int>(mesh.nodes.size());
                mesh.nodes.push_back({coordinate(mesh.r_lines, i), coordinate(mesh.z_lines, j)});
            }
        }
    }
    for (int i = 0; i < nr; ++i) {
        for (int j = 0; j < nz; ++j) {
            const auto at = [&](int di, int dj) { return number[(2 * i + di) * rows + 2 * j + dj]; };
            mesh.elements.push_back({at(0, 0), at(2, 0), at(2, 2), at(0, 2), at(1, 0), at(2, 1), at(1, 2), at(0, 1)});
            const double middle = (mesh.z_lines[j] + mesh.z_lines[j + 1]) / 2.0;
            const auto above = std::upper_bound(layer_bottoms.begin(), layer_bottoms.end(), middle);
            mesh.layer.push_back(std::min(mesh.layers - 1, static_cast<int>(above - layer_bottoms.begin())));
        }
    }
    return mesh;
}

} // namespace pave::mesh

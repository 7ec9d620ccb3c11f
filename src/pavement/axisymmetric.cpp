#include "fe/gauss_rule.h"
#include "pavement/buried.h"
#include "pavement/load_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pave::pavement {
namespace {

constexpr int doublings = 10; // deflections of a half-space are then within 0.2 %

} // namespace

mesh::AxisymmetricMesh Axisymmetric::nominal_mesh(const Case& c, int load) {
    mesh::AxisymmetricDemand demand;
    for (const Layer& layer : c.layers) {
        demand.thickness.push_back(layer.thickness);
    }
    demand.load_radius = c.loads[load].footprint().half_x;
    demand.extent = c.settings.extent;
    demand.refine = c.settings.refine;
    if (c.loads[load].plate_stiffness) {
        demand.edge_size = 0.02;
    }
    // The secant law has two equilibria where a small cell is near tension, and a search may end in either.
    const auto depends_on_stress = [](const Layer& layer) {
        return layer.law->stress_dependent() && layer.law->energy() == nullptr;
    };
    demand.follows_gauges = c.settings.integration != Integration::secant ||
                            std::none_of(c.layers.begin(), c.layers.end(), depends_on_stress);
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load != load) {
            continue;
        }
        const double r = std::hypot(sensor.x, sensor.y);
        if (!is_buried(sensor)) {
            demand.surface_radii.push_back(r);
        } else {
            demand.gauge_depths.push_back(sensor.depth);
            demand.gauge_radii.push_back(r);
        }
    }
    auto mesh = mesh::axisymmetric_mesh(demand);
    return c.half_space || c.loads[load].is_pulse()
               ? mesh_of({with_far_cells(std::move(mesh.r_lines), c, load, doublings),
                          with_far_cells(std::move(mesh.z_lines), c, load, doublings)},
                         c, load)
               : mesh;
}

Lines Axisymmetric::lines_of(const Mesh& mesh) {
    return {mesh.r_lines, mesh.z_lines};
}

Lines Axisymmetric::breaks(const Case& c, int load) {
    std::vector<double> bottoms = bottoms_of(c);
    bottoms.insert(bottoms.begin(), 0.0);
    return {with_far_cells({0.0, c.loads[load].footprint().half_x, c.settings.extent}, c, load, doublings),
            with_far_cells(std::move(bottoms), c, load, doublings)};
}

mesh::AxisymmetricMesh Axisymmetric::mesh_of(Lines lines, const Case& c, int load) {
    auto mesh = mesh::axisymmetric_mesh(std::move(lines[0]), std::move(lines[1]), bottoms_of(c));
    mesh.wall_is_open = c.loads[load].is_pulse();
    mesh.bottom_is_open = c.half_space && mesh.wall_is_open;
    mesh.endless = c.half_space && !mesh.wall_is_open;
    return mesh;
}

// The edge of the circle is a line of the mesh.
Eigen::VectorXd Axisymmetric::unit_load(const Mesh& mesh, const fe::Model<Element>& model, const Load& on) {
    const double radius = on.footprint().half_x;
    Eigen::VectorXd load = Eigen::VectorXd::Zero(model.free_unknowns());
    for (int i = 0; i < mesh.r_cells() && mesh.r_lines[i + 1] <= radius * (1.0 + 1e-12); ++i) {
        const int e = i * mesh.z_cells();
        const double half = (mesh.r_lines[i + 1] - mesh.r_lines[i]) / 2.0;
        const double middle = (mesh.r_lines[i + 1] + mesh.r_lines[i]) / 2.0;
        Element::Vector force = Element::Vector::Zero();
        // Quadratic shape function times r and the pressure: of degree five.
        for (const auto& [xi, weight] : fe::three_points) {
            const auto shape = Element::shape({xi, -1.0});
            const double r = middle + half * xi;
            const double pressure = 1.0 + on.pressure_shape * (2.0 * r * r / (radius * radius) - 1.0);
            const double factor = weight * half * 2.0 * std::numbers::pi * r * pressure;
            for (int k = 0; k < Element::nodes; ++k) {
                force[2 * k + 1] += factor * shape[k];
            }
        }
        model.scatter_add(e, force, load.data());
    }
    return load;
}

} // namespace pave::pavement

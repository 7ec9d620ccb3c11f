#include "base/gauss_legendre.h"
#include "pavement/buried.h"
#include "pavement/load_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pave::pavement {
namespace {

constexpr int doublings = 4; // of the cells of a half-space; more would cost many times the time
// A distance between patches that is none, in their half width. Breaks must be in order.
constexpr double touching = 1e-9;

mesh::SolidDemand demand_of(const Case& c, int load) {
    mesh::SolidDemand demand;
    for (const Layer& layer : c.layers) {
        demand.thickness.push_back(layer.thickness);
    }
    const auto footprint = c.loads[load].footprint();
    demand.is_dual = footprint.centre > 0.0;
    // Patches that touch to rounding touch.
    const double inner = footprint.inner();
    demand.x_inner = std::abs(inner) < touching * footprint.half_x ? touching * footprint.half_x : inner;
    demand.x_outer = footprint.outer();
    demand.y_outer = footprint.half_y;
    demand.is_round = footprint.shape == Patch::circle;
    demand.extent = c.settings.extent;
    demand.refine = c.settings.refine;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load != load) {
            continue;
        }
        const auto add = [&](std::vector<double>& x, std::vector<double>& y, std::vector<double>* depths) {
            x.push_back(std::abs(sensor.x));
            y.push_back(std::abs(sensor.y));
            if (depths != nullptr) {
                depths->push_back(sensor.depth);
            }
        };
        if (!is_buried(sensor)) {
            add(demand.surface_x, demand.surface_y, nullptr);
        } else if (sensor.gauge > 0.0 || sensor.quantity == Quantity::deflection) {
            add(demand.gauge_x, demand.gauge_y, &demand.gauge_depths);
        } else {
            add(demand.point_x, demand.point_y, &demand.point_depths);
        }
    }
    return demand;
}

// Calls at(x, y, weight) for points that integrate polynomials of the degree of the shape functions over the part of
// the footprint that lies in [x0, x1] x [y0, y1]: exactly for a rectangle, to rounding for a circle.
void integrate(const Load::Footprint& f, double x0, double x1, double y0, double y1, const auto& at) {
    x0 = std::max(x0, f.centre - f.half_x);
    x1 = std::min(x1, f.centre + f.half_x);
    y1 = std::min(y1, f.half_y);
    if (!(x0 < x1) || !(y0 < y1)) {
        return;
    }
    static const auto three = gauss_legendre(3);
    const auto along_y = [&](double x, double top, double weight) {
        const double half = (top - y0) / 2.0;
        for (const auto& [eta, w] : three) {
            at(x, y0 + half * (1.0 + eta), weight * half * w);
        }
    };
    if (f.shape == Patch::rectangle) {
        const double half = (x1 - x0) / 2.0;
        for (const auto& [xi, w] : three) {
            along_y(x0 + half * (1.0 + xi), y1, half * w);
        }
        return;
    }
    // x = centre + a sin(phi): the edge y = a cos(phi) is smooth. Panels end where the edge meets y0 and y1.
    static const auto many = gauss_legendre(20);
    const double a = f.half_x;
    std::vector<double> ends{std::asin(std::clamp((x0 - f.centre) / a, -1.0, 1.0)),
                             std::asin(std::clamp((x1 - f.centre) / a, -1.0, 1.0))};
    for (const double y : {y0, y1}) {
        const double meets = std::acos(std::clamp(y / a, -1.0, 1.0));
        for (const double phi : {-meets, meets}) {
            if (phi > ends[0] && phi < ends[1]) {
                ends.push_back(phi);
            }
        }
    }
    std::sort(ends.begin(), ends.end());
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        const double half = (ends[i + 1] - ends[i]) / 2.0;
        for (const auto& [xi, w] : many) {
            const double phi = ends[i] + half * (1.0 + xi);
            const double top = std::min(y1, a * std::cos(phi));
            if (top > y0) {
                along_y(f.centre + a * std::sin(phi), top, half * w * a * std::cos(phi));
            }
        }
    }
}

} // namespace

mesh::SolidMesh Solid::nominal_mesh(const Case& c, int load) {
    auto mesh = mesh::solid_mesh(demand_of(c, load));
    return c.half_space || c.loads[load].is_pulse()
               ? mesh_of({with_far_cells(std::move(mesh.x_lines), c, load, doublings),
                          with_far_cells(std::move(mesh.y_lines), c, load, doublings),
                          with_far_cells(std::move(mesh.z_lines), c, load, doublings)},
                         c, load)
               : mesh;
}

Lines Solid::lines_of(const Mesh& mesh) {
    return {mesh.x_lines, mesh.y_lines, mesh.z_lines};
}

Lines Solid::breaks(const Case& c, int load) {
    auto lateral = mesh::patch_breaks(demand_of(c, load));
    std::vector<double> bottoms = bottoms_of(c);
    bottoms.insert(bottoms.begin(), 0.0);
    return {with_far_cells(std::move(lateral[0]), c, load, doublings),
            with_far_cells(std::move(lateral[1]), c, load, doublings),
            with_far_cells(std::move(bottoms), c, load, doublings)};
}

mesh::SolidMesh Solid::mesh_of(Lines lines, const Case& c, int load) {
    auto mesh = mesh::solid_mesh(std::move(lines[0]), std::move(lines[1]), std::move(lines[2]), bottoms_of(c));
    mesh.wall_is_open = c.loads[load].is_pulse();
    mesh.bottom_is_open = c.half_space && mesh.wall_is_open;
    mesh.endless = c.half_space && !mesh.wall_is_open;
    return mesh;
}

Eigen::VectorXd Solid::unit_load(const Mesh& mesh, const fe::Model<Element>& model, const Load& on) {
    const auto footprint = on.footprint();
    Eigen::VectorXd load = Eigen::VectorXd::Zero(model.free_unknowns());
    for (int i = 0; i < mesh.x_cells(); ++i) {
        for (int j = 0; j < mesh.y_cells(); ++j) {
            const double x0 = mesh.x_lines[i];
            const double x1 = mesh.x_lines[i + 1];
            const double y0 = mesh.y_lines[j];
            const double y1 = mesh.y_lines[j + 1];
            Element::Vector force = Element::Vector::Zero();
            integrate(footprint, x0, x1, y0, y1, [&](double x, double y, double weight) {
                const auto shape =
                    Element::shape({2.0 * (x - x0) / (x1 - x0) - 1.0, 2.0 * (y - y0) / (y1 - y0) - 1.0, -1.0});
                const double u = (x - footprint.centre) / footprint.half_x;
                const double v = y / footprint.half_y;
                const double g =
                    (footprint.shape == Patch::circle ? 2.0 : 1.5) * (u * u + v * v) - 1.0; // see Load::pressure_shape
                const double factor = weight * (1.0 + on.pressure_shape * g);
                for (int k = 0; k < Element::nodes; ++k) {
                    force[Element::dim * k + Element::down] += factor * shape[k];
                }
            });
            model.scatter_add(mesh.element(i, j, 0), force, load.data());
        }
    }
    return load;
}

} // namespace pave::pavement

#include "pavement/forward.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/observation.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

namespace pave::pavement {
namespace {

using Element = fe::AxisymmetricQ8;
using Model = fe::Model<Element>;

std::vector<double> bottoms_of(const Case& c) {
    std::vector<double> bottoms;
    double z = 0.0;
    for (const Layer& layer : c.layers) {
        bottoms.push_back(z += layer.thickness);
    }
    return bottoms;
}

mesh::AxisymmetricDemand demand_of(const Case& c, int load) {
    mesh::AxisymmetricDemand demand;
    for (const Layer& layer : c.layers) {
        demand.thickness.push_back(layer.thickness);
    }
    demand.load_radius = c.loads[load].circle_radius();
    demand.extent = c.settings.extent;
    demand.refine = c.settings.refine;
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load != load) {
            continue;
        }
        const double r = std::hypot(sensor.x, sensor.y);
        if (sensor.quantity == Quantity::deflection) {
            demand.surface_radii.push_back(r);
        } else {
            demand.gauge_depths.push_back(sensor.depth);
            demand.gauge_radii.push_back(r);
        }
    }
    return demand;
}

// Piecewise linear map of mesh lines from one set of breaks to another of the same length.
std::vector<double> moved_lines(std::vector<double> lines, const std::vector<double>& from,
                                const std::vector<double>& to) {
    if (from == to) {
        return lines;
    }
    for (double& x : lines) {
        const auto above = std::lower_bound(from.begin(), from.end(), x);
        const std::size_t i = above - from.begin();
        x = *above == x ? to[i] : to[i - 1] + (x - from[i - 1]) / (from[i] - from[i - 1]) * (to[i] - to[i - 1]);
    }
    return lines;
}

std::vector<double> with_zero(std::vector<double> values) {
    values.insert(values.begin(), 0.0);
    return values;
}

// Force of a uniform pressure [Pa] on the circle of the given radius (a line of the mesh), on every free unknown.
Eigen::VectorXd circle_load(const mesh::AxisymmetricMesh& mesh, const Model& model, double radius, double pressure) {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(model.free_unknowns);
    for (int i = 0; i < mesh.r_cells() && mesh.r_lines[i + 1] <= radius * (1.0 + 1e-12); ++i) {
        const int e = i * mesh.z_cells();
        const double half = (mesh.r_lines[i + 1] - mesh.r_lines[i]) / 2.0;
        const double middle = (mesh.r_lines[i + 1] + mesh.r_lines[i]) / 2.0;
        Element::Vector force = Element::Vector::Zero();
        // Quadratic shape function times r: cubic, exact with three Gauss points.
        const double g = std::sqrt(0.6);
        for (const auto& [xi, weight] : {std::pair{-g, 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {g, 5.0 / 9.0}}) {
            const auto shape = Element::shape(xi, -1.0);
            const double factor = weight * half * pressure * 2.0 * std::numbers::pi * (middle + half * xi);
            for (int k = 0; k < Element::nodes; ++k) {
                force[2 * k + 1] += factor * shape[k];
            }
        }
        model.scatter_add(e, force, load.data());
    }
    return load;
}

std::vector<fe::LayerMaterial> materials_of(const Case& c) {
    std::vector<fe::LayerMaterial> layers;
    double top = 0.0;
    double stress = 0.0;
    for (const Layer& layer : c.layers) {
        fe::LayerMaterial m;
        m.law = layer.law;
        m.parameters = layer.parameters;
        if (const auto floor = layer.law->index_of("shear_floor"); floor && std::isnan(m.parameters[*floor])) {
            m.parameters[*floor] = c.settings.integration == Integration::secant ? 1.0 : 0.0;
        }
        m.top = top;
        m.thickness = layer.thickness;
        m.top_stress = stress;
        m.unit_weight = layer.density * unit::gravity;
        m.k0 = layer.k0;
        m.residual_stress = layer.residual_stress;
        top += layer.thickness;
        stress += m.unit_weight * layer.thickness;
        layers.push_back(std::move(m));
    }
    return layers;
}

std::string percent(double share) {
    return fmt::format("{:.0f} %", 100.0 * share);
}

} // namespace

// What one thread keeps for one load: the mesh of the last geometry and what was built on it.
class ForwardModel::Workspace {
public:
    struct Slot {
        std::vector<double> r_lines, z_lines;
        std::unique_ptr<const Model> model;
        std::unique_ptr<fe::Solver<Element>> solver;
        Eigen::VectorXd unit_load; // pressure 1 Pa
        std::vector<Observation> observations;
    };
    std::vector<Slot> slots;
};

void ForwardModel::WorkspaceDeleter::operator()(Workspace* workspace) const {
    delete workspace;
}

ForwardModel::WorkspacePointer ForwardModel::make_workspace() const {
    WorkspacePointer workspace(new Workspace);
    workspace->slots.resize(nominal_.loads.size());
    return workspace;
}

void check_sensor(const Case& c, const Sensor& s, const Place& place) {
    const Load& load = c.loads[s.load];
    const double depth = c.depth();
    const double distance = std::hypot(s.x, s.y);
    const double top = s.depth - s.gauge / 2.0;
    const double bottom = s.depth + s.gauge / 2.0;
    if (!load.is_axisymmetric()) {
        throw Error(place, "this version computes circular loads only",
                    load.name + (load.type == LoadType::dual_wheel ? ", a dual wheel" : ", a rectangular patch"),
                    "type = \"plate\", or type = \"wheel\" with patch = \"circle\"");
    }
    if (s.gauge > 0.0 && s.quantity != Quantity::strain_zz) {
        throw Error(place, "only strain_zz has a gauge length", fmt::format("gauge_mm = {:g}", s.gauge / unit::mm),
                    "0");
    }
    if (distance > c.settings.extent) {
        throw Error(place, "the sensor lies outside the mesh", fmt::format("{:g} m from the load", distance),
                    fmt::format("up to the wall at [mesh] extent_m = {}", c.settings.extent));
    }
    if (top < -1e-9 || bottom > depth * (1.0 + 1e-9)) {
        throw Error(place, "the sensor lies outside the mesh",
                    fmt::format("it reads from {:g} to {:g} mm depth", top / unit::mm, bottom / unit::mm),
                    fmt::format("0 to {:g} mm, the depth of the section", depth / unit::mm));
    }
    if (s.quantity == Quantity::deflection && s.depth != 0.0) {
        throw Error(place, "deflections are read at the surface", fmt::format("depth_mm = {:g}", s.depth / unit::mm),
                    "0");
    }
}

ForwardModel::ForwardModel(Case nominal) : nominal_(std::move(nominal)), lines_(nominal_.loads.size()) {
    for (const Sensor& sensor : nominal_.sensors) {
        check_sensor(nominal_, sensor, {.key = "sensor"});
    }
    const double extent = nominal_.settings.extent;
    for (std::size_t l = 0; l < nominal_.loads.size(); ++l) {
        const Load& load = nominal_.loads[l];
        if (!load.is_axisymmetric()) {
            continue;
        }
        if (!(load.circle_radius() < extent)) {
            throw Error({.key = "mesh.extent_m"}, "the load \"" + load.name + "\" does not fit into the mesh",
                        fmt::format("{}", extent), fmt::format("more than its radius of {} m", load.circle_radius()));
        }
        const auto mesh = mesh::axisymmetric_mesh(demand_of(nominal_, static_cast<int>(l)));
        lines_[l] = {mesh.r_lines, mesh.z_lines};
    }
}

std::vector<int> ForwardModel::unknowns() const {
    std::vector<int> counts;
    for (std::size_t l = 0; l < nominal_.loads.size(); ++l) {
        if (nominal_.loads[l].is_axisymmetric()) {
            counts.push_back(
                fe::axisymmetric_model(mesh::axisymmetric_mesh(lines_[l].r, lines_[l].z, bottoms_of(nominal_)))
                    .free_unknowns);
        }
    }
    return counts;
}

Outcome<Response> ForwardModel::run(const Case& values, const std::vector<Parameter>& parameters,
                                    Workspace& workspace) const {
    std::vector<Parameter> exact;
    std::copy_if(parameters.begin(), parameters.end(), std::back_inserter(exact),
                 [](const Parameter& p) { return !p.changes_geometry(); });
    Outcome<Response> outcome = run_exact(values, exact, workspace);
    if (!outcome || exact.size() == parameters.size()) {
        return outcome;
    }
    Response response = std::move(outcome).value();
    Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(response.values.size()),
                             static_cast<Eigen::Index>(parameters.size()));
    Eigen::Index next_exact = 0;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        if (!parameters[k].changes_geometry()) {
            jacobian.col(column) = response.jacobian.col(next_exact++);
            continue;
        }
        constexpr double relative_step = 1e-4;
        const double value = parameters[k].get(values);
        const double step = relative_step * std::abs(value);
        Case low = values;
        Case high = values;
        parameters[k].in(low) = (value - step) * parameters[k].to_si;
        parameters[k].in(high) = (value + step) * parameters[k].to_si;
        const auto below = run_exact(low, {}, workspace);
        const auto above = run_exact(high, {}, workspace);
        if (!below || !above) {
            return (below ? above : below).failure();
        }
        for (std::size_t i = 0; i < response.values.size(); ++i) {
            jacobian(static_cast<Eigen::Index>(i), column) = (above->values[i] - below->values[i]) / (2.0 * step);
        }
    }
    response.jacobian = std::move(jacobian);
    return response;
}

Outcome<Response> ForwardModel::run_exact(const Case& values, const std::vector<Parameter>& parameters,
                                          Workspace& workspace) const {
    for (const Layer& layer : values.layers) {
        if (const std::string why = layer.law->impossible(layer.parameters); !why.empty()) {
            return Failure{Status::invalid_parameters, "layer \"" + layer.name + "\": " + why};
        }
    }
    for (const Sensor& sensor : values.sensors) {
        if (sensor.depth + sensor.gauge / 2.0 > values.depth() * (1.0 + 1e-9)) {
            return Failure{Status::failed, fmt::format("a sensor at {:g} mm depth lies below the floor of this section",
                                                       sensor.depth / unit::mm)};
        }
    }
    const auto layers = materials_of(values);
    const auto n = static_cast<Eigen::Index>(parameters.size());

    Response response;
    response.values.resize(values.sensors.size());
    response.jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.sensors.size()), n);
    double tension = 0.0;
    double unstable = 0.0;
    double limited = 0.0;
    for (std::size_t l = 0; l < values.loads.size(); ++l) {
        const Load& load = values.loads[l];
        const bool is_read = std::any_of(values.sensors.begin(), values.sensors.end(),
                                         [&](const Sensor& s) { return s.load == static_cast<int>(l); });
        if (!is_read) {
            continue;
        }
        auto& slot = workspace.slots[l];
        const double radius = load.circle_radius();
        const double extent = values.settings.extent;
        auto r_lines =
            moved_lines(lines_[l].r, {0.0, nominal_.loads[l].circle_radius(), extent}, {0.0, radius, extent});
        auto z_lines = moved_lines(lines_[l].z, with_zero(bottoms_of(nominal_)), with_zero(bottoms_of(values)));
        if (r_lines != slot.r_lines || z_lines != slot.z_lines) {
            slot.r_lines = r_lines;
            slot.z_lines = z_lines;
            const auto mesh = mesh::axisymmetric_mesh(std::move(r_lines), std::move(z_lines), bottoms_of(values));
            slot.solver.reset();
            slot.model = std::make_unique<const Model>(fe::axisymmetric_model(mesh));
            slot.solver = std::make_unique<fe::Solver<Element>>(*slot.model);
            slot.unit_load = circle_load(mesh, *slot.model, radius, 1.0);
            slot.observations.clear();
            for (const Sensor& sensor : values.sensors) {
                slot.observations.push_back(sensor.load == static_cast<int>(l) ? observe(sensor, mesh, *slot.model)
                                                                               : Observation{});
            }
        }
        // Derivatives this load knows: layers, and its own pressure.
        std::vector<fe::Variation> variations;
        std::vector<std::pair<Eigen::Index, double>> target; // column, factor
        for (Eigen::Index k = 0; k < n; ++k) {
            const Parameter& p = parameters[static_cast<std::size_t>(k)];
            if (p.in_load && p.owner != static_cast<int>(l)) {
                continue;
            }
            const auto derivative = exact_derivative(values, p);
            variations.push_back(derivative->variation);
            target.emplace_back(k, derivative->factor);
        }
        const Eigen::VectorXd force = load.pressure * slot.unit_load;
        const auto solved = values.settings.integration == Integration::secant
                                ? slot.solver->secant(layers, force, variations, values.settings.solver)
                                : slot.solver->incremental(layers, force, variations, values.settings.solver);
        if (!solved) {
            return Failure{solved.status(), "load \"" + load.name + "\": " + solved.failure().reason};
        }
        const auto count = static_cast<Eigen::Index>(variations.size());
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load != static_cast<int>(l)) {
                continue;
            }
            const Observation& o = slot.observations[i];
            const bool stress = !o.on_stress.empty();
            response.values[i] =
                stress ? o.of_stress(solved->stress, 1, 0) : o.of_displacement(solved->displacement.data());
            for (Eigen::Index k = 0; k < count; ++k) {
                response.jacobian(static_cast<Eigen::Index>(i), target[k].first) =
                    target[k].second * (stress ? o.of_stress(solved->d_stress, count, k)
                                               : o.of_displacement(solved->d_displacement.col(k).data()));
            }
            if (!std::isfinite(response.values[i])) {
                return Failure{Status::failed, "load \"" + load.name + "\": the solution is not a finite number"};
            }
        }
        const auto& s = solved->statistics;
        response.statistics.load_steps += s.load_steps;
        response.statistics.rejected_steps += s.rejected_steps;
        response.statistics.newton_steps += s.newton_steps;
        response.statistics.factorizations += s.factorizations;
        response.statistics.residual_relative = std::max(response.statistics.residual_relative, s.residual_relative);
        tension = std::max(tension, s.tension_share);
        unstable = std::max(unstable, s.unstable_share);
        limited = std::max(limited, s.limited_share);
    }
    response.statistics.tension_share = tension;
    response.statistics.unstable_share = unstable;
    response.statistics.limited_share = limited;
    if (values.settings.extent < 1.99 * values.depth()) {
        response.warnings.push_back(
            fmt::format("the wall ([mesh] extent_m = {:g}) stands nearer than twice the depth of "
                        "the section ({:g} m): far deflections feel it",
                        values.settings.extent, values.depth()));
    }
    // Shares are weighted by the energy of the load stress: what is far away and hardly loaded does not count.
    if (tension > 0.05) {
        response.warnings.push_back(percent(tension) + " of the stress-dependent material is in tension (theta < 0)");
    }
    if (unstable > 0.0) {
        response.warnings.push_back(percent(unstable) + " of the stress-dependent material stiffens as fast as it is "
                                                        "stressed: no stable secant equilibrium there");
    }
    if (limited > 0.0) {
        response.warnings.push_back("the modulus limit of 100,000 MPa was met in " + percent(limited) +
                                    " of the stress-dependent material");
    }
    return response;
}

AxisymmetricCase axisymmetric_case(const Case& values, int load) {
    AxisymmetricCase c;
    c.mesh = mesh::axisymmetric_mesh(demand_of(values, load));
    c.model = fe::axisymmetric_model(c.mesh);
    c.load = circle_load(c.mesh, c.model, values.loads[load].circle_radius(), values.loads[load].pressure);
    c.layers = materials_of(values);
    return c;
}

} // namespace pave::pavement

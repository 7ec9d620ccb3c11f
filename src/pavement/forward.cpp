#include "pavement/forward.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/load_model.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace pave::pavement {
namespace {

std::string percent(double share) {
    return fmt::format("{:.0f} %", 100.0 * share);
}

} // namespace

class ForwardModel::Workspace {
public:
    std::vector<std::unique_ptr<LoadModel::Workspace>> of_load; // made when first needed
};

void ForwardModel::WorkspaceDeleter::operator()(Workspace* workspace) const {
    delete workspace;
}

ForwardModel::WorkspacePointer ForwardModel::make_workspace() const {
    WorkspacePointer workspace(new Workspace);
    workspace->of_load.resize(nominal_.loads.size());
    return workspace;
}

void check_sensor(const Case& c, const Sensor& s, const Place& place) {
    const Load& load = c.loads[s.load];
    const double depth = c.depth();
    const double distance = load.is_axisymmetric() ? std::hypot(s.x, s.y) : std::max(std::abs(s.x), std::abs(s.y));
    const double top = s.depth - s.gauge / 2.0;
    const double bottom = s.depth + s.gauge / 2.0;
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

ForwardModel::ForwardModel(Case nominal, const std::vector<bool>& loads) : nominal_(std::move(nominal)) {
    for (const Sensor& sensor : nominal_.sensors) {
        check_sensor(nominal_, sensor, {.key = "sensor"});
    }
    for (std::size_t l = 0; l < nominal_.loads.size(); ++l) {
        const bool is_read = std::any_of(nominal_.sensors.begin(), nominal_.sensors.end(),
                                         [&](const Sensor& s) { return s.load == static_cast<int>(l); });
        const bool wanted = is_read && (loads.empty() || loads[l]);
        models_.push_back(wanted ? make_load_model(nominal_, static_cast<int>(l)) : nullptr);
    }
}

std::vector<int> ForwardModel::unknowns() const {
    std::vector<int> counts;
    for (const auto& model : models_) {
        counts.push_back(model ? model->unknowns() : 0);
    }
    return counts;
}

Outcome<Response> ForwardModel::run(const Case& values, const std::vector<Parameter>& parameters,
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
    response.values.assign(values.sensors.size(), std::numeric_limits<double>::quiet_NaN());
    response.jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.sensors.size()), n);
    double tension = 0.0;
    double unstable = 0.0;
    double limited = 0.0;
    for (std::size_t l = 0; l < values.loads.size(); ++l) {
        if (!models_[l]) {
            continue;
        }
        auto& own = workspace.of_load[l];
        if (!own) {
            own = models_[l]->make_workspace();
        }
        // Derivatives this load knows: by the layers and by its own numbers.
        std::vector<fe::Variation> variations;
        std::vector<Parameter> moving;
        std::vector<std::pair<Eigen::Index, double>> target; // column, factor
        for (Eigen::Index k = 0; k < n; ++k) {
            const Parameter& p = parameters[static_cast<std::size_t>(k)];
            if (p.in_load && p.owner != static_cast<int>(l)) {
                continue;
            }
            if (p.changes_geometry()) {
                variations.push_back({.kind = fe::Variation::Kind::motion, .index = moving.size()});
                target.emplace_back(k, 1.0);
                moving.push_back(p);
                continue;
            }
            const Derivative derivative = derivative_of(values, p);
            variations.push_back(derivative.variation);
            target.emplace_back(k, derivative.factor);
        }
        const auto reading = models_[l]->run(values, layers, variations, moving, *own);
        if (!reading) {
            return Failure{reading.status(), "load \"" + values.loads[l].name + "\": " + reading.failure().reason};
        }
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (values.sensors[i].load != static_cast<int>(l)) {
                continue;
            }
            response.values[i] = reading->values[i];
            for (std::size_t k = 0; k < target.size(); ++k) {
                response.jacobian(static_cast<Eigen::Index>(i), target[k].first) =
                    target[k].second * reading->derivatives(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
            }
        }
        const auto& s = reading->statistics;
        response.statistics.load_steps += s.load_steps;
        response.statistics.rejected_steps += s.rejected_steps;
        response.statistics.newton_steps += s.newton_steps;
        response.statistics.factorizations += s.factorizations;
        response.statistics.iterations += s.iterations;
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

} // namespace pave::pavement

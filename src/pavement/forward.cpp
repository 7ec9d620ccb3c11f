#include "pavement/forward.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/device.h"
#include "pavement/effects/effect.h"
#include "pavement/load_model.h"
#include "pavement/pulse.h"
#include "pavement/solid_cost.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <set>

namespace pave::pavement {
namespace {

std::string percent(double share) {
    return fmt::format("{:.0f} %", 100.0 * share);
}

// Why a load cannot meet this case (without effects), or "".
std::string why_impossible(const Case& c, int load) {
    for (const Layer& layer : c.layers) {
        if (!(layer.thickness > 0.0)) {
            return "layer \"" + layer.name + "\" has no thickness left";
        }
        if (const std::string why = layer.law->impossible(layer.parameters); !why.empty()) {
            return "layer \"" + layer.name + "\": " + why;
        }
        for (const fe::Field& field : layer.fields) {
            if (field.parameter) { // between these two it is possible where it is at both
                auto there = layer.parameters;
                there[*field.parameter] += field.size * (field.target - there[*field.parameter]);
                if (const std::string why = layer.law->impossible(there); !why.empty()) {
                    return "layer \"" + layer.name + "\" far from the load: " + why;
                }
            }
        }
    }
    if (c.loads[load].patch == Patch::rectangle && c.loads[load].pressure_shape < -0.5) {
        return "the pressure would pull at the corners of the patch";
    }
    for (const Sensor& sensor : c.sensors) {
        if (sensor.load != load) {
            continue;
        }
        double longest = sensor.gauge;
        for (const Sensor::Share& share : sensor.shares) {
            longest = std::max(longest, share.gauge);
        }
        const double shallowest = sensor.depth - longest / 2.0;
        if (shallowest < -1e-9) {
            return fmt::format("a sensor at {:g} mm depth reaches above the surface", sensor.depth / unit::mm);
        }
        if (c.loads[load].is_axisymmetric() && reach_of(sensor) > c.settings.extent) {
            return "a sensor lies beyond the wall";
        }
    }
    return {};
}

// Below the floor of the case.
bool is_below(const Sensor& sensor, double depth) {
    double longest = sensor.gauge;
    for (const Sensor::Share& share : sensor.shares) {
        longest = std::max(longest, share.gauge);
    }
    return sensor.depth + longest / 2.0 > depth * (1.0 + 1e-9);
}

// A difference quotient of fourth order: values at value + offset * step, their weights over the step.
using Stencil = std::vector<std::pair<int, double>>;
const Stencil central_4{{-2, 1.0 / 12}, {-1, -8.0 / 12}, {1, 8.0 / 12}, {2, -1.0 / 12}};
const Stencil forward_4{{0, -25.0 / 12}, {1, 48.0 / 12}, {2, -36.0 / 12}, {3, 16.0 / 12}, {4, -3.0 / 12}};
const Stencil backward_4{{0, 25.0 / 12}, {-1, -48.0 / 12}, {-2, 36.0 / 12}, {-3, -16.0 / 12}, {-4, 3.0 / 12}};

// File units. A size changes a response by a like amount all over its range, from a null at which it may be zero.
double step_of(const Case& values, const Parameter& parameter) {
    const double value = parameter.get(values);
    return 1e-3 * (parameter.in_effect ? parameter.high - parameter.low : value == 0.0 ? 1.0 : std::abs(value));
}

const Stencil& stencil_of(const Case& values, const Parameter& parameter) {
    const double value = parameter.get(values);
    const double reach = 2.0 * step_of(values, parameter);
    return value - reach < parameter.low ? forward_4 : value + reach > parameter.high ? backward_4 : central_4;
}

Case moved_by(const Case& values, const Parameter& parameter, double change) {
    Case moved = values;
    parameter.in(moved) = (parameter.get(values) + change) * parameter.to_si;
    return moved;
}

// For a parameter of the geometry. What is differentiated with these are closed formulas of the positions of the mesh
// lines: the step leaves a relative error of some 1e-12.
Neighbours neighbours(const Case& values, const Parameter& parameter, int load) {
    const double step = step_of(values, parameter);
    Neighbours near;
    for (const auto& [offset, weight] : central_4) {
        near.emplace_back(weight / step, with_effects(moved_by(values, parameter, offset * step), load));
    }
    return near;
}

} // namespace

class ForwardModel::Workspace {
public:
    std::vector<std::unique_ptr<LoadModel::Workspace>> of_load; // made when first needed
    LoadModel::Lent lent;
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
    const double distance = load.is_axisymmetric() ? reach_of(s) : reach_along_axes(s);
    const double top = s.depth - s.gauge / 2.0;
    const double bottom = s.depth + s.gauge / 2.0;
    if (s.gauge > 0.0 && s.quantity != Quantity::strain_zz) {
        throw Error(place, "only strain_zz has a gauge length", fmt::format("gauge_mm = {:g}", s.gauge / unit::mm),
                    "0");
    }
    if (is_of_device(s.quantity) && s.depth != 0.0) {
        throw Error(place, fmt::format("{} is read on the surface", info(s.quantity).name),
                    fmt::format("depth_mm = {:g}", s.depth / unit::mm), "0");
    }
    if (distance > c.settings.extent) {
        throw Error(place, "the sensor lies outside the mesh", fmt::format("{:g} m from the load", distance),
                    fmt::format("up to the wall at [mesh] extent_m = {}", c.settings.extent));
    }
    if (top < -1e-9 || (!c.half_space && bottom > depth * (1.0 + 1e-9))) {
        throw Error(place, "the sensor lies outside the mesh",
                    fmt::format("it reads from {:g} to {:g} mm depth", top / unit::mm, bottom / unit::mm),
                    fmt::format("0 to {:g} mm, the depth of the section", depth / unit::mm));
    }
}

void check_integration(const Case& c, const Place& place) {
    if (c.settings.integration == Integration::secant && c.relaxes()) {
        throw Error(place, "a layer that relaxes is followed in time", "\"secant\"", "\"incremental\"");
    }
    if (c.settings.integration == Integration::secant &&
        std::any_of(c.loads.begin(), c.loads.end(), [](const Load& load) { return load.is_pulse(); })) {
        throw Error(place, "a load with a history is followed in time", "\"secant\"", "\"incremental\"");
    }
    if (c.settings.integration == Integration::secant && c.has_energy() && !c.is_hyperelastic()) {
        throw Error(place, "a hyperelastic layer stands beside other stress-dependent ones along the load path only",
                    "\"secant\"", "\"incremental\"");
    }
    if (c.settings.integration == Integration::secant && c.turns()) {
        throw Error(place, "a layer whose anisotropy follows the stress is followed along the load path", "\"secant\"",
                    "\"incremental\"");
    }
}

ForwardModel::ForwardModel(Case nominal, const std::vector<bool>& loads) : nominal_(std::move(nominal)) {
    check_integration(nominal_, {.key = "solver.integration"});
    for (const Sensor& sensor : nominal_.sensors) {
        check_sensor(nominal_, sensor, {.key = "sensor"});
    }
    path_of_ = path_of_each(nominal_);
    for (std::size_t l = 0; l < nominal_.loads.size(); ++l) {
        const auto load = static_cast<int>(l);
        const bool wanted = std::any_of(nominal_.sensors.begin(), nominal_.sensors.end(), [&](const Sensor& s) {
            const auto own = static_cast<std::size_t>(s.load);
            return path_of_[own] == load && (loads.empty() || loads[own]);
        });
        models_.push_back(wanted ? make_load_model(with_effects(nominal_, load), load, models_) : nullptr);
    }
}

ForwardModel::ForwardModel(Case nominal, std::vector<std::shared_ptr<const LoadModel>> models)
    : nominal_(std::move(nominal)),
      models_(std::move(models)),
      path_of_(nominal_.loads.size()) {
    std::iota(path_of_.begin(), path_of_.end(), 0);
}

std::vector<int> ForwardModel::unknowns() const {
    std::vector<int> counts;
    for (const auto& model : models_) {
        counts.push_back(model ? model->unknowns() : 0);
    }
    return counts;
}

ForwardModel::Cost ForwardModel::cost() const {
    Cost cost;
    std::set<const void*> counted;
    for (std::size_t l = 0; l < models_.size(); ++l) {
        if (!models_[l]) {
            continue;
        }
        const int unknowns = models_[l]->unknowns();
        const auto steps = nominal_.loads[l].is_pulse() ? steps_of(nominal_, static_cast<int>(l)) : 0;
        double seconds = layered_seconds;
        double share = 1.0; // of a derivative
        if (!nominal_.loads[l].is_axisymmetric()) {
            if (counted.insert(models_[l]->shared_model()).second) {
                cost.memory += solid_memory(unknowns);
            }
            seconds = solid_seconds(unknowns, steps);
            share = solid_derivative;
        } else if (unknowns > 0) {
            const std::vector<bool> linear = linear_layers(nominal_);
            seconds = axisymmetric_seconds(
                unknowns, std::all_of(linear.begin(), linear.end(), [](bool is_linear) { return is_linear; }), steps);
            share = axisymmetric_derivative;
        }
        cost.seconds += seconds;
        cost.derivative += share * seconds;
    }
    return cost;
}

Outcome<Fields> ForwardModel::fields(const Case& values, int load) const {
    const Case c = with_effects(values, load);
    if (const std::string why = why_impossible(c, load); !why.empty()) {
        return Failure{Status::invalid_parameters, why};
    }
    const auto& own = models_[static_cast<std::size_t>(load)];
    const auto made = own ? nullptr : make_load_model(with_effects(nominal_, load), load);
    const LoadModel& model = own ? *own : *made;
    return model.fields(c, materials_of(c), *model.make_workspace());
}

struct ForwardModel::Observed {
    struct Moved {
        std::size_t parameter, row; // of the jacobian
        Sensor sensor;
        double weight; // of its reading in the derivative
    };
    std::vector<std::vector<Moved>> moved; // of each load

    // Adds a parameter that moves nothing but the sensors of a load. False: it changes more.
    bool add(const Case& values, const Parameter& parameter, std::size_t index, int load) {
        const double step = step_of(values, parameter);
        const Case here = with_effects(values, load);
        std::vector<Moved> list;
        for (const auto& [offset, weight] : stencil_of(values, parameter)) {
            const Case there = with_effects(moved_by(values, parameter, offset * step), load);
            if (!differ_in_sensors_alone(here, there, load)) {
                return false;
            }
            for (std::size_t i = 0; i < there.sensors.size(); ++i) {
                if (there.sensors[i].load == load) {
                    list.push_back({index, i, there.sensors[i], weight / step});
                }
            }
        }
        auto& own = moved[static_cast<std::size_t>(load)];
        own.insert(own.end(), list.begin(), list.end());
        return true;
    }
};

Outcome<Response> ForwardModel::run(const Case& values, const std::vector<Parameter>& parameters,
                                    Workspace& workspace) const {
    Observed observed;
    observed.moved.resize(models_.size());
    std::vector<std::vector<bool>> different; // of each parameter: the loads to run again for it
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        different.emplace_back(models_.size(), false);
        for (std::size_t l = 0; l < models_.size(); ++l) {
            const auto load = static_cast<int>(l);
            different[k][l] = models_[l] && !exact_derivative(values, parameters[k], load) &&
                              !observed.add(values, parameters[k], k, load);
        }
        for (std::size_t l = 0; l < models_.size(); ++l) {
            different[k][l] = different[k][static_cast<std::size_t>(path_of_[l])];
        }
    }
    Outcome<Response> outcome = run_exact(values, parameters, {}, observed, workspace);
    if (!outcome) {
        return outcome;
    }
    Response response = std::move(outcome).value();
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        const std::vector<bool>& loads = different[k];
        if (std::none_of(loads.begin(), loads.end(), [](bool again) { return again; })) {
            continue;
        }
        const auto quotient = difference_quotient(values, response, parameters[k], loads, workspace);
        if (!quotient) {
            return quotient.failure();
        }
        for (std::size_t i = 0; i < values.sensors.size(); ++i) {
            if (loads[static_cast<std::size_t>(values.sensors[i].load)]) {
                const auto row = static_cast<Eigen::Index>(i);
                response.jacobian(row, static_cast<Eigen::Index>(k)) = (*quotient)[row];
            }
        }
    }
    return response;
}

Outcome<Eigen::VectorXd> ForwardModel::difference_quotient(const Case& values, const Response& response,
                                                           const Parameter& parameter, const std::vector<bool>& loads,
                                                           Workspace& workspace) const {
    const double step = step_of(values, parameter);
    Eigen::VectorXd quotient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(response.values.size()));
    for (const auto& [offset, weight] : stencil_of(values, parameter)) {
        std::vector<double> there = response.values;
        if (offset != 0) {
            const auto outcome = run_exact(moved_by(values, parameter, offset * step), {}, loads, {}, workspace);
            if (!outcome) {
                return outcome.failure();
            }
            there = outcome->values;
        }
        quotient += weight * Eigen::Map<const Eigen::VectorXd>(there.data(), quotient.size());
    }
    return Eigen::VectorXd(quotient / step);
}

Outcome<Response> ForwardModel::run_exact(const Case& values, const std::vector<Parameter>& parameters,
                                          const std::vector<bool>& loads, const Observed& observed,
                                          Workspace& workspace) const {
    const auto n = static_cast<Eigen::Index>(parameters.size());

    Response response;
    response.values.assign(values.sensors.size(), std::numeric_limits<double>::quiet_NaN());
    response.jacobian = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.sensors.size()), n);
    double tension = 0.0;
    double unstable = 0.0;
    double limited = 0.0;
    bool wall_is_near = false;
    double time_error = 0.0;
    double kept = 0.0;
    for (std::size_t l = 0; l < values.loads.size(); ++l) {
        if (!models_[l] || (!loads.empty() && !loads[l])) {
            continue;
        }
        auto& own = workspace.of_load[l];
        if (!own) {
            own = models_[l]->make_workspace(workspace.lent);
        }
        const auto load = static_cast<int>(l);
        Case c = with_effects(values, load);
        const std::size_t sensors = c.sensors.size();
        static const std::vector<Observed::Moved> none;
        const auto& moved = observed.moved.empty() ? none : observed.moved[l];
        for (const auto& m : moved) {
            c.sensors.push_back(m.sensor);
        }
        if (const std::string why = why_impossible(c, load); !why.empty()) {
            return Failure{Status::invalid_parameters, why};
        }
        for (const Sensor& sensor : c.sensors) {
            if (is_below(sensor, models_[l]->reach(c))) {
                return Failure{Status::failed,
                               fmt::format("a sensor at {:g} mm depth lies below the {} of this section",
                                           sensor.depth / unit::mm, c.half_space ? "mesh" : "floor")};
            }
        }
        const auto layers = materials_of(c);
        // Derivatives this load knows: each variation once, and who is made of it.
        std::vector<fe::Variation> variations;
        std::vector<Neighbours> motions;
        std::vector<Derivative> derivatives;
        std::vector<std::vector<std::pair<Eigen::Index, double>>> shares; // of each parameter: variation, factor
        for (const Parameter& p : parameters) {
            derivatives.push_back(exact_derivative(values, p, load).value_or(Derivative{}));
            auto& share = shares.emplace_back();
            for (auto& [variation, factor] : derivatives.back().terms) {
                if (variation.kind == fe::Variation::Kind::motion) {
                    variation.index = motions.size();
                    motions.push_back(neighbours(values, p, load));
                }
                const auto known =
                    std::find_if(variations.begin(), variations.end(), [&, &v = variation](const auto& k) {
                        return k.kind == v.kind && k.layer == v.layer && k.index == v.index;
                    });
                share.emplace_back(known - variations.begin(), factor);
                if (known == variations.end()) {
                    variations.push_back(variation);
                }
            }
        }
        const auto reading = models_[l]->run(c, layers, variations, motions, *own);
        if (!reading) {
            return Failure{reading.status(), "load \"" + c.loads[l].name + "\": " + reading.failure().reason};
        }
        for (std::size_t m = 0; m < moved.size(); ++m) {
            response.jacobian(static_cast<Eigen::Index>(moved[m].row), static_cast<Eigen::Index>(moved[m].parameter)) +=
                moved[m].weight * moved[m].sensor.gain * reading->values[sensors + m];
        }
        for (std::size_t i = 0; i < sensors; ++i) {
            if (path_of_[static_cast<std::size_t>(c.sensors[i].load)] != load) {
                continue;
            }
            const auto row = static_cast<Eigen::Index>(i);
            const double gain = c.sensors[i].gain;
            response.values[i] = gain * reading->values[i];
            if (!reading->errors.empty()) {
                response.errors.resize(sensors, 0.0);
                response.errors[i] = std::abs(gain) * reading->errors[i];
            }
            for (std::size_t k = 0; k < parameters.size(); ++k) {
                double& d = response.jacobian(row, static_cast<Eigen::Index>(k));
                for (const auto& [variation, factor] : shares[k]) {
                    d += gain * factor * reading->derivatives(row, variation);
                }
                if (!derivatives[k].gain_rates.empty()) {
                    d += derivatives[k].gain_rates[i] * reading->values[i];
                }
            }
        }
        const auto& s = reading->statistics;
        response.statistics.load_steps += s.load_steps;
        response.statistics.newton_steps += s.newton_steps;
        response.statistics.factorizations += s.factorizations;
        response.statistics.iterations += s.iterations;
        response.statistics.residual_relative = std::max(response.statistics.residual_relative, s.residual_relative);
        tension = std::max(tension, s.tension_share);
        unstable = std::max(unstable, s.unstable_share);
        limited = std::max(limited, s.limited_share);
        time_error = std::max(time_error, s.time_error);
        kept = std::max(kept, s.kept_share);
        if (!wall_is_near && !c.half_space && c.settings.extent < 1.99 * c.depth()) {
            wall_is_near = true;
            response.warnings.push_back(
                fmt::format("the wall ([mesh] extent_m = {:g}) stands nearer than twice the depth of "
                            "the section ({:g} m): far deflections feel it",
                            c.settings.extent, c.depth()));
        }
    }
    response.statistics.tension_share = tension;
    response.statistics.unstable_share = unstable;
    response.statistics.limited_share = limited;
    response.statistics.time_error = time_error;
    response.statistics.kept_share = kept;
    // Shares are weighted by the energy of the load stress: what is far away and hardly loaded does not count.
    if (tension > 0.05) {
        response.warnings.push_back(percent(tension) + " of the stress-dependent material is in tension (theta < 0)");
    }
    if (unstable > 0.0) {
        response.warnings.push_back(percent(unstable) + " of the stress-dependent material stiffens as fast as it is "
                                                        "stressed: no stable secant equilibrium there");
    }
    if (time_error > 0.01) {
        response.warnings.push_back(
            fmt::format("the steps of time ([solver] time_step_ms = {:g}) are too long: readings "
                        "under a pulse err by some {:.2g} % of the largest",
                        values.settings.time_step / unit::ms, 100.0 * time_error));
    }
    if (kept > 0.1) {
        response.warnings.push_back(
            "the stress-dependent material keeps " + percent(kept) +
            " of its largest strain after the pulse, as no resilient material does: stress went back another way than "
            "it came, and moduli along its path do not cancel. Readings after the peak are not to be trusted; the law "
            "\"hyperelastic\" gives all strain back, and less is kept where more confines at rest "
            "(residual_stress_kPa, k0)");
    }
    if (limited > 0.0) {
        response.warnings.push_back("the modulus limit of 100,000 MPa was met in " + percent(limited) +
                                    " of the stress-dependent material");
    }
    return response;
}

} // namespace pave::pavement

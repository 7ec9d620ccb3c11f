#include "pavement/load_run.h"

#include "base/units.h"
#include "pavement/device.h"
#include "pavement/effects/effect.h"
#include "pavement/stencil.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace pave::pavement {
namespace {

std::string percent(double share) {
    return fmt::format("{:.0f} %", 100.0 * share);
}

// Below the floor of the case.
bool is_below(const Sensor& sensor, double depth) {
    double longest = sensor.gauge;
    for (const Sensor::Share& share : sensor.shares) {
        longest = std::max(longest, share.gauge);
    }
    return sensor.depth + longest / 2.0 > depth * (1.0 + 1e-9);
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

Outcome<LoadRun> LoadRun::prepare(const Case& values, int load, const LoadModel& model,
                                  const std::vector<Parameter>& parameters, const std::vector<MovedSensor>& moved) {
    LoadRun run;
    run.load_ = load;
    run.case_ = with_effects(values, load);
    run.moved_ = moved;
    Case& c = run.case_;
    run.sensors_ = c.sensors.size();
    for (const MovedSensor& m : moved) {
        c.sensors.push_back(m.sensor);
    }
    if (const std::string why = why_impossible(c, load); !why.empty()) {
        return Failure{Status::invalid_parameters, why};
    }
    for (const Sensor& sensor : c.sensors) {
        if (is_below(sensor, model.reach(c))) {
            return Failure{Status::failed, fmt::format("a sensor at {:g} mm depth lies below the {} of this section",
                                                       sensor.depth / unit::mm, c.half_space ? "mesh" : "floor")};
        }
    }
    run.layers_ = materials_of(c);
    for (const Parameter& p : parameters) {
        run.derivatives_.push_back(exact_derivative(values, p, load).value_or(Derivative{}));
        auto& share = run.shares_.emplace_back();
        for (auto& [variation, factor] : run.derivatives_.back().terms) {
            if (variation.kind == fe::Variation::Kind::motion) {
                variation.index = run.motions_.size();
                run.motions_.push_back(neighbours(values, p, load));
            }
            const auto known =
                std::find_if(run.variations_.begin(), run.variations_.end(), [&, &v = variation](const auto& k) {
                    return k.kind == v.kind && k.layer == v.layer && k.index == v.index;
                });
            share.emplace_back(known - run.variations_.begin(), factor);
            if (known == run.variations_.end()) {
                run.variations_.push_back(variation);
            }
        }
    }
    return run;
}

Outcome<LoadModel::Reading> LoadRun::read(const LoadModel& model, LoadModel::Workspace& workspace) const {
    return model.run(case_, layers_, variations_, motions_, workspace);
}

Failure LoadRun::named(const Failure& failure) const {
    return {failure.status, "load \"" + case_.loads[static_cast<std::size_t>(load_)].name + "\": " + failure.reason};
}

void LoadRun::add(const LoadModel::Reading& reading, const std::vector<int>& path_of, Response& response) const {
    for (std::size_t m = 0; m < moved_.size(); ++m) {
        response.jacobian(static_cast<Eigen::Index>(moved_[m].row), static_cast<Eigen::Index>(moved_[m].parameter)) +=
            moved_[m].weight * moved_[m].sensor.gain * reading.values[sensors_ + m];
    }
    for (std::size_t i = 0; i < sensors_; ++i) {
        const Sensor& sensor = case_.sensors[i];
        if (path_of[static_cast<std::size_t>(sensor.load)] != load_) {
            continue;
        }
        const auto row = static_cast<Eigen::Index>(i);
        response.values[i] = sensor.gain * reading.values[i];
        if (!reading.errors.empty()) {
            response.errors.resize(sensors_, 0.0);
            response.errors[i] = std::abs(sensor.gain) * reading.errors[i];
        }
        for (std::size_t k = 0; k < shares_.size(); ++k) {
            double& d = response.jacobian(row, static_cast<Eigen::Index>(k));
            for (const auto& [variation, factor] : shares_[k]) {
                d += sensor.gain * factor * reading.derivatives(row, variation);
            }
            if (!derivatives_[k].gain_rates.empty()) {
                d += derivatives_[k].gain_rates[i] * reading.values[i];
            }
        }
    }
    const fe::Statistics& s = reading.statistics;
    fe::Statistics& sum = response.statistics;
    sum.load_steps += s.load_steps;
    sum.newton_steps += s.newton_steps;
    sum.factorizations += s.factorizations;
    sum.iterations += s.iterations;
    for (double fe::Statistics::*largest :
         {&fe::Statistics::residual_relative, &fe::Statistics::tension_share, &fe::Statistics::unstable_share,
          &fe::Statistics::limited_share, &fe::Statistics::indefinite_share, &fe::Statistics::time_error,
          &fe::Statistics::kept_share}) {
        sum.*largest = std::max(sum.*largest, s.*largest);
    }
    if (response.warnings.empty() && !case_.half_space && case_.settings.extent < 1.99 * case_.depth()) {
        response.warnings.push_back(
            fmt::format("the wall ([mesh] extent_m = {:g}) stands nearer than twice the depth of "
                        "the section ({:g} m): far deflections feel it",
                        case_.settings.extent, case_.depth()));
    }
}

Response empty_response(const Case& values, std::size_t parameters) {
    Response response;
    response.values.assign(values.sensors.size(), std::numeric_limits<double>::quiet_NaN());
    response.jacobian =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(values.sensors.size()), static_cast<Eigen::Index>(parameters));
    return response;
}

void add_warnings(const Case& values, Response& response) {
    const fe::Statistics& s = response.statistics;
    // Shares are weighted by the energy of the load stress: what is far away and hardly loaded does not count.
    if (s.tension_share > 0.05) {
        response.warnings.push_back(percent(s.tension_share) +
                                    " of the stress-dependent material is in tension (theta < 0)");
    }
    if (s.unstable_share > 0.0) {
        response.warnings.push_back(percent(s.unstable_share) +
                                    " of the stress-dependent material stiffens as fast as it is "
                                    "stressed: no stable secant equilibrium there");
    }
    if (s.indefinite_share > 0.5) {
        response.warnings.push_back(
            "this secant equilibrium need not be the only one: in " + percent(s.indefinite_share) +
            " of the stress-dependent material stress falls with some strain, so that readings may jump with the mesh "
            "or a parameter; integration = \"incremental\" has one answer");
    }
    if (s.time_error > 0.01) {
        response.warnings.push_back(
            fmt::format("the steps of time ([solver] time_step_ms = {:g}) are too long: readings "
                        "under a pulse err by some {:.2g} % of the largest",
                        values.settings.time_step / unit::ms, 100.0 * s.time_error));
    }
    if (s.kept_share > 0.1) {
        response.warnings.push_back(
            "the stress-dependent material keeps " + percent(s.kept_share) +
            " of its largest strain after the pulse, as no resilient material does: stress went back another way than "
            "it came, and moduli along its path do not cancel. Readings after the peak are not to be trusted; the law "
            "\"hyperelastic\" gives all strain back, and less is kept where more confines at rest "
            "(residual_stress_kPa, k0)");
    }
    if (s.limited_share > 0.0) {
        response.warnings.push_back("the modulus limit of 100,000 MPa was met in " + percent(s.limited_share) +
                                    " of the stress-dependent material");
    }
}

} // namespace pave::pavement

#include "pavement/forward.h"

#include "base/error.h"
#include "base/units.h"
#include "pavement/device.h"
#include "pavement/effects/effect.h"
#include "pavement/load_model.h"
#include "pavement/load_run.h"
#include "pavement/pulse.h"
#include "pavement/solid_cost.h"
#include "pavement/stencil.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <set>

namespace pave::pavement {

class ForwardModel::Workspace {
public:
    explicit Workspace(std::size_t loads) : of_load_(loads) {}

    // That of a load, made when first needed.
    LoadModel::Workspace& of(std::size_t load, const LoadModel& model) {
        if (!of_load_[load]) {
            of_load_[load] = model.make_workspace(lent_);
        }
        return *of_load_[load];
    }

private:
    std::vector<std::unique_ptr<LoadModel::Workspace>> of_load_;
    LoadModel::Lent lent_;
};

void ForwardModel::WorkspaceDeleter::operator()(Workspace* workspace) const {
    delete workspace;
}

ForwardModel::WorkspacePointer ForwardModel::make_workspace() const {
    return WorkspacePointer(new Workspace(nominal_.loads.size()));
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

struct ForwardModel::Plan {
    std::vector<std::vector<MovedSensor>> moved; // of each load
    std::vector<std::vector<bool>> different;    // of each parameter: the loads to run again for it
    bool runs_again() const {
        return std::any_of(different.begin(), different.end(), [](const auto& loads) {
            return std::any_of(loads.begin(), loads.end(), [](bool again) { return again; });
        });
    }

    // Adds a parameter that moves nothing but the sensors of a load. False: it changes more.
    bool add(const Case& values, const Parameter& parameter, std::size_t index, int load) {
        const double step = step_of(values, parameter);
        const Case here = with_effects(values, load);
        std::vector<MovedSensor> list;
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

ForwardModel::Plan ForwardModel::plan(const Case& values, const std::vector<Parameter>& parameters) const {
    Plan plan;
    plan.moved.resize(models_.size());
    auto& different = plan.different;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        different.emplace_back(models_.size(), false);
        for (std::size_t l = 0; l < models_.size(); ++l) {
            const auto load = static_cast<int>(l);
            different[k][l] = models_[l] && !exact_derivative(values, parameters[k], load) &&
                              !plan.add(values, parameters[k], k, load);
        }
        for (std::size_t l = 0; l < models_.size(); ++l) {
            different[k][l] = different[k][static_cast<std::size_t>(path_of_[l])];
        }
    }
    return plan;
}

Outcome<Response> ForwardModel::run(const Case& values, const std::vector<Parameter>& parameters,
                                    Workspace& workspace) const {
    const Plan derivatives = plan(values, parameters);
    Outcome<Response> outcome = run_exact(values, parameters, {}, derivatives, workspace);
    if (!outcome || !derivatives.runs_again()) {
        return outcome;
    }
    Response response = std::move(outcome).value();
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        const std::vector<bool>& loads = derivatives.different[k];
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
                                          const std::vector<bool>& loads, const Plan& plan,
                                          Workspace& workspace) const {
    static const std::vector<MovedSensor> none;
    Response response = empty_response(values, parameters.size());
    for (std::size_t l = 0; l < models_.size(); ++l) {
        if (!models_[l] || (!loads.empty() && !loads[l])) {
            continue;
        }
        const auto run = LoadRun::prepare(values, static_cast<int>(l), *models_[l], parameters,
                                          plan.moved.empty() ? none : plan.moved[l]);
        if (!run) {
            return run.failure();
        }
        const auto reading = run->read(*models_[l], workspace.of(l, *models_[l]));
        if (!reading) {
            return run->named(reading.failure());
        }
        run->add(*reading, path_of_, response);
    }
    add_warnings(values, response);
    return response;
}

int ForwardModel::lanes() const {
    int lanes = 0;
    for (const auto& model : models_) {
        if (model) {
            lanes = lanes == 0 ? model->lanes() : std::min(lanes, model->lanes());
        }
    }
    return std::max(lanes, 1);
}

std::vector<Outcome<Response>> ForwardModel::run_many(std::span<const Case> values,
                                                      const std::vector<Parameter>& parameters,
                                                      Workspace& workspace) const {
    const std::size_t count = values.size();
    std::vector<Plan> plans;
    std::vector<Response> responses;
    std::vector<std::optional<Failure>> failures(count);
    for (const Case& c : values) {
        plans.push_back(plan(c, parameters));
        responses.push_back(empty_response(c, parameters.size()));
    }
    for (std::size_t l = 0; l < models_.size(); ++l) {
        if (!models_[l]) {
            continue;
        }
        std::vector<LoadRun> together;
        std::vector<std::size_t> numbers;
        const auto take = [&](std::size_t i, const LoadRun& run, const Outcome<LoadModel::Reading>& reading) {
            if (reading) {
                run.add(*reading, path_of_, responses[i]);
            } else {
                failures[i] = run.named(reading.failure());
            }
        };
        for (std::size_t i = 0; i < count; ++i) {
            if (failures[i] || plans[i].runs_again()) {
                continue;
            }
            auto run = LoadRun::prepare(values[i], static_cast<int>(l), *models_[l], parameters, plans[i].moved[l]);
            if (!run) {
                failures[i] = run.failure();
            } else if (run->goes_with_others(*models_[l])) {
                together.push_back(std::move(run).value());
                numbers.push_back(i);
            } else {
                take(i, *run, run->read(*models_[l], workspace.of(l, *models_[l])));
            }
        }
        std::vector<LoadModel::Run> runs;
        for (const LoadRun& run : together) {
            runs.push_back(run.run());
        }
        const auto readings = models_[l]->run_together(runs, workspace.of(l, *models_[l]));
        for (std::size_t r = 0; r < runs.size(); ++r) {
            take(numbers[r], together[r], readings[r]);
        }
    }
    std::vector<Outcome<Response>> outcomes;
    for (std::size_t i = 0; i < count; ++i) {
        if (failures[i]) {
            outcomes.emplace_back(std::move(*failures[i]));
        } else if (plans[i].runs_again()) {
            outcomes.push_back(run(values[i], parameters, workspace));
        } else {
            add_warnings(values[i], responses[i]);
            outcomes.emplace_back(std::move(responses[i]));
        }
    }
    return outcomes;
}

} // namespace pave::pavement

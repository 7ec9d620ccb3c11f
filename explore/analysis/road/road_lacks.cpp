#include "analysis/road/road_lacks.h"

#include "base/units.h"
#include "pavement/effects/effect.h"
#include "pavement/layered.h"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <map>

namespace explore::analysis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Each run of it is a march in time.
const std::vector<std::string> without = {"inertia"};

double x_mm(const study::Study& study, int reading) {
    return study.readings[static_cast<std::size_t>(reading)].x_mm;
}

// Effects of one member, whose sizes are free in one run.
struct Together {
    std::size_t member = 0;
    std::vector<study::Variant> variants;
};

// Where all is linear, one effect that is not would make the runs for all the others as slow as its own.
std::vector<std::vector<study::Variant>> groups_of(const study::Study& study) {
    bool is_linear = true;
    for (std::size_t load = 0; load < study.model.loads.size(); ++load) {
        is_linear = is_linear && pave::pavement::why_not_layered(study.model, static_cast<int>(load)).empty();
    }
    std::vector<std::vector<study::Variant>> groups;
    for (study::Variant& variant : effects_of_road(study)) {
        if (!variant.applied.reading) {
            if (groups.empty() || is_linear) {
                groups.emplace_back();
            }
            groups.back().push_back(std::move(variant));
        }
    }
    return groups;
}

// Of the residuals of task t, a member with effects of free size; empty where there is no answer.
std::vector<VectorXd> changes_by(RoadStations& stations, std::size_t t, const problem::Problem& problem,
                                 const RoadPoint& point, const Together& own) {
    std::vector<VectorXd> changes;
    std::vector<double> unit = point.unit;
    for (const study::Variant& variant : own.variants) {
        unit.push_back(study::size_axis(*variant.applied.effect).unit(variant.applied.effect->null));
    }
    const auto here = stations.search(t, unit, {}, 0);
    if (!here || !here->evaluation.converged()) {
        return changes;
    }
    const MatrixXd slopes = problem.residual_jacobian(here->evaluation);
    const VectorXd residuals = problem.residuals(here->evaluation);
    for (std::size_t v = 0; v < own.variants.size(); ++v) {
        const auto& effect = *own.variants[v].applied.effect;
        const std::size_t at = point.unit.size() + v;
        VectorXd change = slopes.col(static_cast<Index>(at));
        constexpr double nothing = 1e-9; // no slope at none: the size counts by its square, or by its step
        if (change.allFinite() && change.norm() < nothing) {
            std::vector<double> there = unit;
            there[at] = study::size_axis(effect).unit(own.variants[v].typical.value_or(effect.typical));
            const auto away = stations.search(t, there, {}, 1 + static_cast<int>(v));
            if (away && away->evaluation.converged()) {
                change = (problem.residuals(away->evaluation) - residuals) / (there[at] - unit[at]);
            }
        }
        changes.push_back(std::move(change));
    }
    return changes;
}

// Of the residuals of every member by the size of every effect, at none. Nothing: interrupted.
std::optional<std::vector<Lack>> effects(Session& session, const RoadState& state, const ProblemOfStation& problem_of) {
    std::vector<Lack> lacks;
    std::vector<Together> list;
    std::vector<StationTask> tasks;
    std::vector<int> runs;
    std::map<std::string, std::size_t> places;
    for (std::size_t m = 0; m < state.members.size(); ++m) {
        const StationTask& task = state.tasks[state.members[m]];
        for (auto& variants : groups_of(task.study)) {
            tasks.push_back(with_effects(task, variants, problem_of));
            runs.push_back(session.begin(tasks.back().study, "road-effects", tasks.back().words()));
            for (const study::Variant& variant : variants) {
                if (places.try_emplace(key_of(variant, task.study), lacks.size()).second) {
                    const auto& effect = *variant.applied.effect;
                    lacks.push_back({.variant = variant,
                                     .sense = effect.null <= effect.low    ? 1
                                              : effect.null >= effect.high ? -1
                                                                           : 0,
                                     .change = std::vector<VectorXd>(state.members.size())});
                }
            }
            list.push_back({m, std::move(variants)});
        }
    }
    const RoadLayout layout; // nothing is searched
    RoadStations stations(session, tasks, runs, layout);
    const bool finished = stations.for_each(list.size(), [&](std::size_t t) {
        const Together& own = list[t];
        const std::size_t i = state.members[own.member];
        const std::vector<VectorXd> changes = changes_by(stations, t, tasks[t].problem, state.points[i], own);
        for (std::size_t v = 0; v < changes.size(); ++v) {
            if (changes[v].allFinite()) {
                lacks[places.at(key_of(own.variants[v], state.tasks[i].study))].change[own.member] = changes[v];
            }
        }
    });
    return finished ? std::optional(std::move(lacks)) : std::nullopt;
}

// Of the residuals by the places of sensors: all stand a little farther out, which changes nothing but what each
// reads itself. Nothing: interrupted.
std::optional<std::vector<Lack>> moved_sensors(Session& session, const RoadState& state,
                                               const ProblemOfStation& problem_of) {
    constexpr double step_mm = 1.0;
    std::vector<StationTask> tasks;
    std::vector<int> runs;
    std::vector<std::map<double, Lack>> found(state.members.size());
    for (const std::size_t i : state.members) {
        tasks.push_back(state.tasks[i]);
        StationTask& moved = tasks.back();
        for (auto& sensor : moved.study.model.sensors) {
            sensor.x += step_mm * pave::unit::mm;
        }
        moved.study.hash += " sensors moved";
        moved.problem = problem_of(moved.study);
        runs.push_back(session.begin(moved.study, "road-sensors", moved.words()));
    }
    const RoadLayout layout; // nothing is searched
    RoadStations stations(session, tasks, runs, layout);
    const bool finished = stations.for_each(state.members.size(), [&](std::size_t m) {
        const StationTask& task = state.tasks[state.members[m]];
        const RoadPoint& point = state.points[state.members[m]];
        const auto there = stations.search(m, point.unit, {}, 0);
        if (!there || !there->evaluation.converged()) {
            return;
        }
        const VectorXd by_step =
            task.problem.standard_residuals(there->evaluation) - task.problem.standard_residuals(point.evaluation);
        for (const study::Variant& variant : effects_of_road(task.study)) {
            const auto& effect = *variant.applied.effect;
            if (!variant.applied.reading || effect.takes_quantity) { // gains are found without a run
                continue;
            }
            const double offset = x_mm(task.study, *variant.applied.reading);
            Lack& lack = found[m][offset];
            lack.variant = variant;
            lack.offset_mm = offset;
            VectorXd change = VectorXd::Zero(static_cast<Index>(task.problem.rows()));
            for (std::size_t row = 0; row < task.problem.readings(); ++row) {
                if (x_mm(task.study, static_cast<int>(task.problem.response_of(row))) == offset) {
                    change += by_step[static_cast<Index>(row)] / step_mm * (effect.high - effect.low) *
                              task.problem.change_by(row);
                }
            }
            lack.change = {std::move(change)};
        }
    });
    std::map<double, Lack> all;
    for (std::size_t m = 0; m < state.members.size(); ++m) {
        for (auto& [offset, lack] : found[m]) {
            VectorXd change = std::move(lack.change[0]);
            Lack& of_road = all.try_emplace(offset, std::move(lack)).first->second;
            of_road.change.resize(state.members.size());
            of_road.change[m] = std::move(change);
        }
    }
    std::vector<Lack> lacks;
    for (auto& [offset, lack] : all) {
        lacks.push_back(std::move(lack));
    }
    return finished ? std::optional(std::move(lacks)) : std::nullopt;
}

// A sensor that reads a share too much everywhere.
std::vector<Lack> gains_of_sensors(const RoadState& state) {
    std::map<double, Lack> sensors;
    for (std::size_t m = 0; m < state.members.size(); ++m) {
        const StationTask& task = state.tasks[state.members[m]];
        std::size_t row = 0; // readings stand in the order of the bowls
        for (const auto* bowl : task.bowls()) {
            for (const auto& reading : bowl->readings) {
                Lack& lack = sensors[reading.offset_mm];
                lack.offset_mm = reading.offset_mm;
                lack.change.resize(state.members.size());
                VectorXd& change = lack.change[m];
                const VectorXd by_reading = task.problem.change_by_gain(row, state.points[state.members[m]].evaluation);
                change = change.size() > 0 ? VectorXd(change + by_reading) : by_reading;
                ++row;
            }
        }
    }
    std::vector<Lack> lacks;
    for (auto& [offset, lack] : sensors) {
        lacks.push_back(std::move(lack));
    }
    return lacks;
}

} // namespace

std::string key_of(const study::Variant& variant, const study::Study& study) {
    std::string key(variant.applied.effect->name);
    if (variant.applied.reading) {
        key += fmt::format(" {}", x_mm(study, *variant.applied.reading));
    }
    return variant.applied.offsets.empty() ? key : key + " " + variant.on;
}

std::vector<study::Variant> effects_of_road(const study::Study& study) {
    auto variants = study::variants(study, without, true);
    std::erase_if(variants, [](const study::Variant& variant) {
        const auto& applied = variant.applied;
        return applied.load || applied.quantity || applied.effect->is_error_of_reading;
    });
    return variants;
}

StationTask with_effects(const StationTask& task, const std::vector<study::Variant>& variants,
                         const ProblemOfStation& problem_of) {
    StationTask extended = task;
    extended.study = study::with_free_effects(task.study, variants);
    for (std::size_t k = task.study.space.axes.size(); k < extended.study.space.axes.size(); ++k) {
        extended.study.space.axes[k].level = problem::Level::shared;
    }
    extended.problem = problem_of(extended.study);
    return extended;
}

std::optional<std::vector<Lack>> lacks_of_road(Session& session, const RoadState& state,
                                               const ProblemOfStation& problem_of) {
    auto lacks = effects(session, state, problem_of);
    auto moved = lacks ? moved_sensors(session, state, problem_of) : std::nullopt;
    if (!moved) {
        return std::nullopt;
    }
    std::vector<Lack> gains = gains_of_sensors(state);
    std::move(moved->begin(), moved->end(), std::back_inserter(*lacks));
    std::move(gains.begin(), gains.end(), std::back_inserter(*lacks));
    return lacks;
}

} // namespace explore::analysis

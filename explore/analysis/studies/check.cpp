#include "analysis/studies/check.h"

#include "analysis/common/data_faults.h"
#include "analysis/common/feasible.h"
#include "analysis/common/layout.h"
#include "analysis/common/mesh_error.h"
#include "analysis/compare/compare.h"
#include "analysis/diagnose/diagnose.h"
#include "analysis/fit/fit.h"
#include "analysis/sample/sensitivity.h"
#include "analysis/unique/map.h"
#include "base/text.h"
#include "base/units.h"
#include "landscape/uniqueness.h"
#include "material/catalog.h"
#include "pavement/effects/effect.h"
#include "pavement/forward.h"
#include "run/parallel.h"
#include "study/laws.h"
#include "study/variants.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

// Of the processor: other work on the machine is not this study's.
double processor_seconds() {
    return 1e-9 * static_cast<double>(run::thread_cpu_ns());
}

// Seconds of a run at the study's own values.
struct RunTimes {
    double forward = 0.0;
    double with_derivatives = 0.0; // 0: nothing to differentiate by
    double fitted_forward = 0.0;   // of the loads that are fitted
    double fitted_with_derivatives = 0.0;
    double diagnosed_forward = 0.0; // the same on the coarse mesh with an effect, as diagnose computes most
    double diagnosed_with_derivatives = 0.0;
};

// The median, after a run that makes the buffers.
pave::Outcome<double> seconds_of(const pave::pavement::ForwardModel& model,
                                 const std::vector<pave::pavement::Parameter>& parameters) {
    const auto workspace = model.make_workspace();
    constexpr int rounds = 4;
    std::vector<double> times;
    for (int round = 0; round < rounds; ++round) {
        const double begin = processor_seconds();
        const auto outcome = model.run(model.nominal(), parameters, *workspace);
        if (!outcome) {
            return outcome.failure();
        }
        const double elapsed = processor_seconds() - begin;
        constexpr double slow = 5.0; // s: then once is enough, and buffers do not matter
        if (round > 0 || elapsed > slow) {
            times.push_back(elapsed);
        }
        if (elapsed > slow) {
            break;
        }
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// Linear layers cost nothing beside the effects, by finite elements, that diagnose adds to them: the mean over variants
// at the sizes seen in practice, as many as two seconds allow and one at least.
void measure_variants(const study::Study& diagnosed, const std::vector<bool>& fitted, RunTimes& timing) {
    double forward = 0.0;
    double with_derivatives = 0.0;
    int count = 0;
    const double begin = processor_seconds();
    for (const study::Variant& variant : study::variants(diagnosed, {})) {
        study::Study extended = study::with_free_effects(diagnosed, {variant});
        extended.model.effects.back().size = variant.applied.effect->typical;
        const pave::pavement::ForwardModel model(extended.model, fitted);
        const auto plain = seconds_of(model, {});
        const auto differentiated = plain ? seconds_of(model, extended.parameters) : plain;
        if (differentiated) {
            forward += *plain;
            with_derivatives += *differentiated;
            ++count;
        }
        constexpr double enough = 2.0; // s
        if (count > 0 && processor_seconds() - begin > enough) {
            break;
        }
    }
    if (count > 0) {
        timing.diagnosed_forward = forward / count;
        timing.diagnosed_with_derivatives = with_derivatives / count;
    }
}

pave::Outcome<RunTimes> measure(const study::Study& study) {
    std::optional<pave::Failure> failure;
    const auto seconds = [&](const pave::pavement::ForwardModel& model,
                             const std::vector<pave::pavement::Parameter>& parameters) {
        const auto found = failure ? pave::Outcome<double>(*failure) : seconds_of(model, parameters);
        if (!found) {
            failure = found.failure();
        }
        return found ? *found : 0.0;
    };
    const pave::pavement::ForwardModel model(study.model);
    RunTimes timing;
    timing.forward = seconds(model, {});
    if (!study.parameters.empty()) {
        timing.with_derivatives = seconds(model, study.parameters);
        const std::vector<bool> fitted = study::fitted_loads(study);
        const auto count = std::count(fitted.begin(), fitted.end(), true);
        timing.fitted_forward = timing.forward;
        timing.fitted_with_derivatives = timing.with_derivatives;
        if (count > 0 && count < static_cast<std::ptrdiff_t>(fitted.size())) {
            const pave::pavement::ForwardModel of_fit(study.model, fitted);
            timing.fitted_forward = seconds(of_fit, {});
            timing.fitted_with_derivatives = seconds(of_fit, study.parameters);
        }
        const study::Study diagnosed = on_coarser_mesh(as_diagnosed(study));
        const pave::pavement::ForwardModel coarse(diagnosed.model, fitted);
        timing.diagnosed_forward = seconds(coarse, {});
        timing.diagnosed_with_derivatives = seconds(coarse, diagnosed.parameters);
        if (!failure && count > 0 && study::stress_dependent_layers(study).empty()) {
            measure_variants(diagnosed, fitted, timing);
        }
    }
    if (failure) {
        return *failure;
    }
    return timing;
}

// The time of one run; nothing without one.
pave::Outcome<std::vector<Estimate>> check_own_model(const study::Study& study, Timing by) {
    if (by == Timing::sizes) {
        return std::vector<Estimate>{};
    }
    const problem::Problem problem = study::make_prediction_problem(study);
    const auto begin = std::chrono::steady_clock::now();
    const auto outcome =
        problem.function->evaluate(study.model.corrections[0].factors, false, *problem.function->make_workspace());
    if (!outcome) {
        return outcome.failure();
    }
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    return std::vector<Estimate>{{"forward", "1", passed.count()}};
}

RunTimes foreseen(const study::Study& study) {
    using pave::pavement::ForwardModel;
    const auto times_of = [](const study::Study& s, const std::vector<bool>& loads, double& plain,
                             double& differentiated) {
        const ForwardModel::Cost cost = ForwardModel(s.model, loads).cost();
        plain = cost.seconds;
        differentiated = cost.seconds + cost.derivative * static_cast<double>(s.parameters.size());
    };
    RunTimes timing;
    times_of(study, {}, timing.forward, timing.with_derivatives);
    if (!study.parameters.empty()) {
        const std::vector<bool> fitted = study::fitted_loads(study);
        times_of(study, fitted, timing.fitted_forward, timing.fitted_with_derivatives);
        study::Study diagnosed = on_coarser_mesh(as_diagnosed(study));
        diagnosed.model.settings.layered = false; // effects are added to finite elements
        times_of(diagnosed, fitted, timing.diagnosed_forward, timing.diagnosed_with_derivatives);
    }
    return timing;
}

std::vector<Estimate> estimates(const study::Study& study, const RunTimes& timing, int threads) {
    std::vector<Estimate> list{{"forward", "1", timing.forward}};
    if (study.parameters.empty()) {
        return list;
    }
    list.push_back({"forward --jacobian", "1 with derivatives", timing.with_derivatives});
    if (study.groups_fitted().empty()) {
        return list;
    }
    const auto shared = [&](double work) { return work / threads; };
    const auto grid = search::full_grid_size(study.space);
    const bool is_grid = grid > 0 && grid <= search::most_grid_points;
    const auto points = static_cast<double>(is_grid ? grid : map_points);
    list.push_back(
        {grid > 0 && !is_grid ? "map --design sobol" : "map",
         fmt::format("{:.0f}{}", points,
                     is_grid    ? " (full grid)"
                     : grid > 0 ? " (the grid has too many points)"
                                : ""),
         shared(points * timing.fitted_forward + (has_more_to_predict(study) ? map_lowest * timing.forward : 0.0))});
    // Runs of the searches and walks below were counted on studies of two to five parameters; they vary twofold.
    constexpr int steps = 15; // of a search, on a deflection bowl
    const double with = timing.fitted_with_derivatives;
    const int starts = landscape::MultistartSettings{}.starts;
    list.push_back({"fit", fmt::format("{}, then {} with derivatives", fit_points, starts * steps),
                    shared(fit_points * timing.fitted_forward + starts * steps * with)});
    const auto count = static_cast<int>(study.space.axes.size());
    const landscape::UniquenessSettings settings;
    const int searches = settings.verify + 2 * count;
    constexpr int walk = 30; // runs from the best fit to one end of a range
    const auto outputs = static_cast<int>(study.outputs().size());
    // Outputs that cost more are interpolated between a few runs while their ranges are walked.
    constexpr int interpolated = 8;
    const bool cost_more = outputs_cost_more(study);
    const int of_outputs = cost_more ? interpolated : 2 * walk * outputs;
    const int of_fitted = settings.explore + steps * searches + 2 * walk * (count + (cost_more ? outputs : 0));
    const double unique = of_fitted * with + of_outputs * timing.with_derivatives;
    list.push_back({"unique", fmt::format("{} with derivatives", of_fitted + of_outputs), shared(unique)});
    const auto candidates = static_cast<int>(study::variants(as_diagnosed(study), {}).size());
    constexpr int screening = 5; // runs of a variant
    constexpr int fitted = 30;   // variants at most, where there are many readings
    constexpr int single = 9;    // runs with derivatives of a fit
    constexpr int further = 1000;
    constexpr int own = 60; // with derivatives, on the study's own mesh
    list.push_back(
        {"diagnose",
         fmt::format("{} coarse, {} with derivatives", screening * candidates,
                     further + single * std::min(candidates, fitted) + own),
         shared(screening * candidates * timing.diagnosed_forward + further * timing.diagnosed_with_derivatives +
                single * std::min(candidates, fitted) * timing.diagnosed_with_derivatives + own * with)});
    const SensitivityOptions sensitivity;
    const int runs = sensitivity.samples * (count + 2) + sensitivity.points * count;
    list.push_back({"sensitivity", fmt::format("{}", runs), shared(runs * timing.forward)});
    if (study::stress_dependent_layers(study).size() == 1) {
        const std::size_t laws = pave::material::laws().size();
        list.push_back(
            {"compare", fmt::format("{} times those of unique", laws), shared(static_cast<double>(laws) * unique)});
    }
    if (study.model.loads.size() == 1 && study.model.loads[0].type == pave::pavement::LoadType::plate) {
        constexpr int station_starts = 4;
        list.push_back({"survey, a station of one drop", fmt::format("{} with derivatives", station_starts * steps),
                        shared(station_starts * steps * with)});
    }
    return list;
}

// Pressures that no load has, and times that none takes.
std::vector<std::string> doubtful_loads(const study::Study& study) {
    // Light plates press with some 50 kPa, aircraft with 1,750; a falling weight for some 30 ms.
    constexpr double lightest = 5e3;
    constexpr double heaviest = 5e6;
    constexpr double shortest = 2e-3;
    constexpr double longest = 10.0;
    std::vector<std::string> words;
    for (const auto& load : study.model.loads) {
        if (load.type != pave::pavement::LoadType::gear && !(load.pressure >= lightest && load.pressure <= heaviest)) {
            words.push_back(fmt::format("{}: load \"{}\" presses with {:.3g} kPa: no load on a pavement does; a unit?",
                                        study.file, load.name, load.pressure / pave::unit::kPa));
        }
        if (load.is_pulse()) {
            const double seconds = load.history.back().time - load.history.front().time;
            if (!(seconds >= shortest && seconds <= longest)) {
                words.push_back(fmt::format("{}: load \"{}\" acts for {:.3g} ms: milliseconds, or another unit?",
                                            study.file, load.name, 1e3 * seconds));
            }
        }
    }
    return words;
}

} // namespace

pave::Outcome<std::vector<Estimate>> check(const study::Study& study, int threads, Timing by) {
    if (!study.parameters.empty() && !study.groups_fitted().empty()) {
        study::make_problem(study);
        refuse_contradictions(study);
        study::make_noise_problem(study, study::Scope::fitted);
    }
    if (study.has_own_model) {
        return check_own_model(study, by);
    }
    if (by == Timing::sizes) {
        return estimates(study, foreseen(study), threads);
    }
    const auto timing = measure(study);
    if (!timing) {
        return timing.failure();
    }
    return estimates(study, *timing, threads);
}

std::vector<std::string> doubtful_readings(const study::Study& study) {
    using pave::pavement::Quantity;
    std::vector<std::string> words;
    if (study.has_own_model) {
        return words;
    }
    words = doubtful_loads(study);
    for (std::size_t i = 0; i < study.measured().size(); ++i) {
        const data::Reading& reading = study.readings[i];
        const double value = reading.value * reading.unit.to_si;
        double low = -10e6;
        double high = 10e6;
        switch (study.model.sensors[i].quantity) {
        case Quantity::deflection:
        case Quantity::benkelman:
            low = -2e-3;
            high = 20e-3;
            break;
        case Quantity::slope:
        case Quantity::strain_zz:
        case Quantity::strain_xx:
        case Quantity::strain_yy:
            low = -0.05;
            high = 0.05;
            break;
        default: break;
        }
        if (!(value >= low && value <= high)) {
            words.push_back(
                fmt::format("{}:{}: {} = {:g}: no pavement reads that; a sign, a unit, or a mark of what is "
                            "missing?",
                            reading.file, reading.line, reading.label_with_unit(), reading.value));
        }
    }
    for (const data::BowlFault& fault : data_faults(study)) {
        const data::Reading& first = study.readings[fault.rows[0]];
        words.push_back(fmt::format("{}:{}: {}", first.file, first.line, fault.words()));
    }
    if (const auto doubtful = doubtful_noise(study)) {
        const data::Reading& first = study.readings[doubtful->rows[0]];
        words.push_back(fmt::format("{}:{}: {}", first.file, first.line, doubtful->words));
    }
    for (const Rounding& rounding : roundings(study)) {
        words.push_back(fmt::format("{}: {}", study.file, rounding.words()));
    }
    return words;
}

} // namespace explore::analysis

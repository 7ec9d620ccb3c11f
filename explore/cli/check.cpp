// pavescape check: reads a study to the end, says what would run and how long it would take.
#include "cli/common.h"
#include "landscape/multistart.h"
#include "report/table.h"
#include "run/message.h"
#include "run/parallel.h"
#include "run/progress.h"
#include "search/design.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using report::counted;
using Clock = std::chrono::steady_clock;

// Median seconds of a run at the study's own values, after one that makes the buffers.
struct Timing {
    double forward = 0.0;
    double with_derivatives = 0.0; // 0: nothing to differentiate by
    double fitted_forward = 0.0;   // of the loads that are fitted
    double fitted_with_derivatives = 0.0;
};

pave::Outcome<Timing> measure(const study::Study& study) {
    const pave::pavement::ForwardModel model(study.model);
    std::optional<pave::Failure> failure;
    const auto seconds = [&](const pave::pavement::ForwardModel& of,
                             const std::vector<pave::pavement::Parameter>& parameters) {
        const auto workspace = of.make_workspace();
        constexpr int rounds = 4;
        std::vector<double> times;
        for (int round = 0; round < rounds && !failure; ++round) {
            const auto begin = Clock::now();
            const auto outcome = of.run(study.model, parameters, *workspace);
            if (!outcome) {
                failure = outcome.failure();
            }
            if (round > 0) {
                times.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
            }
        }
        std::sort(times.begin(), times.end());
        return times.empty() ? 0.0 : times[times.size() / 2];
    };
    Timing timing;
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
    }
    if (failure) {
        return *failure;
    }
    return timing;
}

struct Estimate {
    std::string command;
    std::string runs; // in words
    double seconds = 0.0;
};

std::vector<Estimate> estimates(const study::Study& study, const Timing& timing, int threads) {
    std::vector<Estimate> list{{"forward", "1", timing.forward}};
    if (study.parameters.empty()) {
        return list;
    }
    list.push_back({"forward --jacobian", "1 with derivatives", timing.with_derivatives});
    const bool can_fit =
        std::any_of(study.groups.begin(), study.groups.end(), [](const auto& g) { return !g.held_out; });
    if (!can_fit) {
        return list;
    }
    const auto shared = [&](double work) { return work / threads; };
    const auto grid = search::full_grid_size(study.space);
    const bool is_grid = grid > 0 && grid <= search::most_grid_points;
    const auto points = static_cast<double>(is_grid ? grid : map_points);
    list.push_back({grid > 0 && !is_grid ? "map --design sobol" : "map",
                    fmt::format("{:.0f}{}", points,
                                is_grid    ? ", the full grid"
                                : grid > 0 ? ", a Sobol sample: the full grid has too many points"
                                           : ", a Sobol sample"),
                    shared(points * timing.forward)});
    constexpr int steps = 15; // a search takes, on a deflection bowl
    const int starts = landscape::MultistartSettings{}.starts;
    list.push_back({"fit", fmt::format("{}, then {} searches of some {} with derivatives", fit_points, starts, steps),
                    shared(fit_points * timing.fitted_forward + starts * steps * timing.fitted_with_derivatives)});
    return list;
}

int check_study(const CommonOptions& options) {
    const study::Study study = study::load_study(options.study);
    const bool fits = std::any_of(study.groups.begin(), study.groups.end(), [](const auto& g) { return !g.held_out; });
    if (!study.parameters.empty() && fits) { // what every command that fits would complain of
        study::make_problem(study);
        study::make_noise_problem(study, study::Scope::fitted);
    }
    const auto timing = measure(study);
    if (!timing) {
        if (options.json) {
            fmt::print("{}\n", report::json_text({{"status", std::string(to_string(timing.status()))},
                                                  {"reason", timing.failure().reason}}));
        }
        run::message("pavescape: the study can be read, but has no answer at its own values: {}: {}\n",
                     to_string(timing.status()), timing.failure().reason);
        return computation_failed;
    }
    const int threads = run::usable_threads(options.threads);
    const auto list = estimates(study, *timing, threads);
    if (options.json) {
        report::Json commands = report::Json::array();
        for (const Estimate& e : list) {
            commands.push_back({{"command", e.command}, {"runs", e.runs}, {"seconds", e.seconds}});
        }
        report::Json groups = report::Json::array();
        for (const auto& group : study.groups) {
            groups.push_back({{"group", group.name}, {"readings", group.rows.size()}, {"held_out", group.held_out}});
        }
        fmt::print("{}\n", report::json_text({{"status", "converged"},
                                              {"readings", study.measurements.size()},
                                              {"groups", groups},
                                              {"parameters", study.parameters.size()},
                                              {"outputs", study.outputs.size()},
                                              {"threads", threads},
                                              {"commands", commands}}));
        return done;
    }
    fmt::print("{}", study_summary(study));
    if (study.measurements.empty()) {
        fmt::print("  no readings: nothing can be fitted\n");
    } else {
        fmt::print("  {}, their noise {}:\n", counted(study.measurements.size(), "reading", "readings"),
                   study.noise == study::NoiseSource::stated ? study.noise_name() : "to be estimated from the fit");
        for (const auto& group : study.groups) {
            fmt::print("    {}: {}{}\n", group.name, group.rows.size(),
                       group.held_out        ? ", held out"
                       : group.weight != 1.0 ? fmt::format(", weight {:g}", group.weight)
                                             : "");
        }
    }
    fmt::print("  {}\n\n  Time on {}, from runs made just now at the study's own values\n",
               counted(study.outputs.size(), "output", "outputs"),
               counted(static_cast<std::size_t>(threads), "thread", "threads"));
    report::Table table({"command", "runs", "time"});
    for (const Estimate& e : list) {
        table.add({e.command, e.runs,
                   e.seconds < 1.0 ? fmt::format("{:.0f} ms", 1e3 * e.seconds) : run::duration_words(e.seconds)});
    }
    fmt::print("{}", table.text());
    return done;
}

} // namespace

void add_check(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("check", "reads a study to the end; what would run, and for how long");
    auto options = std::make_shared<CommonOptions>();
    command->add_option("STUDY", options->study, "study file (TOML)")->required();
    command->add_option("--threads", options->threads, "number of threads that the times are for (default: one a core)")
        ->check(CLI::Range(1, 4096));
    command->add_flag("--json", options->json, "print one JSON object and nothing else");
    command->footer("Example: pavescape check grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return check_study(*options); }; });
}

} // namespace explore::cli

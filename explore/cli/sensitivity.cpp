// pavescape sensitivity: how much each parameter moves each response, near the study's own values and over the box.
#include "landscape/sensitivity.h"
#include "base/error.h"
#include "cli/common.h"
#include "report/table.h"
#include "run/engine.h"
#include "run/message.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace explore::cli {
namespace {

using report::figure;
using report::Json;

struct SensitivityOptions {
    CommonOptions common;
    std::vector<std::string> parameters; // empty: all of the study
    double range = 50.0;                 // percent
    int points = 11;
    int samples = 256;
};

// The response at `index` of the model's sensors, as it is reported.
struct Reported {
    std::size_t index;
    std::string name;
    std::string unit;
    double to_si;
};

struct Curve {
    std::size_t parameter;
    std::vector<problem::Evaluation> points;
};

struct Sensitivity {
    std::vector<Reported> responses;
    std::vector<double> changes; // of the parameter along a curve, percent
    problem::Evaluation own;     // at the study's own values, with jacobian
    Eigen::MatrixXd elasticity;  // responses of the model x parameters
    std::vector<Curve> curves;   // of the parameters that are not zero
    Json statuses;               // of the sample
    landscape::GlobalSensitivity global;
};

// Takes the parameters that were not asked for out of the study: they stay at its own values.
void choose_parameters(study::Study& study, const std::vector<std::string>& wanted) {
    std::vector<std::string> names;
    for (const auto& axis : study.space.axes) {
        names.push_back(axis.name);
    }
    for (const std::string& name : wanted) {
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            const std::string near = pave::nearest_name(name, names);
            throw pave::Error({.file = study.file, .key = "--parameter"},
                              "this is not a parameter of the study" +
                                  (near.empty() ? "" : ", did you mean \"" + near + "\"?"),
                              "\"" + name + "\"", pave::join(names));
        }
    }
    for (std::size_t k = names.size(); k-- > 0;) {
        if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), names[k]) == wanted.end()) {
            study.parameters.erase(study.parameters.begin() + static_cast<std::ptrdiff_t>(k));
            study.space.axes.erase(study.space.axes.begin() + static_cast<std::ptrdiff_t>(k));
        }
    }
}

// The outputs, or without any the readings.
std::vector<Reported> reported_responses(const study::Study& study) {
    const auto names = run_header(study, "", "").responses;
    std::vector<Reported> responses;
    for (std::size_t i = study.outputs.empty() ? 0 : study.measurements.size(); i < study.responses(); ++i) {
        responses.push_back({i, names[i].substr(0, names[i].rfind(" [")), std::string(study.response_unit(i)),
                             study.response_to_si(i)});
    }
    return responses;
}

// The parameter space of the curves: around each own value, whatever the bounds of the study are.
problem::ParameterSpace space_around(const problem::ParameterSpace& space, double range) {
    problem::ParameterSpace around = space;
    for (auto& axis : around.axes) {
        const double change = axis.start * range / 100.0;
        axis.low = axis.start - change;
        axis.high = axis.start + change;
        axis.scale = problem::Scale::linear;
    }
    return around;
}

double percent_change(const Reported& response, const problem::Evaluation& e, const problem::Evaluation& own) {
    const double from = own.responses[response.index];
    return e.converged() && from != 0.0 ? 100.0 * (e.responses[response.index] / from - 1.0)
                                        : std::numeric_limits<double>::quiet_NaN();
}

std::string signed_figure(double value, int digits) {
    return std::isfinite(value) ? fmt::format("{:+.{}f}", value, digits) : "-";
}

Json curves_json(const problem::ParameterSpace& space, const Sensitivity& s) {
    Json json = Json::array();
    for (const Curve& curve : s.curves) {
        Json points = Json::array();
        for (std::size_t p = 0; p < curve.points.size(); ++p) {
            const auto& e = curve.points[p];
            Json point = {{"change_percent", s.changes[p]},
                          {"value", e.parameters[curve.parameter]},
                          {"status", std::string(to_string(e.status))}};
            if (e.converged()) {
                for (const auto& response : s.responses) {
                    point["responses_change_percent"].push_back(percent_change(response, e, s.own));
                }
            } else {
                point["reason"] = e.reason;
            }
            points.push_back(std::move(point));
        }
        json.push_back({{"parameter", space.axes[curve.parameter].name}, {"points", std::move(points)}});
    }
    return json;
}

Json estimate_json(const landscape::Estimate& e) {
    return {{"value", e.value}, {"low", e.low}, {"high", e.high}};
}

Json global_json(const problem::ParameterSpace& space, const Sensitivity& s) {
    Json indices = Json::array();
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const Reported& response = s.responses[i];
        Json first = Json::object();
        Json total = Json::object();
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            first[space.axes[k].name] = estimate_json(g.first[k]);
            total[space.axes[k].name] = estimate_json(g.total[k]);
        }
        indices.push_back({{"response", response.name},
                           {"unit", response.unit},
                           {"mean", g.mean / response.to_si},
                           {"standard_deviation", std::sqrt(g.variance) / response.to_si},
                           {"first_order", std::move(first)},
                           {"total", std::move(total)},
                           {"interactions", estimate_json(g.interactions)}});
    }
    const auto rows = static_cast<double>(std::max<std::size_t>(s.global.rows, 1));
    return {{"rows", s.global.rows},
            {"complete_rows", s.global.complete},
            {"dropped_share", static_cast<double>(s.global.rows - s.global.complete) / rows},
            {"statuses", s.statuses},
            {"confidence", 0.95},
            {"indices", std::move(indices)}};
}

// The parameters by decreasing total index.
std::vector<std::size_t> ranked(const landscape::SobolIndices& g) {
    std::vector<std::size_t> order(g.total.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return g.total[a].value > g.total[b].value; });
    return order;
}

// What the global indices say, in sentences.
std::vector<std::string> findings(const problem::ParameterSpace& space, const Sensitivity& s) {
    constexpr double negligible = 0.05; // of the variance
    std::vector<std::string> words;
    std::vector<bool> matters(space.axes.size(), false);
    double widest = 0.0;
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const std::string& name = s.responses[i].name;
        if (!std::isfinite(g.total[0].value)) {
            words.push_back(name + " does not vary over the box.");
            continue;
        }
        const auto order = ranked(g);
        std::vector<std::string> parts;
        for (const std::size_t k : order) {
            widest = std::max(widest, (g.total[k].high - g.total[k].low) / 2.0);
            matters[k] = matters[k] || g.total[k].high >= negligible;
            if (parts.empty() || (parts.size() < 3 && g.total[k].value >= negligible)) {
                parts.push_back(fmt::format("{} ({:.0f} %{})", space.axes[k].name, 100.0 * g.total[k].value,
                                            parts.empty() ? " of its variance" : ""));
            }
        }
        std::string sentence = name + " is governed by " + pave::join(parts, ", then ");
        if (g.interactions.low >= negligible) {
            sentence += fmt::format("; {:.0f} % come from parameters acting together, counted here for each of them",
                                    100.0 * g.interactions.value);
        }
        if (order.size() > 1 && g.total[order[1]].high > g.total[order[0]].low) {
            sentence += fmt::format("; the sample does not settle which of {} and {} comes first",
                                    space.axes[order[0]].name, space.axes[order[1]].name);
        }
        words.push_back(sentence + ".");
    }
    std::vector<std::string> idle;
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        if (!matters[k]) {
            idle.push_back(space.axes[k].name);
        }
    }
    if (widest > 0.0 && !idle.empty()) {
        words.push_back(fmt::format("Within its bounds it hardly matters to any of these responses (total index below "
                                    "{}): {}. They will not determine it.",
                                    negligible, pave::join(idle)));
    }
    if (s.global.complete < s.global.rows) {
        words.push_back(fmt::format(
            "{} of {} rows of the sample ({:.1f} %) hold a point without an answer and were left out whole: the "
            "indices "
            "describe the part of the box that has answers, where the parameters are no longer independent.",
            s.global.rows - s.global.complete, s.global.rows,
            100.0 * static_cast<double>(s.global.rows - s.global.complete) / static_cast<double>(s.global.rows)));
    }
    if (s.global.complete < 2) {
        words.emplace_back("Too few rows are left for global indices.");
    } else if (widest > 0.1) {
        words.push_back(fmt::format("The widest of the 95 % intervals of a total index is +-{:.2f}: more --samples "
                                    "narrow it, and what is computed is kept.",
                                    widest));
    }
    return words;
}

void print_elasticities(const study::Study& study, const Sensitivity& s) {
    std::vector<std::string> header{"response", "value", "unit"};
    for (const auto& axis : study.space.axes) {
        header.push_back(axis.name);
    }
    report::Table table(header);
    std::vector<std::string> values{"value of the parameter", "", ""};
    for (const auto& axis : study.space.axes) {
        values.push_back(figure(axis.start));
    }
    table.add(std::move(values));
    for (const Reported& r : s.responses) {
        std::vector<std::string> row{r.name, figure(s.own.responses[r.index] / r.to_si), r.unit};
        for (Eigen::Index k = 0; k < s.elasticity.cols(); ++k) {
            row.push_back(signed_figure(s.elasticity(static_cast<Eigen::Index>(r.index), k), 3));
        }
        table.add(std::move(row));
    }
    fmt::print("\nAt the study's own values: % of the response for 1 % of the parameter\n  {}\n{}", sign_convention,
               table.text());
}

void print_curves(const problem::ParameterSpace& space, const Sensitivity& s) {
    std::vector<std::string> header{"response", "parameter"};
    for (const double change : s.changes) {
        header.push_back(fmt::format("{:+.4g} %", change));
    }
    header.emplace_back("shape");
    report::Table table(header);
    for (const Reported& r : s.responses) {
        for (const Curve& curve : s.curves) {
            std::vector<std::string> row{&curve == s.curves.data() ? r.name : "", space.axes[curve.parameter].name};
            std::vector<double> changes;
            for (const auto& e : curve.points) {
                changes.push_back(percent_change(r, e, s.own));
                row.push_back(signed_figure(changes.back(), 1));
            }
            row.push_back(report::sparkline(changes));
            table.add(std::move(row));
        }
    }
    fmt::print("\nChange of the response in % when one parameter is changed by so much, the others held\n"
               "  percentages of the study's own value: + takes a negative one further from zero\n{}",
               table.text());
    for (const Curve& curve : s.curves) {
        for (std::size_t p = 0; p < curve.points.size(); ++p) {
            const auto& e = curve.points[p];
            if (!e.converged()) {
                fmt::print("  no answer at {} {:+.4g} % ({}): {}: {}\n", space.axes[curve.parameter].name, s.changes[p],
                           figure(e.parameters[curve.parameter]), to_string(e.status), e.reason);
            }
        }
    }
}

void print_global(const problem::ParameterSpace& space, const Sensitivity& s) {
    report::Table table(
        {"response", "mean", "std. dev.", "unit", "parameter", "alone", "95 % interval", "in all", "95 % interval"});
    const auto interval = [](const landscape::Estimate& e) {
        return std::isfinite(e.value) ? fmt::format("{:.3f} to {:.3f}", e.low, e.high) : "-";
    };
    const auto share = [](const landscape::Estimate& e) {
        return std::isfinite(e.value) ? fmt::format("{:.3f}", e.value) : "-";
    };
    for (std::size_t i = 0; i < s.global.responses.size(); ++i) {
        const auto& g = s.global.responses[i];
        const Reported& r = s.responses[i];
        std::vector<std::string> head{r.name, figure(g.mean / r.to_si), figure(std::sqrt(g.variance) / r.to_si),
                                      r.unit};
        for (const std::size_t k : ranked(g)) {
            std::vector<std::string> row = std::move(head);
            head.assign(4, "");
            row.insert(row.end(), {space.axes[k].name, share(g.first[k]), interval(g.first[k]), share(g.total[k]),
                                   interval(g.total[k])});
            table.add(std::move(row));
        }
    }
    fmt::print(
        "\nOver the box (each parameter uniform between its bounds, in the logarithm where its scale is log): share "
        "of the variance\n  that a parameter makes alone (first order) and in all, with its interactions "
        "(total); {} rows of {} runs\n",
        s.global.rows, space.dimension() + 2);
    for (const auto& [status, count] : s.statuses.items()) {
        if (status != "converged" && count.get<std::int64_t>() > 0) {
            fmt::print("    {} of these runs: {}\n", count.get<std::int64_t>(), status);
        }
    }
    fmt::print("{}\nWhat this means\n", table.text());
    for (const std::string& sentence : findings(space, s)) {
        fmt::print("  {}\n", sentence);
    }
}

int sensitivity(const SensitivityOptions& options) {
    study::Study study = study::load_study(options.common.study);
    choose_parameters(study, options.parameters);
    const problem::Problem problem = study::make_prediction_problem(study);
    const int dimension = problem.space.dimension();
    if (options.samples > 0 && dimension > search::most_radial_dimensions) {
        throw pave::Error(
            {.file = study.file, .key = "parameters"}, "too many parameters for global indices",
            fmt::format("{}", dimension),
            fmt::format("at most {}: choose some (--parameter), or --samples 0", search::most_radial_dimensions));
    }
    std::vector<std::string> names;
    std::vector<std::size_t> curved; // a parameter of zero has no percentage
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        names.push_back(problem.space.axes[k].name);
        if (problem.space.axes[k].start != 0.0) {
            curved.push_back(k);
        }
    }
    const std::string folder = options.common.folder(study);
    run::Store store(folder, session(options.common));
    Sensitivity s;
    s.responses = reported_responses(study);
    run::Tally tally;

    const problem::Problem around{space_around(problem.space, options.range), problem.function, problem.misfit};
    const auto curves_design = search::one_at_a_time(dimension, curved, options.points);
    int id = store.begin(
        run_header(study, "sensitivity-curves",
                   fmt::format("{} over +-{:g} % of {}", curves_design.name, options.range, pave::join(names))));
    {
        run::Engine engine(around, &store, id, {.threads = options.common.threads, .show_progress = true});
        s.own = engine.evaluate_one(std::vector<double>(names.size(), 0.5));
        if (!s.own.converged()) {
            const std::string reason = "the study's own values have no answer: " + s.own.reason;
            if (options.common.json) {
                fmt::print("{}\n",
                           report::json_text({{"status", std::string(to_string(s.own.status))}, {"reason", reason}}));
            }
            run::message("pavescape: {}: {}\n", to_string(s.own.status), reason);
            return computation_failed;
        }
        const auto evaluations = engine.evaluate(curves_design);
        if (!evaluations) {
            return report_interrupt(folder);
        }
        for (std::size_t c = 0; c < curved.size(); ++c) {
            const auto first = evaluations->begin() + static_cast<std::ptrdiff_t>(c) * options.points;
            s.curves.push_back({curved[c], {first, first + options.points}});
        }
        tally = engine.tally();
    }
    for (int p = 0; p < options.points; ++p) {
        s.changes.push_back(options.range * (2.0 * p / (options.points - 1) - 1.0));
    }
    s.elasticity = landscape::elasticities(s.own);

    if (options.samples > 0) {
        const auto design = search::radial(dimension, options.samples, options.common.seed);
        // The number of rows is not part of the run: more rows go on where fewer ended.
        id = store.begin(run_header(study, "sensitivity",
                                    fmt::format("radial (seed {}) of {}", options.common.seed, pave::join(names))));
        run::Engine engine(problem, &store, id, {.threads = options.common.threads, .show_progress = true});
        const auto evaluations = engine.evaluate(design);
        if (!evaluations) {
            return report_interrupt(folder);
        }
        std::vector<std::size_t> indices;
        for (const Reported& r : s.responses) {
            indices.push_back(r.index);
        }
        s.statuses = report::status_counts(*evaluations);
        s.global = landscape::sobol_indices(*evaluations, names.size(), indices, options.common.seed);
        tally.computed += engine.tally().computed;
        tally.kept += engine.tally().kept;
        tally.seconds += engine.tally().seconds;
    }

    Json json = {{"study", {{"file", study.file}, {"title", study.title}, {"hash", study.hash}}},
                 {"version", PAVESCAPE_VERSION},
                 {"seed", options.common.seed},
                 {"computed", tally.computed},
                 {"kept", tally.kept},
                 {"run", folder},
                 {"parameters", report::space_json(problem.space)},
                 {"responses", Json::array()},
                 {"range_percent", options.range},
                 {"curves", curves_json(problem.space, s)}};
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        json["parameters"][k]["value"] = problem.space.axes[k].start;
    }
    for (const Reported& r : s.responses) {
        Json elasticity = Json::object();
        for (std::size_t k = 0; k < names.size(); ++k) {
            elasticity[names[k]] = s.elasticity(static_cast<Eigen::Index>(r.index), static_cast<Eigen::Index>(k));
        }
        json["responses"].push_back({{"name", r.name},
                                     {"unit", r.unit},
                                     {"value", s.own.responses[r.index] / r.to_si},
                                     {"elasticities", std::move(elasticity)}});
    }
    if (options.samples > 0) {
        json["global"] = global_json(problem.space, s);
        json["findings"] = findings(problem.space, s);
    }
    json["warnings"] = s.own.warnings;
    store.put_result(id, report::json_text(json, -1));
    write_file(folder, "sensitivity.json", report::json_text(json) + "\n");
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
    } else {
        fmt::print("{}  {} computed in {} ({:.1f} runs/s), {} kept from before\n", study_summary(study),
                   report::counted(static_cast<std::size_t>(tally.computed), "run", "runs"),
                   run::duration_words(tally.seconds),
                   tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0, tally.kept);
        for (const std::string& warning : s.own.warnings) {
            fmt::print("  warning: {}\n", warning);
        }
        print_elasticities(study, s);
        if (!s.curves.empty()) {
            print_curves(problem.space, s);
        }
        for (const auto& axis : problem.space.axes) {
            if (axis.start == 0.0) {
                fmt::print("  {} is 0 in the study: it has no percentage.\n", axis.name);
            }
        }
        if (options.samples > 0) {
            print_global(problem.space, s);
        }
        fmt::print("\n  results: {}/sensitivity.json; every run: pavescape export {} --command sensitivity{}\n", folder,
                   folder, options.samples > 0 ? " (or sensitivity-curves)" : "-curves");
    }
    if (options.samples > 0 && s.global.complete < 2) {
        run::message("pavescape: too few points of the box have an answer for global indices\n");
        return computation_failed;
    }
    return done;
}

} // namespace

void add_sensitivity(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("sensitivity", "how much each parameter moves each response");
    auto options = std::make_shared<SensitivityOptions>();
    add_common(*command, options->common);
    command
        ->add_option("--parameter", options->parameters,
                     "a parameter to change, may come several times (default: all of the study); the others stay at "
                     "their own values")
        ->allow_extra_args(false);
    command->add_option("--range", options->range, "the curves go this many percent to either side")
        ->check(within(0.1, 100.0))
        ->capture_default_str();
    command->add_option("--points", options->points, "points of a curve")
        ->check(CLI::Range(2, 1001))
        ->capture_default_str();
    command
        ->add_option("--samples", options->samples,
                     "rows of the sample for global indices, best a power of 2, each as many runs as parameters "
                     "and two more; 0: none")
        ->check(CLI::Range(0, 1'000'000))
        ->capture_default_str();
    command->footer("Example: pavescape sensitivity grids/captif-p1-fwd.toml --range 50 --samples 256");
    command->callback([=, &action] { action = [=] { return sensitivity(*options); }; });
}

} // namespace explore::cli

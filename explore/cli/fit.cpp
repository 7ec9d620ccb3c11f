// pavescape fit: explore, then refine the best starts.
#include "cli/common.h"
#include "cli/groups.h"
#include "cli/model.h"
#include "landscape/multistart.h"
#include "report/table.h"
#include "run/message.h"
#include "run/progress.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using landscape::Minimum;
using report::counted;
using report::figure;

struct FitOptions {
    CommonOptions common;
    ModelOptions model;
    std::string scheme = "multistart";
    int explore = fit_points;
    bool joint_only = false;
    landscape::MultistartSettings multistart;
};

// multistart: a Sobol sample and several starts; paper: a coarse full grid, and one search from its smallest misfit.
search::Design make_design(FitOptions& options, const study::Study& study) {
    if (options.scheme == "multistart") {
        return search::sobol(study.space, options.explore, options.common.seed);
    }
    options.multistart.starts = 1;
    constexpr int coarse = 4;
    if (search::full_grid_size(study.space, coarse) > 100'000) {
        throw pave::Error({.file = study.file, .key = "parameters"}, "too many parameters for the paper's full grid",
                          counted(study.space.axes.size(), "parameter", "parameters"), "--scheme multistart");
    }
    problem::ParameterSpace space = study.space;
    for (auto& axis : space.axes) {
        axis.points = coarse; // an axis held in `map` is free here
    }
    return search::full_grid(space);
}

// Minima whose misfit the noise cannot tell from the best one: within one noise level, or 5 % without degrees of
// freedom.
std::vector<const Minimum*> rivals(const std::vector<Minimum>& minima, const landscape::LocalAnalysis& best) {
    const double f0 = minima[0].evaluation.misfit;
    const double margin = best.noise > 0.0 ? std::sqrt(f0 * f0 + best.noise * best.noise) : 1.05 * f0;
    std::vector<const Minimum*> list;
    for (const Minimum& m : minima) {
        if (m.evaluation.misfit <= margin) {
            list.push_back(&m);
        }
    }
    return list;
}

std::string direction_words(const problem::ParameterSpace& space, const std::vector<double>& unit,
                            const std::vector<double>& direction) {
    std::string text;
    for (std::size_t k = 0; k < direction.size(); ++k) {
        if (std::abs(direction[k]) < 0.1) {
            continue;
        }
        const problem::Axis& axis = space.axes[k];
        const double moved = 0.1 * direction[k];
        text += text.empty() ? "" : " with ";
        text += axis.scale == problem::Scale::log
                    ? fmt::format("{} x {:.2f}", axis.name, std::pow(axis.high / axis.low, moved))
                    : fmt::format("{} {:+.2g}", axis.name, moved * axis.d_physical(unit[k]));
    }
    return text;
}

// What the ends of the searches mean, in plain words.
std::vector<std::string> findings(const study::Study& study, const problem::Problem& problem,
                                  const landscape::MultistartResult& result, const landscape::LocalAnalysis& local) {
    std::vector<std::string> text;
    const bool weighted_by_noise =
        study.data.misfit == problem::MisfitKind::weighted && study.noise == study::NoiseSource::stated;
    const Minimum& best = result.minima[0];
    const std::size_t starts = result.ends.size();
    const auto close = rivals(result.minima, local);
    const std::string unfinished = best.converged ? "" : ", whose search had not converged when it was ended";
    if (starts == 1) {
        text.push_back(fmt::format("One search from one start{}: it says nothing about other minima.", unfinished));
    } else {
        text.push_back(
            fmt::format("{} of {} starts ended in the best minimum{}.", best.members.size(), starts, unfinished));
    }
    if (close.size() > 1) {
        text.push_back(fmt::format("{} minima fit these data equally well within their noise: the data do not single "
                                   "out one of them.",
                                   close.size()));
    } else if (result.minima.size() > 1) {
        text.push_back(fmt::format("The next minimum has a misfit {:.2g} times as large: a search from a single start "
                                   "could have ended there.",
                                   result.minima[1].evaluation.misfit / best.evaluation.misfit));
    } else if (starts > 1) {
        text.push_back("No start ended anywhere else. That does not prove that there is no other minimum.");
    }
    // How far each parameter reaches over everything that fits as well.
    std::vector<std::string> loose;
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        double low = best.lowest[k];
        double high = best.highest[k];
        for (const Minimum* m : close) {
            low = std::min(low, m->lowest[k]);
            high = std::max(high, m->highest[k]);
        }
        if (axis.unit(high) - axis.unit(low) > 0.05) {
            loose.push_back(fmt::format("{} from {} to {}", axis.name, figure(low), figure(high)));
        }
    }
    if (!loose.empty()) {
        text.push_back("Searches that fit equally well ended with " + pave::join(loose) +
                       ": what fits as well reaches at least that far.");
    }
    // A standard error that spans half of what the study allows says nothing about the parameter.
    std::vector<std::string> unseen;
    for (std::size_t k = 0; k < problem.space.axes.size(); ++k) {
        const bool at_bound = best.unit[k] <= 0.0 || best.unit[k] >= 1.0;
        if (!at_bound && local.standard_error[k] > 0.5) {
            unseen.push_back(problem.space.axes[k].name);
        }
    }
    if (!unseen.empty() && local.degrees_of_freedom > 0) {
        text.push_back(fmt::format("Not determined one by one (the standard error spans half of the allowed range or "
                                   "more): {}. Other values fit these data as well, and what they predict elsewhere "
                                   "may differ.",
                                   pave::join(unseen)));
    }
    if (!best.on_bound.empty()) {
        text.push_back(pave::join(best.on_bound) +
                       ": the data ask for more than the study allows there, or do not see it.");
    }
    if (local.noise > 0.0 && local.weakest_growth < 3.0 * local.noise) {
        text.push_back(
            fmt::format("The data hardly see this change: {}. It changes the residuals by {}, where their noise is {}.",
                        direction_words(problem.space, best.unit, local.weakest), figure(local.weakest_growth),
                        figure(local.noise)));
    }
    const Eigen::VectorXd residuals = problem.misfit.residuals(best.evaluation.responses);
    Eigen::Index worst = 0;
    const double largest = residuals.cwiseAbs().maxCoeff(&worst);
    // Residuals in units of stated noise are only news when they are large.
    const bool within_noise = weighted_by_noise && largest < 3.0;
    if (residuals.size() > 2 && !within_noise && largest * largest > 0.5 * residuals.squaredNorm()) {
        const std::size_t i = problem.misfit.terms()[static_cast<std::size_t>(worst)].response;
        text.push_back(
            fmt::format("One reading makes {:.0f} % of the sum of squares: {}, measured {:g}, model {}. Either "
                        "it or the model is wrong there.",
                        100.0 * largest * largest / residuals.squaredNorm(), run_header(study, "", "").responses[i],
                        study.measurements[i].value, figure(best.evaluation.responses[i] / study.response_to_si(i))));
    }
    if (local.noise_is_stated && local.degrees_of_freedom > 0) {
        text.push_back(fmt::format(
            "{}: chi2 = {} with {}, p = {:.2g}.{}",
            local.p_value < 0.05 ? "The model does not fit these data within their stated noise"
                                 : "The fit is consistent with the stated noise",
            figure(local.chi2),
            counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            local.p_value,
            local.widened ? " The standard errors are those of a noise that much larger; diagnose looks for the cause."
                          : ""));
    }
    if (local.degrees_of_freedom <= 0) {
        text.push_back(fmt::format("{} for {} free: the data cannot tell noise from a wrong model{}.",
                                   counted(problem.misfit.size(), "reading", "readings"),
                                   counted(problem.space.axes.size(), "parameter", "parameters"),
                                   local.noise_is_stated ? "" : ", and no error of the parameters can be given"));
    } else if (study.noise == study::NoiseSource::estimated) {
        if (study.data.misfit == problem::MisfitKind::weighted) {
            text.push_back("No reading states a standard deviation: each was weighted by its own size.");
        }
        text.push_back(fmt::format(
            "The data state no noise. Taken from what the fit leaves over, with only {}, one "
            "residual has a standard deviation of {}.",
            counted(static_cast<std::size_t>(local.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            figure(local.noise)));
    }
    return text;
}

int fit(FitOptions options) {
    const study::Study study = study::load_study(options.common.study);
    const std::string folder = options.common.folder(study);
    const problem::Problem full = study::make_problem(study, study::Scope::fitted);
    std::optional<ReducedProblem> reduced;
    if (options.model.reduced()) {
        reduced = reduced_problem(full, study, options.model, folder, options.common.threads);
        if (!reduced) {
            return report_interrupt(folder);
        }
    }
    const bool reduced_alone = options.model.alone();
    const problem::Problem& problem = reduced_alone ? reduced->problem : full;
    const search::Design design = make_design(options, study);
    const auto& search_settings = options.multistart.search;
    const std::string settings =
        fmt::format("{}; {} starts, distance {}; {}, {} evaluations, tolerances {} {}{}{}", design.name,
                    options.multistart.starts, options.multistart.start_distance, options.multistart.method,
                    search_settings.max_evaluations, search_settings.step_tolerance, search_settings.misfit_tolerance,
                    reduced ? reduced->settings : "", options.model.confirmed() ? " to explore" : "");
    run::Store store(folder, session(options.common));
    run::Tally of_exploration;
    std::optional<std::vector<problem::Evaluation>> explored;
    if (options.model.confirmed()) { // a run of its own: its evaluations are not the full model's
        const int id = store.begin(run_header(study, "explore", settings));
        run::Engine engine(reduced->problem, &store, id, {.threads = options.common.threads, .show_progress = true});
        explored = engine.evaluate(design);
        if (!explored) {
            return report_interrupt(folder);
        }
        of_exploration = engine.tally();
    }
    const int id = store.begin(run_header(study, "fit", settings));
    run::Engine engine(problem, &store, id, {.threads = options.common.threads, .show_progress = true});
    auto result = explored ? landscape::refine(engine, problem, design, std::move(*explored), {}, options.multistart)
                           : landscape::multistart(engine, problem, design, options.multistart);
    if (!result) {
        return report_interrupt(folder);
    }
    const report::Json statuses = report::status_counts(result->explored);
    if (result->minima.empty()) {
        const std::string reason =
            "not one explored point has an answer; the first says: " + result->explored.front().reason;
        if (options.common.json) {
            fmt::print("{}\n", report::json_text({{"status", "failed"}, {"reason", reason}, {"statuses", statuses}}));
        }
        run::message("pavescape: {}\n", reason);
        return computation_failed;
    }
    const Predictor predictor(study);
    predictor.complete(result->minima[0].evaluation);
    const Minimum& best = result->minima[0];
    const GroupFit joint{"all", best.evaluation, report::minimum_json(problem, best),
                         group_rms(study, best.evaluation)};
    std::optional<std::vector<GroupFit>> alone = std::vector<GroupFit>{};
    if (!options.joint_only && !reduced_alone) {
        alone =
            fit_alone(study, predictor, design, *result, store, settings, options.multistart, options.common.threads);
        if (!alone) {
            return report_interrupt(folder);
        }
        store.begin(run_header(study, "fit", settings)); // the run of this fit is the one used last
    }
    const run::Tally& tally = engine.tally();
    const auto local = landscape::analyse(best, problem);
    const auto words = findings(study, problem, *result, local);

    int evaluations = 0;
    for (const auto& end : result->ends) {
        evaluations += end.search.evaluations;
    }
    report::Json json = {{"best", report::minimum_json(problem, best)},
                         {"minima", report::Json::array()},
                         {"evaluations", static_cast<std::int64_t>(design.points.size()) + evaluations},
                         {"search_evaluations", evaluations},
                         {"starts", result->ends.size()},
                         {"explored", design.name},
                         {"model", options.model.model},
                         {"scheme", options.scheme},
                         {"method", options.multistart.method},
                         {"seed", options.common.seed},
                         {"study", {{"file", study.file}, {"title", study.title}, {"hash", study.hash}}},
                         {"version", PAVESCAPE_VERSION},
                         {"statuses", statuses},
                         {"misfit_kind", std::string(to_string(study.data.misfit))},
                         {"noise",
                          {{"source", study.noise_name()},
                           {"residual_standard_deviation", local.noise},
                           {"degrees_of_freedom", local.degrees_of_freedom},
                           {"chi2", local.noise_is_stated ? report::Json(local.chi2) : report::Json(nullptr)},
                           {"p_value", local.noise_is_stated ? report::Json(local.p_value) : report::Json(nullptr)},
                           {"widened", local.widened}}},
                         {"findings", words},
                         {"responses", report::responses_json(study, best.evaluation.responses)},
                         {"warnings", best.evaluation.warnings},
                         {"run", folder}};
    if (reduced) {
        json["reduced_model"] = reduced->json;
    }
    json.update(group_json(study, joint, *alone));
    json["parameters"] = report::space_json(problem.space);
    json["ends"] = report::Json::array();
    for (const run::Endpoint& end : result->ends) {
        if (!end.search.unit.empty()) {
            json["ends"].push_back({{"start", end.start},
                                    {"misfit", end.search.misfit},
                                    {"evaluations", end.search.evaluations},
                                    {"converged", end.search.converged},
                                    {"ended", end.search.ended}});
        }
    }
    json["best"]["status"] = std::string(to_string(best.evaluation.status));
    for (const Minimum& m : result->minima) {
        json["minima"].push_back(report::minimum_json(problem, m));
    }
    store.put_result(id, report::json_text(json, -1));
    write_file(folder, "fit.json", report::json_text(json) + "\n");
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
        return done;
    }

    fmt::print("{}\n  explored {}, then {} searches by {} ({} evaluations, {:.0f} a search)\n", study_summary(study),
               design.name, result->ends.size(), options.multistart.method, evaluations,
               static_cast<double>(evaluations) / static_cast<double>(result->ends.size()));
    fmt::print("  {} computed in {} ({:.1f} runs/s), {} kept from before\n",
               counted(static_cast<std::size_t>(tally.computed), "run", "runs"), run::duration_words(tally.seconds),
               tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0, tally.kept);
    if (reduced) {
        fmt::print("{}  {}\n", reduced->words,
                   reduced_alone
                       ? "the fit below is that of the reduced model; --model auto refines it with the full one"
                       : fmt::format("{} explored by the reduced model in {}, all below is the full model's",
                                     counted(design.points.size(), "point", "points"),
                                     run::duration_words(of_exploration.seconds)));
    }
    for (const auto& [status, count] : statuses.items()) {
        if (status != "converged" && count.get<std::int64_t>() > 0) {
            fmt::print("    {} of the explored points: {}\n", count.get<std::int64_t>(), status);
        }
    }

    fmt::print("\nBest fit: misfit f = {} ({} residuals, root mean square {})\n", figure(best.evaluation.misfit),
               to_string(study.data.misfit),
               figure(best.evaluation.misfit / std::sqrt(static_cast<double>(problem.misfit.size()))));
    report::Table parameters({"parameter", "value", "std. error", "min", "max"});
    for (std::size_t k = 0; k < best.unit.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        const double error = local.standard_error[k] * axis.d_physical(best.unit[k]);
        parameters.add({axis.name, figure(best.evaluation.parameters[k]),
                        local.standard_error[k] > 1.0 ? "> range" : figure(error), figure(axis.low),
                        figure(axis.high)});
    }
    fmt::print("{}\n{}", parameters.text(), response_table(study, best.evaluation.responses));
    for (const std::string& warning : best.evaluation.warnings) {
        fmt::print("  warning: {}\n", warning);
    }

    if (study.groups.size() > 1) {
        fmt::print("{}", group_text(study, joint, *alone));
    }
    fmt::print("\n{} found\n", counted(result->minima.size(), "distinct minimum", "distinct minima"));
    std::vector<std::string> header{"misfit", "starts"};
    for (const auto& axis : problem.space.axes) {
        header.push_back(axis.name);
    }
    header.emplace_back("remark");
    report::Table minima(header);
    for (const Minimum& m : result->minima) {
        std::vector<std::string> row{figure(m.evaluation.misfit),
                                     fmt::format("{} of {}", m.members.size(), result->ends.size())};
        for (const double value : m.evaluation.parameters) {
            row.push_back(figure(value));
        }
        std::string remark = pave::join(m.on_bound);
        if (!m.converged) {
            remark += (remark.empty() ? "" : "; ") + std::string("not converged: ") +
                      result->ends[static_cast<std::size_t>(m.members[0])].search.ended;
        }
        row.push_back(remark);
        minima.add(std::move(row));
    }
    fmt::print("{}\nWhat this means\n", minima.text());
    for (const std::string& sentence : words) {
        fmt::print("  {}\n", sentence);
    }
    fmt::print("\n  results: {}/fit.json; every evaluation: pavescape export {} --command fit\n", folder, folder);
    return done;
}

} // namespace

void add_fit(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("fit", "explore, then refine the best starts: the main job");
    auto options = std::make_shared<FitOptions>();
    add_common(*command, options->common);
    add_model(*command, options->model);
    std::vector<std::string> names;
    for (const auto& method : optimise::methods()) {
        names.emplace_back(method.name);
    }
    command
        ->add_option("--scheme", options->scheme,
                     "multistart, or paper: a coarse full grid and one search from its smallest misfit")
        ->check(CLI::IsMember({"multistart", "paper"}))
        ->capture_default_str();
    command->add_option("--explore", options->explore, "points of the Sobol sample")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command->add_option("--starts", options->multistart.starts, "local searches")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    command->add_option("--method", options->multistart.method, "local search by NLopt: " + pave::join(names))
        ->check(CLI::IsMember(names))
        ->capture_default_str();
    command->add_flag("--joint-only", options->joint_only,
                      "do not also fit each group of readings alone to see what it predicts for the others");
    command->footer("Example: pavescape fit grids/captif-p1-fwd.toml --starts 16");
    command->callback([=, &action] { action = [=] { return fit(*options); }; });
}

} // namespace explore::cli

// pavescape diagnose: what the simulation gets wrong, the cause, the extended model, the gain.
#include "cli/common.h"
#include "cli/diagnosis_report.h"
#include "cli/groups.h"
#include "cli/model.h"
#include "pavement/effects/effect.h"
#include "report/table.h"
#include "run/message.h"
#include "run/progress.h"
#include "study/candidates.h"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::cli {
namespace {

using diagnose::Diagnosis;
using diagnose::Judged;
using diagnose::Members;
using diagnose::Verdict;
using report::counted;
using report::Json;

struct DiagnoseOptions {
    CommonOptions common;
    ModelOptions model;
    std::vector<std::string> without;
    diagnose::DiagnosisSettings analysis;
};

std::vector<study::Variant> variants_of(const std::vector<study::Variant>& all, const Members& members) {
    std::vector<study::Variant> list;
    list.reserve(members.size());
    for (const std::size_t c : members) {
        list.push_back(all[c]);
    }
    return list;
}

Reported report_of(const study::Study& study, const std::vector<study::Variant>& all, diagnose::Workbench& bench,
                   const Judged& judged, double variance) {
    Reported r{.study = study::with_free_effects(study, variants_of(all, judged.model.members)),
               .evaluation = judged.model.evaluation,
               .parameters = {},
               .held_out_rms = {}};
    const problem::Problem& problem = bench.problem(judged.model.members);
    for (std::size_t k = 0; k < judged.model.unit.size(); ++k) {
        r.parameters.push_back(diagnose::interval_of(problem, judged.model, k, variance));
    }
    Predictor(r.study).complete(r.evaluation);
    r.held_out_rms = held_out_rms(study, r.evaluation.responses);
    for (const auto& group : study.groups) {
        r.held_out += r.held_out_rms && group.held_out ? group.rows.size() : 0;
    }
    r.misfit = study::make_problem(study, study::Scope::fitted).misfit.residuals(r.evaluation.responses).norm();
    return r;
}

// Every explanation foretells what could be read; the best reading is the one whose least separation from the best
// explanation is largest, in standard deviations of the reading and of what the fits leave open.
std::vector<Separating> separating_readings(const study::Study& study, const std::vector<study::Variant>& all,
                                            diagnose::Workbench& bench, const Diagnosis& d) {
    const study::Candidates list = study::candidates(study);
    struct Foretold {
        std::vector<double> values, variances;
    };
    std::vector<Foretold> foretold;
    constexpr std::size_t most = 6;
    for (std::size_t e = 0; e < std::min(most, d.explanations.size()); ++e) {
        const auto& model = d.explanations[e].fit.model;
        // A wrong reading is no property of the next one.
        std::vector<study::Variant> own;
        std::vector<double> values = model.evaluation.parameters;
        std::vector<Eigen::Index> columns;
        const std::size_t baseline = study.space.axes.size();
        values.resize(baseline);
        for (std::size_t k = 0; k < baseline; ++k) {
            columns.push_back(static_cast<Eigen::Index>(k));
        }
        for (std::size_t m = 0; m < model.members.size(); ++m) {
            const study::Variant& variant = all[model.members[m]];
            if (!variant.applied.reading && why_impossible(list.study.model, variant.applied).empty()) {
                own.push_back(variant);
                values.push_back(model.evaluation.parameters[baseline + m]);
                columns.push_back(static_cast<Eigen::Index>(baseline + m));
            }
        }
        const problem::Problem problem = study::make_prediction_problem(study::with_free_effects(list.study, own));
        const auto workspace = problem.function->make_workspace();
        const auto outcome = problem.function->evaluate(values, true, *workspace);
        if (!outcome) {
            continue;
        }
        const problem::Problem& fitted = bench.problem(model.members);
        const Eigen::MatrixXd j = fitted.residual_jacobian(model.evaluation);
        Eigen::MatrixXd h = j.transpose() * j / d.variance;
        constexpr double box_variance = 1.0 / 12.0;
        h.diagonal().array() += 1.0 / box_variance;
        const Eigen::MatrixXd covariance = h.inverse();
        Foretold f{outcome->responses, {}};
        for (std::size_t i = 0; i < list.names.size(); ++i) {
            Eigen::VectorXd slope(static_cast<Eigen::Index>(columns.size()));
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const auto at = static_cast<std::size_t>(columns[k]);
                slope[static_cast<Eigen::Index>(k)] =
                    outcome->jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
                    fitted.space.axes[at].d_physical(model.unit[at]);
            }
            const Eigen::MatrixXd part = covariance(columns, columns);
            f.variances.push_back(slope.dot(part * slope));
        }
        foretold.push_back(std::move(f));
    }
    std::vector<Separating> readings;
    if (foretold.size() < 2) {
        return readings;
    }
    for (std::size_t i = 0; i < list.names.size(); ++i) {
        const double si = list.study.response_to_si(i);
        const double noise = study::candidate_noise(list.study.model.sensors[i].quantity, foretold[0].values[i]);
        Separating s{.reading = list.names[i],
                     .unit = std::string(list.study.response_unit(i)),
                     .sigma = noise / si,
                     .values = {},
                     .power = 1.0,
                     .rate_now = 1.0};
        for (std::size_t e = 0; e < foretold.size(); ++e) {
            s.values.push_back(foretold[e].values[i] / si);
            if (e == 0) {
                continue;
            }
            // Now: the difference of chi2; the new reading adds its own.
            const double now = std::max(0.0, d.explanations[e].behind);
            const double more = std::pow(foretold[e].values[i] - foretold[0].values[i], 2) /
                                (noise * noise + foretold[0].variances[i] + foretold[e].variances[i]);
            s.power = std::min(s.power, gsl_cdf_ugaussian_P(std::sqrt(now + more) / 2.0));
            s.rate_now = std::min(s.rate_now, gsl_cdf_ugaussian_P(std::sqrt(now) / 2.0));
        }
        readings.push_back(std::move(s));
    }
    std::stable_sort(readings.begin(), readings.end(), [](const auto& a, const auto& b) { return a.power > b.power; });
    return readings;
}

int diagnose_study(const DiagnoseOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    study::Study own = study::load_study(options.common.study);
    own.model.settings.layered = false; // most effects are beyond that engine, and models are compared by one engine
    const study::Study& study = own;
    const problem::Problem baseline = study::make_noise_problem(study, study::Scope::fitted);
    for (const std::string& name : options.without) {
        study::effect_named(name, {.key = "--without"});
    }
    const std::vector<study::Variant> variants = study::variants(study, options.without);
    const Layout layout = layout_of(study);
    const std::string folder = options.common.folder(study);
    std::optional<ReducedProblem> reduced;
    if (options.model.reduced()) {
        reduced = reduced_problem(baseline, study, options.model, folder, options.common.threads);
        if (!reduced) {
            return report_interrupt(folder);
        }
    }
    const std::string settings = fmt::format("{} explored{}, {} starts, {} simulated, seed {}",
                                             options.analysis.explore, reduced ? reduced->settings : "",
                                             options.analysis.starts, options.analysis.bootstrap, options.common.seed);
    run::Store store(folder, session(options.common));
    const auto extended_study = [&](const Members& members) {
        return study::with_free_effects(study, variants_of(variants, members));
    };
    diagnose::Workbench bench({.problem =
                                   [&](const Members& members) {
                                       return study::make_noise_problem(extended_study(members), study::Scope::fitted);
                                   },
                               .run =
                                   [&](const Members& members) {
                                       return store.begin(run_header(extended_study(members), "diagnose", settings));
                                   },
                               .store = &store,
                               .threads = options.common.threads});
    diagnose::DiagnosisTask task{.bench = bench,
                                 .candidates = {},
                                 .noise_is_stated = study.noise == study::NoiseSource::stated,
                                 .groups = layout.groups,
                                 .places = layout.places,
                                 .loads = layout.loads,
                                 .seed = options.common.seed};
    for (const study::Variant& variant : variants) {
        const auto& effect = *variant.applied.effect;
        const problem::Axis axis = study::size_axis(effect);
        diagnose::Candidate candidate{.effect = std::string(effect.name),
                                      .on = variant.on,
                                      .null = axis.unit(effect.null),
                                      .typical = axis.unit(effect.typical),
                                      .reading = {}};
        if (variant.applied.reading) {
            candidate.reading =
                std::find(layout.rows.begin(), layout.rows.end(), static_cast<std::size_t>(*variant.applied.reading)) -
                layout.rows.begin();
        }
        task.candidates.push_back(std::move(candidate));
    }
    if (reduced) {
        task.explore = [&](const search::Design& sample) {
            run::Engine engine(reduced->problem, &store, store.begin(run_header(study, "explore", settings)),
                               {.threads = options.common.threads, .show_progress = true});
            return engine.evaluate(sample);
        };
    }
    const auto result = diagnose::diagnose(task, options.analysis);
    if (!result) {
        return report_interrupt(folder);
    }
    const Diagnosis& d = *result;
    if (!d.failed.empty()) {
        if (options.common.json) {
            fmt::print("{}\n", report::json_text({{"status", "failed"}, {"reason", d.failed}}));
        }
        run::message("pavescape: {}\n", d.failed);
        return computation_failed;
    }
    const Reported before = report_of(study, variants, bench, d.baseline, d.variance);
    std::optional<Reported> after;
    std::string extended_path;
    if (d.extended) {
        after = report_of(study, variants, bench, *d.extended, d.variance);
        if (d.verdict != Verdict::unexplained) {
            extended_path = folder + "/extended.toml";
            write_file(folder, "extended.toml",
                       study::extended_text(after->study, variants_of(variants, d.extended->model.members),
                                            d.extended->model.evaluation.parameters, folder));
        }
    }
    const auto next =
        d.explanations.size() > 1 ? separating_readings(study, variants, bench, d) : std::vector<Separating>{};
    std::vector<std::optional<double>> held_out;
    for (std::size_t e = 0; e < d.explanations.size(); ++e) {
        const bool is_known = e == 0 || !before.held_out_rms; // the first is the extended model
        held_out.push_back(is_known
                               ? after->held_out_rms
                               : report_of(study, variants, bench, d.explanations[e].fit, d.variance).held_out_rms);
    }
    const Findings findings{study, variants, task.candidates, layout, d, before, after, next, held_out, extended_path};
    Json json = diagnosis_json(findings);
    json["study"] = {{"file", study.file}, {"title", study.title}, {"hash", study.hash}};
    json["version"] = PAVESCAPE_VERSION;
    json["seed"] = options.common.seed;
    json["model"] = options.model.model;
    if (reduced) {
        json["reduced_model"] = reduced->json;
    }
    json["run"] = folder;
    store.put_result(store.begin(run_header(study, "diagnose", settings)), report::json_text(json, -1));
    write_file(folder, "diagnose.json", report::json_text(json) + "\n");
    const std::string text = diagnosis_page(findings);
    write_file(folder, "diagnose.txt", text);
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
        return done;
    }
    const run::Tally tally = bench.tally();
    fmt::print("{}\n  {} computed in {}, {} kept from before\n{}\n{}\n  results: {}/diagnose.json, this page: "
               "{}/diagnose.txt\n",
               study_summary(study), counted(static_cast<std::size_t>(tally.computed), "run", "runs"),
               run::duration_words(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()),
               tally.kept,
               reduced ? fmt::format("{}  {} explored by the reduced model, all below is the full model's\n",
                                     reduced->words,
                                     counted(static_cast<std::size_t>(options.analysis.explore), "point", "points"))
                       : "",
               text, folder, folder);
    if (!extended_path.empty()) {
        fmt::print("  the extended study: {}\n", extended_path);
    }
    return done;
}

} // namespace

void add_diagnose(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("diagnose", "what the simulation gets wrong, the cause, the extended model, the gain");
    auto options = std::make_shared<DiagnoseOptions>();
    add_common(*command, options->common);
    add_model(*command, options->model, false); // effects change what a reduced model is made for
    command
        ->add_option("--without", options->without,
                     "NAME: an effect that is known not to be there (repeatable; `pavescape effects` lists them)")
        ->expected(1)
        ->take_all();
    command->add_option("--explore", options->analysis.explore, "points of the Sobol sample for the study's model")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command->add_option("--starts", options->analysis.starts, "local searches of the study's model")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    command->add_option("--bootstrap", options->analysis.bootstrap, "simulated data that weigh the evidence")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command->footer("Example: pavescape diagnose grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return diagnose_study(*options); }; });
}

} // namespace explore::cli

#include "report/fit.h"

#include "analysis/common/knowledge_words.h"
#include "analysis/explore/build.h"
#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "report/answer.h"
#include "report/curves.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::FitResult;
using analysis::GroupFit;
using landscape::Minimum;
using pave::counted;
using pave::figure;

Json group_json(const FitResult& result) {
    const study::Study& study = result.study;
    const auto fit_json = [&](const GroupFit& fit) {
        Json rms = Json::object();
        for (std::size_t g = 0; g < study.groups.size(); ++g) {
            rms[study.groups[g].name] = fit.rms[g];
        }
        Json json = {{"fitted", fit.fitted}};
        json.update(minimum_json(study.space, fit.minimum, fit.local));
        json["rms"] = std::move(rms);
        return json;
    };
    Json groups = Json::array();
    for (std::size_t g = 0; g < study.groups.size(); ++g) {
        groups.push_back({{"name", study.groups[g].name},
                          {"readings", study.groups[g].rows.size()},
                          {"weight", study.groups[g].weight},
                          {"held_out", study.groups[g].held_out},
                          {"rms", result.joint->rms[g]}});
    }
    Json fits = Json::array();
    for (const GroupFit& fit : result.alone) {
        fits.push_back(fit_json(fit));
    }
    return {{"groups", std::move(groups)}, {"alone", std::move(fits)}};
}

std::string group_text(const FitResult& result) {
    const study::Study& study = result.study;
    const GroupFit& joint = *result.joint;
    const std::vector<GroupFit>& alone = result.alone;
    std::string text =
        "\nGroups of readings: root mean square residual of each, at the best fit of all and of each alone\n";
    std::vector<std::string> header{"group", "readings", "weight", "all"};
    for (const GroupFit& fit : alone) {
        header.push_back(fit.fitted + " alone");
    }
    Table table(header);
    for (std::size_t g = 0; g < study.groups.size(); ++g) {
        const auto& group = study.groups[g];
        std::vector<std::string> row{group.name, fmt::format("{}", group.rows.size()),
                                     group.held_out ? "held out" : figure(group.weight), figure(joint.rms[g])};
        for (const GroupFit& fit : alone) {
            row.push_back(figure(fit.rms[g]) + (fit.fitted == group.name ? " (fitted)" : ""));
        }
        table.add(std::move(row));
    }
    text += table.text();
    if (!alone.empty()) {
        Table parameters(with_axes({"fitted"}, study.space));
        const auto add = [&](const GroupFit& fit) {
            std::vector<std::string> row{fit.fitted};
            for (const double value : fit.best.parameters) {
                row.push_back(figure(value));
            }
            parameters.add(std::move(row));
        };
        add(joint);
        for (const GroupFit& fit : alone) {
            add(fit);
        }
        text += parameters.text();
    }
    return text;
}

} // namespace

Json fit_json(const FitResult& result, const analysis::RunOptions& run) {
    const Json statuses = status_counts(result.searches.explored);
    if (result.failed()) {
        return {{"status", "failed"}, {"reason", result.reason()}, {"statuses", statuses}};
    }
    const study::Study& study = result.study;
    const problem::ParameterSpace& space = result.problem.space;
    const landscape::LocalAnalysis& local = result.local;
    const Minimum& best = result.best();
    const int evaluations = landscape::search_evaluations(result.searches.ends);
    Json json = {{"best", minimum_json(space, best, local)},
                 {"minima", Json::array()},
                 {"evaluations", static_cast<std::int64_t>(result.design.points.size()) + evaluations},
                 {"search_evaluations", evaluations},
                 {"starts", result.searches.ends.size()},
                 {"explored", result.design.name},
                 {"model", result.options.model.name()},
                 {"scheme", analysis::scheme_names[static_cast<int>(result.options.scheme)]},
                 {"method", result.options.multistart.method},
                 {"seed", run.seed},
                 {"study", study_json(study)},
                 {"version", analysis::version},
                 {"statuses", statuses},
                 {"misfit_kind", std::string(to_string(study.data.misfit))},
                 {"noise",
                  {{"source", study.noise_name()},
                   {"residual_standard_deviation", local.noise},
                   {"degrees_of_freedom", local.degrees_of_freedom},
                   {"chi2", local.noise_is_stated ? Json(local.chi2) : Json(nullptr)},
                   {"p_value", local.noise_is_stated ? Json(local.p_value) : Json(nullptr)},
                   {"widened", local.widened}}},
                 {"findings", findings(result)},
                 {"responses", responses_json(study, best.evaluation.responses)},
                 {"warnings", warnings_json(best.evaluation)},
                 {"run", run.folder}};
    if (result.reduced) {
        json["reduced_model"] = reduced_json(*result.reduced);
    }
    if (!result.problem.limits.empty()) {
        json["constraints"] = constraints_json(result.problem, best.evaluation);
        json["contradicts_constraints"] = analysis::active_constraints(result.problem, best).contradicted;
    }
    if (result.priors) {
        json["priors"] = priors_json(result.problem, best.evaluation.parameters, *result.priors);
    }
    add_residuals(json["responses"], study, result.problem, best.evaluation, local.noise);
    if (const auto scale = result.noise_scale()) {
        json["noise"]["scale"] = noise_scale_json(*scale);
    }
    if (result.problem.noise_is_student()) {
        json["noise"]["loss"] = "student";
        json["noise"]["degrees"] = result.problem.noise_degrees();
        json["noise"]["expected_chi2"] = local.expected_chi2;
        const std::vector<double> weights = analysis::reading_weights(result.problem, best.evaluation);
        for (std::size_t i = 0; i < weights.size(); ++i) {
            json["responses"][result.problem.response_of(i)]["weight"] = weights[i];
        }
    }
    for (const analysis::SensorDrift& drift : result.drifts) {
        constexpr double um_per_ms = pave::unit::um / pave::unit::ms;
        const auto& sensor = study.model.sensors[drift.reading];
        json["drift"].push_back({{"load", study.model.loads[static_cast<std::size_t>(sensor.load)].name},
                                 {"x_mm", sensor.x / pave::unit::mm},
                                 {"um_per_ms", drift.rate / um_per_ms},
                                 {"standard_error", drift.deviation / um_per_ms}});
    }
    json["curves"] = curves_json(result.curves);
    add_model_errors(json, study, result.mesh, result.path);
    json["readings"] = result.problem.readings();
    json["free_parameters"] = space.axes.size() - best.on_bound.size();
    json["at_bounds"] = Json::array();
    for (const auto& bound : best.on_bound) {
        json["at_bounds"].push_back(space.axes[bound.axis].name);
    }
    if (result.held.any()) {
        for (const std::size_t i : result.held.limits) {
            json["best"]["held_by"].push_back(result.problem.limits[i]->text());
        }
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            if (const auto range = result.held.of(k)) {
                const problem::Axis& axis = space.axes[k];
                json["best"]["ranges_95"][axis.name] = {axis.physical(range->low), axis.physical(range->high)};
                json["best"]["standard_errors"][axis.name] = nullptr;
            }
        }
    }
    json["best"]["std_error"] = json["best"]["standard_errors"];
    for (const auto& name : json["at_bounds"]) {
        json["best"]["std_error"][name.get<std::string>()] = nullptr;
    }
    json["best"]["not_determined"] = Json::array();
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        if (result.leaves_unknown(k)) {
            json["best"]["not_determined"].push_back(space.axes[k].name);
            json["best"]["std_error"][space.axes[k].name] = nullptr;
        }
    }
    json.update(group_json(result));
    json["parameters"] = space_json(space);
    json["ends"] = Json::array();
    for (const run::Endpoint& end : result.searches.ends) {
        if (!end.search.unit.empty()) {
            json["ends"].push_back({{"start", end.start},
                                    {"misfit", end.search.misfit},
                                    {"evaluations", end.search.evaluations},
                                    {"converged", end.search.converged},
                                    {"ended", end.search.ended}});
        }
    }
    json["best"]["status"] = std::string(to_string(best.evaluation.status));
    for (const Minimum& m : result.searches.minima) {
        json["minima"].push_back(minimum_json(result.problem, m));
    }
    json["answer"] = answer_of("fit", json).verdict;
    return json;
}

std::string fit_text(const FitResult& result, const analysis::RunOptions& run) {
    const study::Study& study = result.study;
    const problem::Problem& problem = result.problem;
    const landscape::LocalAnalysis& local = result.local;
    const auto& ends = result.searches.ends;
    const Minimum& best = result.best();
    const int evaluations = landscape::search_evaluations(result.searches.ends);
    const run::Tally& tally = result.tally;
    std::string text = study_summary(study) + sentences(findings(result)) + "\n";
    text += fmt::format("Explored {}, then {} searches by {} ({} evaluations, {:.0f} a search)\n", result.design.name,
                        ends.size(), result.options.multistart.method, evaluations,
                        static_cast<double>(evaluations) / static_cast<double>(ends.size()));
    text += fmt::format("  {} computed in {} ({:.1f} runs/s), {} kept from before\n",
                        counted(static_cast<std::size_t>(tally.computed), "run", "runs"),
                        run::duration_words(tally.seconds),
                        tally.seconds > 0.0 ? static_cast<double>(tally.computed) / tally.seconds : 0.0, tally.kept);
    if (result.reduced) {
        text +=
            fmt::format("{}  {}\n", reduced_words(*result.reduced),
                        result.options.model.alone()
                            ? "the fit below is that of the reduced model; --model auto refines it with the full one"
                            : fmt::format("{} explored by the reduced model in {}, all below is the full model's",
                                          counted(result.design.points.size(), "point", "points"),
                                          run::duration_words(result.seconds_by_reduced_model)));
    }
    const Json statuses = status_counts(result.searches.explored);
    for (const auto& [status, count] : statuses.items()) {
        if (status != "converged" && count.get<std::int64_t>() > 0) {
            text += fmt::format("    {} of the explored points: {}\n", count.get<std::int64_t>(), status);
        }
    }
    text += fmt::format("\nBest fit: misfit f = {} ({} residuals, root mean square {})\n",
                        figure(best.evaluation.misfit), to_string(study.data.misfit),
                        figure(best.evaluation.misfit / std::sqrt(static_cast<double>(problem.rows()))));
    Table parameters({"parameter", "value", "std. error", "min", "max"});
    for (std::size_t k = 0; k < best.unit.size(); ++k) {
        const problem::Axis& axis = problem.space.axes[k];
        const double error = local.standard_error[k] * axis.d_physical(best.unit[k]);
        const auto held = result.held.of(k);
        parameters.add(
            {axis.name, figure(best.evaluation.parameters[k]),
             held ? fmt::format("95 %: {} to {}", figure(axis.physical(held->low)), figure(axis.physical(held->high)))
             : landscape::is_at_bound(best.unit[k]) ? "at bound"
             : result.leaves_unknown(k)             ? "not determined"
                                                    : figure(error),
             figure(axis.low), figure(axis.high)});
    }
    std::map<std::size_t, double> weights; // of responses
    if (problem.noise_is_student()) {
        const std::vector<double> each = analysis::reading_weights(problem, best.evaluation);
        for (std::size_t i = 0; i < each.size(); ++i) {
            weights[problem.response_of(i)] = each[i];
        }
    }
    text += parameters.text() + "\n" + response_table(study, best.evaluation.responses, weights);
    text += warning_lines(best.evaluation);
    if (study.groups.size() > 1) {
        text += group_text(result);
    }
    text += fmt::format("\n{} found\n", counted(result.searches.minima.size(), "distinct minimum", "distinct minima"));
    Table minima(with_axes({"misfit", "starts"}, problem.space, {"remark"}));
    for (const Minimum& m : result.searches.minima) {
        std::vector<std::string> row{figure(m.evaluation.misfit),
                                     fmt::format("{} of {}", m.members.size(), ends.size())};
        for (const double value : m.evaluation.parameters) {
            row.push_back(figure(value));
        }
        std::string remark = pave::join(bound_words(problem.space, m.on_bound));
        if (!m.converged) {
            remark += (remark.empty() ? "" : "; ") + std::string("not converged: ") +
                      ends[static_cast<std::size_t>(m.members[0])].search.ended;
        }
        row.push_back(remark);
        minima.add(std::move(row));
    }
    text += minima.text();
    return text + fmt::format("\n  results: {}/fit.json; every evaluation: pavescape export {} --command fit\n",
                              run.folder, run::shell_word(run.folder));
}

} // namespace explore::report

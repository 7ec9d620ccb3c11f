#include "report/unique.h"

#include "analysis/common/range_shape.h"
#include "analysis/explore/build.h"
#include "base/error.h"
#include "base/text.h"
#include "report/curves.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::UniqueResult;
using landscape::Branch;
using landscape::Range;
using landscape::Uniqueness;
using landscape::WalkEnd;
using pave::counted;
using pave::figure;

// Why a walk ended, for a table: "base.k2 max"; bounds of the parameter `own` left out.
std::string short_words(const problem::ParameterSpace& space, WalkEnd end, const std::vector<landscape::BoundMet>& met,
                        std::optional<std::size_t> own = {}) {
    std::vector<std::string> bounds;
    for (const landscape::BoundMet& bound : met) {
        if (bound.axis != own) {
            bounds.push_back(space.axes[bound.axis].name + (bound.upper ? " max" : " min"));
        }
    }
    return analysis::end_words(end, bounds);
}

// The same where a constraint that is no equality holds back there.
std::string with_constraint(const std::string& words, const problem::Problem& problem,
                            const std::vector<std::size_t>& limits) {
    const bool holds =
        std::any_of(limits.begin(), limits.end(), [&](std::size_t i) { return !problem.limits[i]->is_equality(); });
    return holds ? words + ", a constraint" : words;
}

Json posterior_json(const analysis::PosteriorRange& range, double to_unit) {
    return {{"low", range.low / to_unit}, {"high", range.high / to_unit}, {"differs_by", range.reason}};
}

Json branch_json(const Branch& branch, double to_unit, const std::function<double(double)>& physical) {
    Json points = Json::array();
    for (const auto& p : branch.points) {
        points.push_back({physical(p.value) / to_unit, p.rise});
    }
    return points;
}

Json landscape_json(const analysis::UniqueLandscape& landscape, const problem::ParameterSpace& space) {
    const auto values = [&](const landscape::Slice& slice, std::size_t a) {
        Json list = Json::array();
        for (const double unit : slice.lines[a]) {
            list.push_back(space.axes[slice.axes[a]].physical(unit));
        }
        return list;
    };
    const auto rise = [](double value) { return std::isnan(value) ? Json(nullptr) : Json(value); };
    Json json = {{"model", landscape.by_reduced_model ? "reduced" : "full"},
                 {"limit", landscape.limit},
                 {"lower_by", landscape.profiled.lower_by},
                 {"runs", landscape.runs},
                 {"pairs", Json::array()},
                 {"profiles", Json::array()}};
    for (const landscape::Slice& slice : landscape.profiled.pairs) {
        Json rows = Json::array();
        const std::size_t width = slice.lines[0].size();
        for (std::size_t j = 0; j < slice.lines[1].size(); ++j) {
            Json row = Json::array();
            for (std::size_t i = 0; i < width; ++i) {
                row.push_back(rise(slice.rise[j * width + i]));
            }
            rows.push_back(std::move(row));
        }
        json["pairs"].push_back({{"x", space.axes[slice.axes[0]].name},
                                 {"y", space.axes[slice.axes[1]].name},
                                 {"x_values", values(slice, 0)},
                                 {"y_values", values(slice, 1)},
                                 {"rise", std::move(rows)}});
    }
    for (const landscape::Slice& slice : landscape.profiled.single) {
        Json list = Json::array();
        std::transform(slice.rise.begin(), slice.rise.end(), std::back_inserter(list), rise);
        json["profiles"].push_back(
            {{"name", space.axes[slice.axes[0]].name}, {"values", values(slice, 0)}, {"rise", std::move(list)}});
    }
    return json;
}

Json answer_json(const UniqueResult& result) {
    const study::Study& study = result.study;
    const problem::Problem& problem = result.problem;
    const Uniqueness& u = result.answer;
    const analysis::NextReading& next = result.next;
    const auto& space = problem.space;
    const auto outputs = study.outputs();
    Json json = {{"verdict", landscape::verdict_names[static_cast<int>(u.verdict)]},
                 {"alternatives", u.alternatives},
                 {"valley", u.valley},
                 {"missing", u.missing},
                 {"directions", Json::array()},
                 {"minima", Json::array()},
                 {"outputs", Json::array()},
                 {"unseen_volume_bound", u.unseen.volume_bound}};
    for (std::size_t i = 0; i < u.directions.vectors.size(); ++i) {
        const bool flat = std::find(u.directions.flat.begin(), u.directions.flat.end(), i) != u.directions.flat.end();
        Json vector = Json::object();
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            vector[space.axes[k].name] = u.directions.vectors[i][static_cast<Eigen::Index>(k)];
        }
        json["directions"].push_back(
            {{"singular_value", u.directions.singular_values[i]}, {"flat", flat}, {"vector", vector}});
    }
    Json combinations = Json::array();
    for (const auto& c : u.directions.fixed) {
        Json terms = {{space.axes[c.leading].name, 1.0}};
        for (const auto& t : c.others) {
            terms[space.axes[t.axis].name] = t.coefficient;
        }
        combinations.push_back({{"words", analysis::combination_words(study, c, u.directions.unit)},
                                {"coefficients", terms},
                                {"standard_error", c.standard_error}});
    }
    json["spectrum"] = {{"collinearity_index", u.directions.collinearity},
                        {"not_determined", analysis::names_of(space, u.directions.free)},
                        {"dead", analysis::names_of(space, u.directions.dead)},
                        {"fixed_combinations", combinations}};
    for (std::size_t m = 0; m < u.minima.size(); ++m) {
        Json minimum = minimum_json(problem, u.minima[m]);
        minimum["accepted"] = std::find(u.accepted.begin(), u.accepted.end(), m) != u.accepted.end();
        minimum["alternative"] =
            std::find(u.alternative_of.begin(), u.alternative_of.end(), m) != u.alternative_of.end();
        json["minima"].push_back(std::move(minimum));
    }
    json["passes"] = Json::array();
    for (const auto& p : u.passes) {
        Json way = Json::array();
        for (const auto& point : p.pass.way) {
            way.push_back({{"parameters", parameters_json(space, space.physical(point.unit))}, {"rise", point.rise}});
        }
        json["passes"].push_back({{"a", p.a}, {"b", p.b}, {"rise", p.pass.rise}, {"way", way}});
    }
    if (!problem.limits.empty()) {
        json["constraints"] = constraints_json(problem, u.minima[0].evaluation);
    }
    if (u.priors) {
        json["priors"] = priors_json(problem, u.minima[0].evaluation.parameters, *u.priors);
        json["only_by_prior"] = analysis::names_of(space, u.priors->only);
    }
    if (u.acceptance) {
        json["acceptance"] = {{"noise", u.acceptance->noise_is_stated ? "stated" : "estimated"},
                              {"degrees_of_freedom", u.acceptance->degrees_of_freedom},
                              {"residual_variance", u.acceptance->variance},
                              {"chi2_rise_allowed", u.acceptance->threshold},
                              {"widened", u.acceptance->widened}};
        if (u.acceptance->noise_is_stated) {
            json["acceptance"]["chi2"] = u.acceptance->chi2;
            json["acceptance"]["p_value"] = u.acceptance->p_value;
        }
        if (problem.noise_scale_is_sought()) {
            json["acceptance"]["noise_scale"] = noise_scale_json(noise_scale_of(*u.acceptance));
        }
    }
    const auto range_json = [&](const Range& range, double to_unit, const std::function<double(double)>& physical) {
        Json branches = Json::array();
        for (const auto& b : range.branches) {
            branches.push_back(branch_json(b, to_unit, physical));
        }
        return Json{
            {"low", range.low / to_unit},
            {"high", range.high / to_unit},
            {"kind", landscape::profile_kind_names[static_cast<int>(kind_of(range))]},
            {"low_stopped_by", analysis::end_words(problem, range.low_end, range.low_bounds, range.low_limits)},
            {"high_stopped_by", analysis::end_words(problem, range.high_end, range.high_bounds, range.high_limits)},
            {"low_set", parameters_json(space, range.low_set)},
            {"high_set", parameters_json(space, range.high_set)},
            {"profile", branches}};
    };
    json["profiles"] = Json::array();
    const auto shapes = analysis::range_shapes(result.problem, u);
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        Json profile = {{"name", space.axes[k].name}, {"best", u.minima[0].evaluation.parameters[k]}};
        profile.update(range_json(u.parameters[k], 1.0, [&](double unit) { return space.axes[k].physical(unit); }));
        if (const auto& shape = shapes[k]) {
            profile["first_order"] = {{"low", shape->gaussian_low},
                                      {"high", shape->gaussian_high},
                                      {"ratio", shape->ratio},
                                      {"differs_by", shape->reason}};
        }
        if (result.posterior && k < result.posterior->parameters.size()) {
            profile["posterior"] = posterior_json(result.posterior->parameters[k], 1.0);
        }
        json["profiles"].push_back(std::move(profile));
    }
    for (std::size_t o = 0; o < u.outputs.size(); ++o) {
        const data::Reading& reading = study.readings[outputs[o]];
        Json output = {{"name", reading.output},
                       {"best", reading.in_unit(u.minima[0].evaluation.responses[outputs[o]])},
                       {"unit", reading.unit.name}};
        output.update(range_json(u.outputs[o], reading.unit.to_si, [](double value) { return value; }));
        for (const auto& wide : result.outputs) {
            if (wide.reading == outputs[o]) {
                output["if_wrong"] = output_range_json(reading, wide)["if_wrong"];
            }
        }
        if (result.posterior && o < result.posterior->outputs.size()) {
            output["posterior"] = posterior_json(result.posterior->outputs[o], reading.unit.to_si);
        }
        json["outputs"].push_back(std::move(output));
    }
    json["traces"] = Json::array();
    for (const Branch& trace : u.traces) {
        Json points = Json::array();
        for (const auto& p : trace.points) {
            points.push_back({{"parameters", parameters_json(space, p.evaluation.parameters)}, {"rise", p.rise}});
        }
        json["traces"].push_back(
            {{"stopped_by", analysis::end_words(problem, trace.end, trace.on_bound, trace.on_limit)},
             {"points", points}});
        if (u.acceptance) {
            json["traces"].back()["accepted_end"] = parameters_json(space, space.physical(trace.limit_unit));
        }
    }
    if (u.conflict) {
        Json alone = Json::array();
        const std::vector<std::string> names = study.groups_fitted();
        for (const auto& g : u.conflict->alone) {
            alone.push_back({{"group", names[g.group]},
                             {"misfit", g.misfit},
                             {"directions_determined", g.rank},
                             {"parameters", parameters_json(space, g.parameters)}});
        }
        json["conflict"] = {{"statistic", u.conflict->statistic},
                            {"degrees_of_freedom", u.conflict->degrees_of_freedom},
                            {"p_value", u.conflict->p_value},
                            {"alone", alone}};
    }
    Json ends = Json::array();
    for (const auto& e : u.ends) {
        ends.push_back({{"start", e.start},
                        {"end", landscape::end_kind_names[static_cast<int>(e.kind)]},
                        {"why", e.unfinished.empty() ? pave::join(bound_words(space, e.bounds)) : e.unfinished},
                        {"minimum", e.minimum},
                        {"evaluations", e.evaluations}});
    }
    json["ends"] = ends;
    json["unseen"] = {{"independent_starts", u.unseen.starts},
                      {"since_last_new_minimum", u.unseen.since_new},
                      {"volume_bound_95", u.unseen.volume_bound},
                      {"boender_rinnooy_kan_volume", u.unseen.volume_mean},
                      {"boender_rinnooy_kan_minima", u.unseen.expected_minima},
                      {"chao_minima", u.unseen.chao}};
    Json tree = Json::array();
    for (const auto& m : u.tree) {
        tree.push_back({{"parameters", parameters_json(space, space.physical(u.sample.points[m.point]))},
                        {"misfit", m.misfit},
                        {"pass", m.pass},
                        {"joins", m.joins},
                        {"basin_points", m.basin}});
    }
    json["merge_tree"] = tree;
    Json projections = Json::array();
    for (const auto& p : u.projections) {
        projections.push_back(
            {{"x", space.axes[p.x].name}, {"y", space.axes[p.y].name}, {"cells", p.cells}, {"misfit", p.misfit}});
    }
    json["projections"] = projections;
    if (result.landscape) {
        json["landscape"] = landscape_json(*result.landscape, space);
    }
    Json candidates = Json::array();
    for (const auto& e : next.effects) {
        Json parameters = Json::object();
        for (std::size_t k = 0; k < e.parameters.size(); ++k) {
            parameters[space.axes[k].name] = e.parameters[k];
        }
        Json of_outputs = Json::object();
        for (std::size_t o = 0; o < e.predictions.size(); ++o) {
            of_outputs[study.readings[outputs[o]].output] = e.predictions[o];
        }
        const data::Reading& reading = next.candidates[e.candidate];
        Json candidate = {{"reading", reading.words()},
                          {"value", reading.value},
                          {"sigma", reading.in_unit(reading.noise.absolute)},
                          {"unit", reading.unit.name},
                          {"gain", e.gain},
                          {"standard_error_after_over_before", parameters},
                          {"outputs_after_over_before", of_outputs}};
        if (!next.separation.empty()) {
            candidate["valley_ends_apart_sigmas"] = next.separation[e.candidate];
        }
        candidates.push_back(std::move(candidate));
    }
    json["next_measurement"] = candidates;
    return json;
}

} // namespace

Json unique_json(const UniqueResult& result, const analysis::RunOptions& run) {
    const Uniqueness& u = result.answer;
    if (result.failed()) {
        return {{"status", "failed"}, {"reason", result.reason()}, {"statuses", status_counts(u.explored)}};
    }
    const study::Study& study = result.study;
    Json json = answer_json(result);
    json["noise"] = {{"source", study.noise_name()}};
    json["misfit_kind"] = std::string(to_string(study.data.misfit)) +
                          (study.noise == study::NoiseSource::stated ? ", residuals in standard deviations" : "");
    json["model"] = result.options.model.name();
    if (result.reduced) {
        json["reduced_model"] = reduced_json(*result.reduced);
    }
    json["findings"] = findings(result);
    json["warnings"] = warnings_json(result.best().evaluation);
    json["parameters"] = space_json(result.problem.space);
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        const Range& range = u.parameters[k];
        json["parameters"][k].update(
            {{"best", result.best().evaluation.parameters[k]},
             {"low", range.low},
             {"high", range.high},
             {"low_end", analysis::end_words(result.problem, range.low_end, range.low_bounds, range.low_limits)},
             {"high_end", analysis::end_words(result.problem, range.high_end, range.high_bounds, range.high_limits)}});
    }
    json["responses"] = responses_json(study, result.best().evaluation.responses);
    add_residuals(json["responses"], study, result.problem, result.best().evaluation,
                  u.acceptance ? u.acceptance->noise() : 0.0);
    json["curves"] = curves_json(result.curves);
    add_model_errors(json, result.study, result.mesh, result.path);
    json["statuses"] = status_counts(u.explored);
    json["study"] = study_json(study);
    json["version"] = analysis::version;
    json["seed"] = run.seed;
    json["run"] = run.folder;
    return json;
}

std::string unique_text(const UniqueResult& result, const analysis::RunOptions& run) {
    const study::Study& study = result.study;
    const problem::ParameterSpace& space = result.problem.space;
    const Uniqueness& u = result.answer;
    const analysis::NextReading& next = result.next;
    const auto outputs = study.outputs();
    std::string text = fmt::format(
        "{}{}{}\n  {} explored, {}; {} computed in {}, {} kept from before\n{}", study_summary(study),
        sentences(findings(result)), warning_lines(result.best().evaluation), u.sample.name,
        counted(u.ends.size(), "search", "searches"), counted(static_cast<std::size_t>(result.computed), "run", "runs"),
        run::duration_words(result.seconds), result.kept, result.reduced ? reduced_words(*result.reduced) : "");
    if (result.options.model.confirmed()) {
        text += fmt::format("    {} more by the reduced model, which explored and searched\n",
                            counted(static_cast<std::size_t>(result.computed_by_reduced_model), "run", "runs"));
    }
    if (result.landscape) {
        const landscape::ProfiledLandscape& profiled = result.landscape->profiled;
        const std::size_t nodes =
            profiled.pairs.empty() ? 0 : profiled.pairs.size() * profiled.pairs.front().rise.size();
        text += fmt::format("    landscape: {} of pairs of parameters, the others fitted, by {} of the {} model\n",
                            counted(nodes, "node", "nodes"),
                            counted(static_cast<std::size_t>(result.landscape->runs), "run", "runs"),
                            result.landscape->by_reduced_model ? "reduced" : "full");
    }
    if (result.computed > 0 && !result.reduced) { // else it was built too
        const double cpu = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
        text += fmt::format("    {:.1f} % of the processor time outside forward runs\n",
                            100.0 * std::max(0.0, 1.0 - result.forward_cpu_seconds / cpu));
    }
    for (std::size_t kind = 0; kind < std::size(landscape::end_kind_names); ++kind) {
        const auto count = std::count_if(u.ends.begin(), u.ends.end(),
                                         [&](const auto& e) { return static_cast<std::size_t>(e.kind) == kind; });
        if (count > 0) {
            text += fmt::format("    {} ended: {}\n", count, landscape::end_kind_names[kind]);
        }
    }
    if (!u.parameters.empty()) {
        text += fmt::format("\nWhat the data accept (95 %)\n");
        if (!outputs.empty()) {
            text += fmt::format("  {}\n", signs(study));
        }
        Table table({"", "best", "low", "high", "unit", "", "low end set by", "high end set by"});
        for (std::size_t k = 0; k < u.parameters.size(); ++k) {
            const Range& r = u.parameters[k];
            const auto stopped = [&](double limit, WalkEnd end, const std::vector<landscape::BoundMet>& bounds) {
                constexpr double close = 1e-3; // a walk need not meet its bound to the last digit
                const double unit = space.axes[k].unit(limit);
                return end == WalkEnd::bound && (unit < close || unit > 1.0 - close)
                           ? std::string("its bound")
                           : short_words(space, end, bounds, k);
            };
            table.add({space.axes[k].name, figure(result.best().evaluation.parameters[k]), figure(r.low),
                       figure(r.high), "", std::string(landscape::profile_kind_names[static_cast<int>(kind_of(r))]),
                       with_constraint(stopped(r.low, r.low_end, r.low_bounds), result.problem, r.low_limits),
                       with_constraint(stopped(r.high, r.high_end, r.high_bounds), result.problem, r.high_limits)});
        }
        for (std::size_t o = 0; o < u.outputs.size(); ++o) {
            const Range& r = u.outputs[o];
            const data::Reading& output = study.readings[outputs[o]];
            const auto [low, high] = u.acceptance && u.acceptance->widened
                                         ? analysis::widened({r.low, r.high}, result.outputs, outputs[o])
                                         : std::pair(r.low, r.high);
            table.add({output.output, figure(output.in_unit(result.best().evaluation.responses[outputs[o]])),
                       figure(output.in_unit(low)), figure(output.in_unit(high)), std::string(output.unit.name),
                       std::string(landscape::profile_kind_names[static_cast<int>(kind_of(r))]),
                       with_constraint(short_words(space, r.low_end, r.low_bounds), result.problem, r.low_limits),
                       with_constraint(short_words(space, r.high_end, r.high_bounds), result.problem, r.high_limits)});
        }
        text += table.text();
    }
    if (!u.directions.singular_values.empty()) {
        text +=
            fmt::format("\nDirections at the best minimum (data moved by crossing the box, in standard deviations)\n");
        Table table(with_axes({"moved", ""}, space));
        for (std::size_t i = 0; i < u.directions.vectors.size(); ++i) {
            const bool flat =
                std::find(u.directions.flat.begin(), u.directions.flat.end(), i) != u.directions.flat.end();
            std::vector<std::string> row{figure(u.directions.singular_values[i]), flat ? "flat" : ""};
            for (const double v : u.directions.vectors[i]) {
                row.push_back(fmt::format("{:+.2f}", v));
            }
            table.add(std::move(row));
        }
        text += fmt::format("{}  collinearity index {}\n", table.text(), figure(u.directions.collinearity));
    }
    text += fmt::format("\n{} found\n", counted(u.minima.size(), "distinct minimum", "distinct minima"));
    const bool in_deviations = study.noise == study::NoiseSource::stated;
    Table minima(with_axes({"", in_deviations ? "chi" : "misfit", "starts"}, space, {"remark"}));
    for (std::size_t m = 0; m < u.minima.size(); ++m) {
        const auto& minimum = u.minima[m];
        std::vector<std::string> row{fmt::format("{}", m + 1), figure(minimum.evaluation.misfit),
                                     fmt::format("{} of {}", minimum.members.size(), u.ends.size())};
        for (const double value : minimum.evaluation.parameters) {
            row.push_back(figure(value));
        }
        const bool accepted = std::find(u.accepted.begin(), u.accepted.end(), m) != u.accepted.end();
        std::string remark = u.acceptance && !accepted ? "rejected by the data" : "";
        for (const auto& bound : bound_words(space, minimum.on_bound)) {
            remark += (remark.empty() ? "" : "; ") + bound;
        }
        row.push_back(remark + (minimum.converged ? "" : remark.empty() ? "unfinished" : "; unfinished"));
        minima.add(std::move(row));
    }
    text += minima.text();
    if (!next.effects.empty()) {
        text += fmt::format("\nMost informative further readings (remaining standard error)\n  {}\n", sign_convention);
        std::vector<std::string> columns = with_axes({"reading", "value", "noise", "unit"}, space);
        for (const std::size_t i : outputs) {
            columns.push_back(study.readings[i].output);
        }
        Table table(columns);
        constexpr std::size_t shown = 6;
        for (std::size_t i = 0; i < std::min(shown, next.effects.size()); ++i) {
            const auto& e = next.effects[i];
            const data::Reading& reading = next.candidates[e.candidate];
            std::vector<std::string> row{reading.words(), figure(reading.value),
                                         figure(reading.in_unit(reading.noise.absolute)),
                                         std::string(reading.unit.name)};
            for (const auto* list : {&e.parameters, &e.predictions}) {
                for (const double ratio : *list) {
                    row.push_back(fmt::format("{:.0f} %", 100.0 * ratio));
                }
            }
            table.add(std::move(row));
        }
        text += table.text();
    } else if (!next.failed.empty()) {
        text += fmt::format("\nNo further reading could be judged: {}\n", next.failed);
    }
    return text + fmt::format("\n  results: {}/unique.json; every evaluation: pavescape export {} --command unique\n",
                              run.folder, run::shell_word(run.folder));
}

} // namespace explore::report

// pavescape unique: is the answer unique, along what is it not, and what does that do to the outputs?
#include "cli/common.h"
#include "cli/layout.h"
#include "cli/model.h"
#include "landscape/next_measurement.h"
#include "landscape/uniqueness.h"
#include "report/table.h"
#include "run/message.h"
#include "run/progress.h"
#include "study/candidates.h"

#include <chrono>
#include <cmath>
#include <ctime>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using landscape::Branch;
using landscape::Range;
using landscape::Uniqueness;
using landscape::Verdict;
using landscape::WalkEnd;
using report::counted;
using report::figure;
using report::Json;

struct UniqueOptions {
    CommonOptions common;
    ModelOptions model;
    landscape::UniquenessSettings analysis;
};

// "base.k1 * (theta/pa)^base.k2 with theta = 62 kPa": the combination in the terms of the laws. A factor c^k2 is
// (theta/pa)^k2 of Uzan's law at a theta of its own, c^k3 is (tau/pa + 1)^k3.
std::string combination_words(const problem::ParameterSpace& space, const landscape::Combination& c) {
    const auto is_log = [&](std::size_t k) { return space.axes[k].scale == problem::Scale::log; };
    constexpr double pa_kPa = 100.0;
    if (!is_log(c.leading)) {
        std::string text = space.axes[c.leading].name;
        for (const auto& term : c.others) {
            const std::string name =
                is_log(term.axis) ? "ln(" + space.axes[term.axis].name + ")" : space.axes[term.axis].name;
            text +=
                fmt::format(" {} {:.3g} * {}", term.coefficient < 0.0 ? "-" : "+", std::abs(term.coefficient), name);
        }
        return text + fmt::format(" is fixed to {:.2g}", c.standard_error);
    }
    std::string text = space.axes[c.leading].name;
    for (const auto& term : c.others) {
        const std::string& name = space.axes[term.axis].name;
        if (is_log(term.axis)) {
            text += fmt::format(" * {}^{:.3g}", name, term.coefficient);
            continue;
        }
        const double base = std::exp(term.coefficient);
        if (name.ends_with(".k2")) {
            text += fmt::format(" * (theta/pa)^{} at theta = {:.3g} kPa", name, pa_kPa * base);
        } else if (name.ends_with(".k3") && base > 1.0) {
            text += fmt::format(" * (tau/pa + 1)^{} at tau = {:.3g} kPa", name, pa_kPa * (base - 1.0));
        } else {
            text += fmt::format(" * {:.3g}^{}", base, name);
        }
    }
    return text + fmt::format(" is fixed to {:.2g} %", 100.0 * c.standard_error);
}

std::string end_words(WalkEnd end, const std::vector<std::string>& bounds) {
    switch (end) {
    case WalkEnd::threshold: return bounds.empty() ? "the data" : "the data, with " + pave::join(bounds);
    case WalkEnd::bound: return bounds.empty() ? "the box" : pave::join(bounds);
    case WalkEnd::hole: return "points without an answer";
    case WalkEnd::better: return "a lower misfit found";
    case WalkEnd::limit: return "the limit of steps";
    }
    return "";
}

// The same for a table: "base.k2 max".
std::string short_words(WalkEnd end, std::vector<std::string> bounds) {
    for (std::string& bound : bounds) {
        const auto at = bound.find(" at its ");
        bound = bound.substr(0, at) + (bound.find("upper", at) != std::string::npos ? " max" : " min");
    }
    return end_words(end, bounds);
}

// Bounds among them that are not the parameter's own.
std::vector<std::string> of_others(const std::vector<std::string>& bounds, const std::string& own) {
    std::vector<std::string> others;
    for (const auto& b : bounds) {
        if (!b.starts_with(own + " ")) {
            others.push_back(b);
        }
    }
    return others;
}

Json branch_json(const Branch& branch, double to_unit, const std::function<double(double)>& physical) {
    Json points = Json::array();
    for (const auto& p : branch.points) {
        points.push_back({physical(p.value) / to_unit, p.rise});
    }
    return points;
}

// What one reading more would leave of the uncertainty.
struct NextMeasurement {
    std::vector<std::string> names;
    std::vector<double> best, noise; // SI
    std::vector<std::string> units;
    std::vector<double> to_si;
    std::vector<double> separation; // of the valley's ends, in standard deviations of the reading; empty: no valley
    std::vector<landscape::CandidateEffect> effects; // best first
    double forward_cpu_seconds = 0.0;
    std::string failed; // why there are none
};

NextMeasurement next_measurement(const study::Study& study, const problem::Problem& problem, const Uniqueness& u) {
    NextMeasurement next;
    const study::Candidates list = study::candidates(study);
    const problem::Problem readings = study::make_prediction_problem(list.study);
    const auto workspace = readings.function->make_workspace();
    const auto& best = u.minima[0];
    const auto evaluate = [&](const std::vector<double>& unit, bool with_jacobian) {
        const std::clock_t begin = std::clock();
        auto evaluation = readings.evaluate(unit, with_jacobian, *workspace);
        next.forward_cpu_seconds += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        return evaluation;
    };
    const auto here = evaluate(best.unit, true);
    if (!here.converged()) {
        next.failed = here.reason;
        return next;
    }
    const auto d = static_cast<Eigen::Index>(best.unit.size());
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(list.names.size()), d);
    for (std::size_t i = 0; i < list.names.size(); ++i) {
        const double noise = study::candidate_noise(list.study.model.sensors[i].quantity, here.responses[i]);
        next.names.push_back(list.names[i]);
        next.best.push_back(here.responses[i]);
        next.noise.push_back(noise);
        next.units.emplace_back(list.study.response_unit(i));
        next.to_si.push_back(list.study.response_to_si(i));
        rows.row(static_cast<Eigen::Index>(i)) = here.jacobian.row(static_cast<Eigen::Index>(i)) / noise;
    }
    Eigen::MatrixXd predictions(static_cast<Eigen::Index>(study.outputs.size()), d);
    for (std::size_t o = 0; o < study.outputs.size() && best.evaluation.jacobian.rows() > 0; ++o) {
        predictions.row(static_cast<Eigen::Index>(o)) =
            best.evaluation.jacobian.row(static_cast<Eigen::Index>(study.measurements.size() + o));
    }
    for (Eigen::Index k = 0; k < d; ++k) {
        const double stretch =
            problem.space.axes[static_cast<std::size_t>(k)].d_physical(best.unit[static_cast<std::size_t>(k)]);
        rows.col(k) *= stretch;
        predictions.col(k) *= stretch;
    }
    next.effects = landscape::rank_candidates(problem, *u.acceptance, best, rows, predictions);
    if (u.traces.size() == 2) {
        std::vector<std::vector<double>> ends;
        for (const Branch& trace : u.traces) {
            ends.push_back(trace.points.empty() ? best.unit : trace.points.back().unit);
        }
        const auto a = evaluate(ends[0], false);
        const auto b = evaluate(ends[1], false);
        for (std::size_t i = 0; a.converged() && b.converged() && i < next.names.size(); ++i) {
            next.separation.push_back(std::abs(a.responses[i] - b.responses[i]) / next.noise[i]);
        }
    }
    return next;
}

std::vector<std::string> names_of(const problem::ParameterSpace& space, const std::vector<std::size_t>& axes) {
    std::vector<std::string> names;
    names.reserve(axes.size());
    for (const std::size_t k : axes) {
        names.push_back(space.axes[k].name);
    }
    return names;
}

// Names of the groups of data that are fitted, in the order of the task's groups.
std::vector<std::string> fitted_groups(const study::Study& study) {
    std::vector<std::string> names;
    for (const auto& group : study.groups) {
        if (!group.held_out) {
            names.push_back(group.name);
        }
    }
    return names;
}

// The verdict and its reasons, in plain words.
std::vector<std::string> findings(const study::Study& study, const problem::Problem& problem, const Uniqueness& u,
                                  const NextMeasurement& next) {
    std::vector<std::string> text;
    const auto& space = problem.space;
    const auto say = [&](std::string sentence) { text.push_back(std::move(sentence)); };
    switch (u.verdict) {
    case Verdict::unique:
        say("UNIQUE within what was searched: one set of parameters, with the ranges below, fits these data.");
        break;
    case Verdict::non_unique:
        say(u.alternatives && u.valley
                ? "NON-UNIQUE: separate minima fit these data, and a continuous valley of parameter sets too."
            : u.alternatives ? "NON-UNIQUE: separate minima fit these data, with no acceptable way found between them."
                             : "NON-UNIQUE: a continuous valley of parameter sets fits these data equally well.");
        break;
    case Verdict::undecided: say("UNDECIDED. What is missing: " + pave::join(u.missing) + "."); break;
    }
    if (!u.acceptance) {
        return text;
    }
    const auto& acceptance = *u.acceptance;
    if (u.verdict == Verdict::non_unique && !u.missing.empty()) {
        say("Not settled beyond that: " + pave::join(u.missing) + ".");
    }
    if (!u.directions.free.empty()) {
        std::vector<std::string> fixed;
        for (const auto& c : u.directions.fixed) {
            fixed.push_back(combination_words(space, c));
        }
        say(fmt::format("At the best minimum the data do not determine {} one by one{}",
                        pave::join(names_of(space, u.directions.free)),
                        fixed.empty() ? "." : "; what they fix: " + pave::join(fixed) + "."));
    }
    if (!u.directions.dead.empty()) {
        say(fmt::format("No reading sees {} here: crossing the whole range moves nothing beyond the noise.",
                        pave::join(names_of(space, u.directions.dead))));
    }
    std::vector<std::string> wide;
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        const Range& r = u.parameters[k];
        const problem::Axis& axis = space.axes[k];
        constexpr double half = 0.5;
        if (axis.unit(r.high) - axis.unit(r.low) > half) {
            wide.push_back(fmt::format("{} anywhere from {} to {}", axis.name, figure(r.low), figure(r.high)));
        }
    }
    if (!wide.empty()) {
        say(fmt::format("The data accept {}, if the others follow.", pave::join(wide)));
    }
    for (std::size_t o = 0; o < u.outputs.size(); ++o) {
        const Range& r = u.outputs[o];
        const std::size_t i = study.measurements.size() + o;
        const double si = study.response_to_si(i);
        say(fmt::format("Over the sets the data accept, {} runs from {} to {} {} (best fit: {}).",
                        study.outputs[o].name, figure(r.low / si), figure(r.high / si), study.response_unit(i),
                        figure(u.minima[0].evaluation.responses[i] / si)));
    }
    if (u.traces.size() == 2) {
        std::vector<std::string> reach;
        double highest = 0.0;
        for (const Branch& trace : u.traces) {
            for (const auto& p : trace.points) {
                highest = std::max(highest, std::min(p.rise, acceptance.threshold));
            }
        }
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            const auto end = [&](int side) {
                const auto& points = u.traces[static_cast<std::size_t>(side)].points;
                return points.empty() ? u.minima[0].evaluation.parameters[k] : points.back().evaluation.parameters[k];
            };
            if (std::abs(space.axes[k].unit(end(0)) - space.axes[k].unit(end(1))) > 0.05) {
                reach.push_back(fmt::format("{} from {} to {}", space.axes[k].name, figure(end(0)), figure(end(1))));
            }
        }
        say(fmt::format(
            "The valley was followed: {}, chi2 rising by {} at most (allowed: {}). One end: {}; the other: {}.",
            pave::join(reach), figure(highest), figure(acceptance.threshold),
            end_words(u.traces[0].end, u.traces[0].on_bound), end_words(u.traces[1].end, u.traces[1].on_bound)));
    }
    for (const auto& p : u.passes) {
        const bool joined = p.pass.rise < acceptance.threshold;
        say(fmt::format(
            "Minima {} and {}: {}.", p.a + 1, p.b + 1,
            !std::isfinite(p.pass.rise) ? "no way without a hole was found between them"
            : joined ? fmt::format("joined by a way on which chi2 rises by {} at most: one valley", figure(p.pass.rise))
                     : fmt::format("the lowest way found between them rises chi2 by {}", figure(p.pass.rise))));
    }
    if (acceptance.widened) {
        say(fmt::format("The model does not fit these data within their stated noise (chi2 = {} with {}, p = {:.2g}). "
                        "The ranges are "
                        "widened as if the noise were what the fit leaves over; a wrong model can still mislead them.",
                        figure(acceptance.chi2),
                        counted(static_cast<std::size_t>(std::max(0, acceptance.degrees_of_freedom)),
                                "degree of freedom", "degrees of freedom"),
                        acceptance.p_value));
    } else if (!acceptance.noise_is_stated) {
        say(fmt::format(
            "The data state no noise. It is taken from what the fit leaves over, with only {}: chi2 may rise by {}.",
            counted(static_cast<std::size_t>(acceptance.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            figure(acceptance.threshold)));
    }
    if (u.conflict && std::isfinite(u.conflict->p_value)) {
        const auto& c = *u.conflict;
        const std::vector<std::string> names = fitted_groups(study);
        if (c.p_value < 0.05) {
            std::string direction;
            for (Eigen::Index k = 0; k < c.direction.size(); ++k) {
                if (std::abs(c.direction[k]) > 0.3) {
                    direction +=
                        fmt::format("{}{} {}", direction.empty() ? "" : ", ", c.direction[k] > 0.0 ? "higher" : "lower",
                                    space.axes[static_cast<std::size_t>(k)].name);
                }
            }
            say(fmt::format(
                "The groups of data contradict each other under this model (p = {:.2g}): {} wants {} than {}.",
                c.p_value, names[c.alone[c.second].group], direction, names[c.alone[c.first].group]));
        } else {
            say(fmt::format("The groups of data do not contradict each other (p = {:.2g}).", c.p_value));
        }
    }
    if (!next.effects.empty() && u.verdict != Verdict::unique) {
        const auto& e = next.effects[0];
        const auto most =
            static_cast<std::size_t>(std::min_element(e.parameters.begin(), e.parameters.end()) - e.parameters.begin());
        std::string outputs;
        for (std::size_t o = 0; o < e.predictions.size(); ++o) {
            outputs += fmt::format(", of the output {} to {:.0f} %", study.outputs[o].name, 100.0 * e.predictions[o]);
        }
        say(fmt::format("One reading more that would tell most: {} (noise {} {} assumed): the standard error of {} "
                        "falls to {:.0f} %{} of "
                        "what it is.",
                        next.names[e.candidate], figure(next.noise[e.candidate] / next.to_si[e.candidate]),
                        next.units[e.candidate], space.axes[most].name, 100.0 * e.parameters[most], outputs));
    }
    say(fmt::format(
        "{} independent starts in a row found no minimum not known before: at 95 % those not found draw in less than "
        "{:.2g} % of the box. They may still exist.",
        u.unseen.since_new, 100.0 * u.unseen.volume_bound));
    return text;
}

Json uniqueness_json(const study::Study& study, const problem::Problem& problem, const Uniqueness& u,
                     const NextMeasurement& next) {
    const auto& space = problem.space;
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
        combinations.push_back(
            {{"words", combination_words(space, c)}, {"coefficients", terms}, {"standard_error", c.standard_error}});
    }
    json["spectrum"] = {{"collinearity_index", u.directions.collinearity},
                        {"not_determined", names_of(space, u.directions.free)},
                        {"dead", names_of(space, u.directions.dead)},
                        {"fixed_combinations", combinations}};
    for (std::size_t m = 0; m < u.minima.size(); ++m) {
        Json minimum = report::minimum_json(problem, u.minima[m]);
        minimum["accepted"] = std::find(u.accepted.begin(), u.accepted.end(), m) != u.accepted.end();
        minimum["alternative"] =
            std::find(u.alternative_of.begin(), u.alternative_of.end(), m) != u.alternative_of.end();
        json["minima"].push_back(std::move(minimum));
    }
    json["passes"] = Json::array();
    for (const auto& p : u.passes) {
        Json way = Json::array();
        for (const auto& point : p.pass.way) {
            way.push_back(
                {{"parameters", report::parameters_json(space, space.physical(point.unit))}, {"rise", point.rise}});
        }
        json["passes"].push_back({{"a", p.a}, {"b", p.b}, {"rise", p.pass.rise}, {"way", way}});
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
    }
    const auto range_json = [&](const Range& range, double to_unit, const std::function<double(double)>& physical) {
        Json branches = Json::array();
        for (const auto& b : range.branches) {
            branches.push_back(branch_json(b, to_unit, physical));
        }
        return Json{{"low", range.low / to_unit},
                    {"high", range.high / to_unit},
                    {"kind", landscape::profile_kind_names[static_cast<int>(kind_of(range))]},
                    {"low_stopped_by", end_words(range.low_end, range.low_bounds)},
                    {"high_stopped_by", end_words(range.high_end, range.high_bounds)},
                    {"low_set", report::parameters_json(space, range.low_set)},
                    {"high_set", report::parameters_json(space, range.high_set)},
                    {"profile", branches}};
    };
    json["profiles"] = Json::array();
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        Json profile = {{"name", space.axes[k].name}, {"best", u.minima[0].evaluation.parameters[k]}};
        profile.update(range_json(u.parameters[k], 1.0, [&](double unit) { return space.axes[k].physical(unit); }));
        json["profiles"].push_back(std::move(profile));
    }
    for (std::size_t o = 0; o < u.outputs.size(); ++o) {
        const std::size_t i = study.measurements.size() + o;
        Json output = {{"name", study.outputs[o].name},
                       {"best", u.minima[0].evaluation.responses[i] / study.response_to_si(i)},
                       {"unit", study.response_unit(i)}};
        output.update(range_json(u.outputs[o], study.response_to_si(i), [](double value) { return value; }));
        json["outputs"].push_back(std::move(output));
    }
    json["traces"] = Json::array();
    for (const Branch& trace : u.traces) {
        Json points = Json::array();
        for (const auto& p : trace.points) {
            points.push_back(
                {{"parameters", report::parameters_json(space, p.evaluation.parameters)}, {"rise", p.rise}});
        }
        json["traces"].push_back({{"stopped_by", end_words(trace.end, trace.on_bound)}, {"points", points}});
    }
    if (u.conflict) {
        Json alone = Json::array();
        const std::vector<std::string> names = fitted_groups(study);
        for (const auto& g : u.conflict->alone) {
            alone.push_back({{"group", names[g.group]},
                             {"misfit", g.misfit},
                             {"directions_determined", g.rank},
                             {"parameters", report::parameters_json(space, g.parameters)}});
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
                        {"why", e.why},
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
        tree.push_back({{"parameters", report::parameters_json(space, space.physical(u.sample.points[m.point]))},
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
    Json candidates = Json::array();
    for (const auto& e : next.effects) {
        Json parameters = Json::object();
        for (std::size_t k = 0; k < e.parameters.size(); ++k) {
            parameters[space.axes[k].name] = e.parameters[k];
        }
        Json outputs = Json::object();
        for (std::size_t o = 0; o < e.predictions.size(); ++o) {
            outputs[study.outputs[o].name] = e.predictions[o];
        }
        Json candidate = {{"reading", next.names[e.candidate]},
                          {"value", next.best[e.candidate] / next.to_si[e.candidate]},
                          {"sigma", next.noise[e.candidate] / next.to_si[e.candidate]},
                          {"unit", next.units[e.candidate]},
                          {"gain", e.gain},
                          {"standard_error_after_over_before", parameters},
                          {"outputs_after_over_before", outputs}};
        if (!next.separation.empty()) {
            candidate["valley_ends_apart_sigmas"] = next.separation[e.candidate];
        }
        candidates.push_back(std::move(candidate));
    }
    json["next_measurement"] = candidates;
    return json;
}

std::string model_words(const ModelOptions& model) {
    return model.alone()
               ? fmt::format(
                     "All of this is the reduced model's, whose error is estimated below {} % of a reading "
                     "where it was used; --model auto says it of the full model, with the ranges of the outputs.",
                     figure(model.limit_percent))
               : "The reduced model explored and searched. Every minimum it found was sought again by the full model, "
                 "whose are the minima, ranges and verdict here.";
}

int unique(const UniqueOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    const study::Study study = study::load_study(options.common.study);
    const problem::Problem full = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem everything = study::make_noise_problem(study, study::Scope::everything);
    const std::string folder = options.common.folder(study);
    std::optional<ReducedProblem> reduced;
    if (options.model.reduced()) {
        reduced = reduced_problem(full, study, options.model, folder, options.common.threads);
        if (!reduced) {
            return report_interrupt(folder);
        }
    }
    const problem::Problem& fitted = options.model.alone() ? reduced->problem : full;
    const std::string settings =
        fmt::format("{} explored, {} to verify, at most {} searches of {} evaluations, seed {}{}",
                    options.analysis.explore, options.analysis.verify, options.analysis.max_searches,
                    options.analysis.max_evaluations, options.common.seed, reduced ? reduced->settings : "");
    run::Store store(folder, session(options.common));
    const run::EngineSettings engine_settings{.threads = options.common.threads, .show_progress = true};
    std::optional<run::Engine> exploring_engine;
    if (options.model.confirmed()) { // a run of its own: its evaluations are not the full model's
        exploring_engine.emplace(reduced->problem, &store, store.begin(run_header(study, "explore", settings)),
                                 engine_settings);
    }
    const int all_id = store.begin(run_header(study, "unique-outputs", settings));
    const int id = store.begin(run_header(study, "unique", settings));
    run::Engine engine(fitted, &store, id, engine_settings);
    run::Engine everything_engine(everything, &store, all_id, engine_settings);
    auto task = uniqueness_task(study, fitted, everything, engine, everything_engine, options.common.seed);
    task.explorer = exploring_engine ? &*exploring_engine : nullptr;
    if (options.model.alone()) {
        task.outputs.clear(); // of loads that it may not have
    }
    const auto result = landscape::uniqueness(task, options.analysis);
    if (!result) {
        return report_interrupt(folder);
    }
    const Uniqueness& u = *result;
    if (u.minima.empty()) {
        const std::string reason = "not one explored point has an answer; the first says: " +
                                   (u.explored.empty() ? std::string() : u.explored.front().reason);
        if (options.common.json) {
            fmt::print("{}\n", report::json_text({{"status", "failed"},
                                                  {"reason", reason},
                                                  {"statuses", report::status_counts(u.explored)}}));
        }
        run::message("pavescape: {}\n", reason);
        return computation_failed;
    }
    const NextMeasurement next = u.acceptance ? next_measurement(study, fitted, u) : NextMeasurement{};
    auto words = findings(study, fitted, u, next);
    if (reduced) {
        words.push_back(model_words(options.model));
    }
    Json json = uniqueness_json(study, fitted, u, next);
    json["noise"] = {{"source", study.noise_name()}};
    json["misfit_kind"] = std::string(to_string(study.data.misfit)) +
                          (study.noise == study::NoiseSource::stated ? ", residuals in standard deviations" : "");
    json["model"] = options.model.model;
    if (reduced) {
        json["reduced_model"] = reduced->json;
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto computed = engine.tally().computed + everything_engine.tally().computed;
    const auto kept = engine.tally().kept + everything_engine.tally().kept;
    json["findings"] = words;
    json["parameters"] = report::space_json(fitted.space);
    json["responses"] = report::responses_json(study, u.minima[0].evaluation.responses);
    json["statuses"] = report::status_counts(u.explored);
    json["study"] = {{"file", study.file}, {"title", study.title}, {"hash", study.hash}};
    json["version"] = PAVESCAPE_VERSION;
    json["seed"] = options.common.seed;
    json["run"] = folder;
    const std::string kept_json = report::json_text(json); // without what depends on the machine
    store.put_result(id, report::json_text(json, -1));
    write_file(folder, "unique.json", kept_json + "\n");
    if (options.common.json) {
        fmt::print("{}\n", kept_json);
        return done;
    }

    const double cpu = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
    const double forward_cpu = engine.tally().forward_cpu_seconds + everything_engine.tally().forward_cpu_seconds +
                               (exploring_engine ? exploring_engine->tally().forward_cpu_seconds : 0.0) +
                               next.forward_cpu_seconds;
    fmt::print("{}\n  {} explored, {}; {} computed in {}, {} kept from before\n{}", study_summary(study), u.sample.name,
               counted(u.ends.size(), "search", "searches"), counted(static_cast<std::size_t>(computed), "run", "runs"),
               run::duration_words(seconds), kept, reduced ? reduced->words : "");
    if (exploring_engine) {
        fmt::print("    {} more by the reduced model, which explored and searched\n",
                   counted(static_cast<std::size_t>(exploring_engine->tally().computed), "run", "runs"));
    }
    if (computed > 0 && !reduced) { // else it was built too
        fmt::print("    {:.1f} % of the processor time outside forward runs\n",
                   100.0 * std::max(0.0, 1.0 - forward_cpu / cpu));
    }
    for (std::size_t kind = 0; kind < std::size(landscape::end_kind_names); ++kind) {
        const auto count = std::count_if(u.ends.begin(), u.ends.end(),
                                         [&](const auto& e) { return static_cast<std::size_t>(e.kind) == kind; });
        if (count > 0) {
            fmt::print("    {} ended: {}\n", count, landscape::end_kind_names[kind]);
        }
    }
    fmt::print("\n");
    for (const std::string& sentence : words) {
        fmt::print("  {}\n", sentence);
    }
    if (!u.parameters.empty()) {
        fmt::print("\nWhat the data accept (95 %)\n");
        if (!study.outputs.empty()) {
            fmt::print("  {}\n", sign_convention);
        }
        report::Table table({"", "best", "low", "high", "unit", "", "low end set by", "high end set by"});
        for (std::size_t k = 0; k < u.parameters.size(); ++k) {
            const Range& r = u.parameters[k];
            const std::string& name = fitted.space.axes[k].name;
            const auto stopped = [&](double limit, WalkEnd end, const std::vector<std::string>& bounds) {
                const auto others = of_others(bounds, name);
                constexpr double close = 1e-3; // a walk need not meet its bound to the last digit
                const double unit = fitted.space.axes[k].unit(limit);
                return end == WalkEnd::bound && (unit < close || unit > 1.0 - close) ? std::string("its bound")
                                                                                     : short_words(end, others);
            };
            table.add({name, figure(u.minima[0].evaluation.parameters[k]), figure(r.low), figure(r.high), "",
                       std::string(landscape::profile_kind_names[static_cast<int>(kind_of(r))]),
                       stopped(r.low, r.low_end, r.low_bounds), stopped(r.high, r.high_end, r.high_bounds)});
        }
        for (std::size_t o = 0; o < u.outputs.size(); ++o) {
            const Range& r = u.outputs[o];
            const std::size_t i = study.measurements.size() + o;
            const double si = study.response_to_si(i);
            table.add({study.outputs[o].name, figure(u.minima[0].evaluation.responses[i] / si), figure(r.low / si),
                       figure(r.high / si), std::string(study.response_unit(i)),
                       std::string(landscape::profile_kind_names[static_cast<int>(kind_of(r))]),
                       short_words(r.low_end, r.low_bounds), short_words(r.high_end, r.high_bounds)});
        }
        fmt::print("{}", table.text());
    }
    if (!u.directions.singular_values.empty()) {
        fmt::print("\nDirections at the best minimum (data moved by crossing the box, in standard deviations)\n");
        std::vector<std::string> header{"moved", ""};
        for (const auto& axis : fitted.space.axes) {
            header.push_back(axis.name);
        }
        report::Table table(header);
        for (std::size_t i = 0; i < u.directions.vectors.size(); ++i) {
            const bool flat =
                std::find(u.directions.flat.begin(), u.directions.flat.end(), i) != u.directions.flat.end();
            std::vector<std::string> row{figure(u.directions.singular_values[i]), flat ? "flat" : ""};
            for (const double v : u.directions.vectors[i]) {
                row.push_back(fmt::format("{:+.2f}", v));
            }
            table.add(std::move(row));
        }
        fmt::print("{}  collinearity index {}\n", table.text(), figure(u.directions.collinearity));
    }
    fmt::print("\n{} found\n", counted(u.minima.size(), "distinct minimum", "distinct minima"));
    const bool in_deviations = study.noise == study::NoiseSource::stated;
    std::vector<std::string> header{"", in_deviations ? "chi" : "misfit", "starts"};
    for (const auto& axis : fitted.space.axes) {
        header.push_back(axis.name);
    }
    header.emplace_back("remark");
    report::Table minima(header);
    for (std::size_t m = 0; m < u.minima.size(); ++m) {
        const auto& minimum = u.minima[m];
        std::vector<std::string> row{fmt::format("{}", m + 1), figure(minimum.evaluation.misfit),
                                     fmt::format("{} of {}", minimum.members.size(), u.ends.size())};
        for (const double value : minimum.evaluation.parameters) {
            row.push_back(figure(value));
        }
        const bool accepted = std::find(u.accepted.begin(), u.accepted.end(), m) != u.accepted.end();
        std::string remark = u.acceptance && !accepted ? "rejected by the data" : "";
        for (const auto& bound : minimum.on_bound) {
            remark += (remark.empty() ? "" : "; ") + bound;
        }
        row.push_back(remark + (minimum.converged ? "" : remark.empty() ? "unfinished" : "; unfinished"));
        minima.add(std::move(row));
    }
    fmt::print("{}", minima.text());
    if (!next.effects.empty()) {
        fmt::print("\nReadings that would tell most (standard error left over)\n  {}\n", sign_convention);
        std::vector<std::string> columns{"reading", "value", "noise", "unit"};
        for (const auto& axis : fitted.space.axes) {
            columns.push_back(axis.name);
        }
        for (const auto& output : study.outputs) {
            columns.push_back(output.name);
        }
        report::Table table(columns);
        constexpr std::size_t shown = 6;
        for (std::size_t i = 0; i < std::min(shown, next.effects.size()); ++i) {
            const auto& e = next.effects[i];
            std::vector<std::string> row{
                next.names[e.candidate], figure(next.best[e.candidate] / next.to_si[e.candidate]),
                figure(next.noise[e.candidate] / next.to_si[e.candidate]), next.units[e.candidate]};
            for (const auto* list : {&e.parameters, &e.predictions}) {
                for (const double ratio : *list) {
                    row.push_back(fmt::format("{:.0f} %", 100.0 * ratio));
                }
            }
            table.add(std::move(row));
        }
        fmt::print("{}", table.text());
    } else if (!next.failed.empty()) {
        fmt::print("\nNo further reading could be judged: {}\n", next.failed);
    }
    fmt::print("\n  results: {}/unique.json; every evaluation: pavescape export {} --command unique\n", folder, folder);
    return done;
}

} // namespace

void add_unique(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("unique", "is the answer unique? valleys, profiles, and what they do to the outputs");
    auto options = std::make_shared<UniqueOptions>();
    add_common(*command, options->common);
    add_model(*command, options->model);
    command->add_option("--explore", options->analysis.explore, "points of the Sobol sample, with derivatives")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command
        ->add_option(
            "--verify", options->analysis.verify,
            "independent random starts in a row that must find no new minimum (bound on what was missed: 3 / this)")
        ->check(CLI::Range(1, 10'000))
        ->capture_default_str();
    command->add_option("--searches", options->analysis.max_searches, "local searches at most")
        ->check(CLI::Range(1, 50'000))
        ->capture_default_str();
    command->footer("Example: pavescape unique grids/captif-p1-fwd.toml");
    command->callback([=, &action] { action = [=] { return unique(*options); }; });
}

} // namespace explore::cli

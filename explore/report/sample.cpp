#include "report/sample.h"

#include "analysis/common/knowledge_words.h"
#include "analysis/explore/build.h"
#include "base/text.h"
#include "report/density.h"
#include "report/predictive.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace explore::report {
namespace {

using analysis::SampleResult;
using landscape::Marginal;
using pave::counted;
using pave::figure;

constexpr std::size_t most_drawn = 500; // draws of the pictures of the report

// to_unit: SI of one unit.
Json marginal_json(const Marginal& m, double to_unit, bool converged) {
    const auto value = [&](double v) { return converged ? Json(v / to_unit) : Json(nullptr); };
    return {{"mean", value(m.mean)}, {"sd", value(m.sd)}, {"q025", value(m.q025)}, {"q50", value(m.q50)},
            {"q975", value(m.q975)}, {"rhat", m.rhat},    {"ess", m.ess}};
}

std::vector<double> units_of(const SampleResult& s, std::size_t k) {
    std::vector<double> units;
    for (const auto& draw : s.draws) {
        units.push_back(draw.unit[k]);
    }
    return units;
}

Json correlations_json(const SampleResult& s) {
    Json rows = Json::array();
    const std::size_t d = s.parameters.size();
    for (std::size_t a = 0; a < d; ++a) {
        Json row = Json::array();
        for (std::size_t b = 0; b < d; ++b) {
            row.push_back(a == b ? 1.0
                                 : landscape::weighted_correlation(units_of(s, a), units_of(s, b), s.descent.weight));
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

// Parameters and weight (1 on average) of draws that spread evenly over the sample.
Json draws_json(const SampleResult& s) {
    Json rows = Json::array();
    const double mean =
        std::accumulate(s.descent.weight.begin(), s.descent.weight.end(), 0.0) / static_cast<double>(s.draws.size());
    const std::size_t count = std::min(most_drawn, s.draws.size());
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = k * s.draws.size() / count;
        Json row = Json::array({s.descent.weight[i] / mean});
        for (const double value : s.draws[i].parameters) {
            row.push_back(value);
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

// The border around 95 % of the draws over every pair.
Json regions_json(const SampleResult& s) {
    constexpr double share = 0.95;
    const auto& axes = s.problem.space.axes;
    Json regions = Json::array();
    for (std::size_t x = 0; x < axes.size(); ++x) {
        for (std::size_t y = x + 1; y < axes.size(); ++y) {
            Json borders = Json::array();
            for (const Contour& border : densest_region(units_of(s, x), units_of(s, y), s.descent.weight, share)) {
                Json& points = borders.emplace_back(Json::array());
                for (std::size_t i = 0; i <= border.x.size(); ++i) {
                    const std::size_t at = i % border.x.size();
                    points.push_back({axes[x].physical(border.x[at]), axes[y].physical(border.y[at])});
                }
            }
            regions.push_back(
                {{"x", axes[x].name}, {"y", axes[y].name}, {"share", share}, {"borders", std::move(borders)}});
        }
    }
    return regions;
}

std::vector<std::string> row_of(const std::string& name, const std::string& unit, const Marginal& m, double to_unit) {
    return {name,
            figure(m.mean / to_unit),
            figure(m.sd / to_unit),
            figure(m.q025 / to_unit),
            figure(m.q50 / to_unit),
            figure(m.q975 / to_unit),
            unit,
            fmt::format("{:.3f}", m.rhat),
            fmt::format("{:.0f}", m.ess)};
}

// The header of the prior: what was known before the readings.
std::string prior_header(const problem::Problem& problem) {
    const auto priors = problem.priors();
    if (priors.empty()) {
        return "The posterior: what the data leave of the box, in which every parameter was uniform on its scale";
    }
    std::vector<std::string> known;
    for (const std::size_t k : priors) {
        known.push_back(problem.space.axes[k].name + " " + analysis::prior_words(problem.space.axes[k]));
    }
    return fmt::format("The posterior: what the data leave of the priors within the box ({}){}", pave::join(known),
                       priors.size() < problem.space.axes.size() ? "; every other parameter was uniform on its scale"
                                                                 : "");
}

} // namespace

Json sample_json(const SampleResult& s, const analysis::RunOptions& run) {
    const auto status = analysis::sample_status_names[static_cast<int>(s.status)];
    if (s.failed()) {
        return {{"status", status}, {"reason", s.reason()}};
    }
    const study::Study& study = s.study;
    const bool converged = s.converged();
    const auto& posterior = s.posterior;
    Json json = {{"status", status}};
    if (!converged) {
        json["reason"] = s.reason();
    }
    json["log_evidence"] = s.log_evidence;
    json["log_evidence_error"] = s.log_evidence_error;
    if (s.allowed) {
        json["allowed_share"] = std::exp(s.allowed->log);
    }
    if (s.priors) {
        json["priors"] = priors_json(s.problem, s.held->evaluation.parameters, *s.priors);
    }
    json["parameters"] = space_json(s.problem.space);
    for (std::size_t k = 0; k < s.parameters.size(); ++k) {
        json["parameters"][k].update(marginal_json(s.parameters[k], 1.0, converged));
        if (const auto& prior = s.problem.space.axes[k].prior) {
            json["parameters"][k]["prior"] = {{"mean", prior->mean}, {"sd", prior->sd}};
        }
    }
    json["outputs"] = Json::array();
    const auto outputs = study.outputs();
    for (std::size_t o = 0; o < s.outputs.size(); ++o) {
        const data::Reading& reading = study.readings[outputs[o]];
        Json output = {{"name", reading.output}, {"unit", reading.unit.name}};
        output.update(marginal_json(s.outputs[o], reading.unit.to_si, converged));
        const auto beside = std::find(s.besides.begin(), s.besides.end(), outputs[o]);
        if (s.surface && beside != s.besides.end()) {
            output["interpolated"] = {
                {"runs", s.surface->runs},
                {"checks", s.surface->checks},
                {"error", s.surface->error[static_cast<std::size_t>(beside - s.besides.begin())] / reading.unit.to_si}};
        }
        json["outputs"].push_back(std::move(output));
    }
    json["correlations"] = correlations_json(s);
    json["findings"] = findings(s);
    json["next_measurement"] = Json::array();
    for (const auto& [reading, bits] : s.telling) {
        json["next_measurement"].push_back({{"reading", reading.words()},
                                            {"value", reading.value},
                                            {"sigma", reading.in_unit(reading.noise.absolute)},
                                            {"unit", reading.unit.name},
                                            {"bits", bits}});
    }
    json["missing"] = s.missing;
    json["chi2"] = s.chi2;
    json["degrees_of_freedom"] = s.degrees_of_freedom;
    json["p_value"] = s.noise_scale ? Json(nullptr) : Json(s.p_value);
    json["noise"] = {{"source", study.noise_name()}};
    if (s.noise_scale) {
        json["noise"]["scale"] = noise_scale_json(*s.noise_scale);
    }
    json["model"] = s.options.model.name();
    if (s.reduced) {
        json["reduced_model"] = reduced_json(*s.reduced);
    }
    if (s.correction) {
        json["correction"] = {{"full_runs", s.correction->runs},
                              {"without_answer", s.correction->without_answer},
                              {"draws", s.correction->weighed},
                              {"effective_draws", s.correction->effective},
                              {"share", s.correction->effective / static_cast<double>(s.correction->weighed)},
                              {"left", finite_json(s.correction->left)}};
    }
    json["sampler"] = {{"populations", posterior.log_evidences.size()},
                       {"draws", posterior.draws.size()},
                       {"powers", posterior.powers},
                       {"sweeps", posterior.sweeps},
                       {"accepted_own", posterior.accepted_own},
                       {"accepted_other", posterior.accepted_other},
                       {"answered_share", posterior.answered},
                       {"log_evidences", posterior.log_evidences}};
    const auto inside =
        std::count_if(s.predicted.begin(), s.predicted.end(), [](const auto& p) { return p.is_inside(); });
    json["predictive"] = {{"inside", static_cast<double>(inside) / static_cast<double>(s.predicted.size())},
                          {"readings", predicted_json(study, s.predicted)}};
    json["draws"] = draws_json(s);
    json["regions"] = regions_json(s);
    json["study"] = study_json(study);
    json["version"] = analysis::version;
    json["seed"] = run.seed;
    json["run"] = run.folder;
    return json;
}

std::string sample_text(const SampleResult& s, const analysis::RunOptions& run) {
    const auto& posterior = s.posterior;
    std::string text =
        fmt::format("{}\n  {} draws of {} populations, {} of moves; {} computed in {}, {} kept from before\n{}",
                    study_summary(s.study), posterior.draws.size(), posterior.log_evidences.size(),
                    counted(static_cast<std::size_t>(posterior.sweeps), "sweep", "sweeps"),
                    counted(static_cast<std::size_t>(s.computed), "run", "runs"), run::duration_words(s.seconds),
                    s.kept, s.reduced ? reduced_words(*s.reduced) : "");
    if (s.options.model.confirmed()) {
        text += fmt::format("    {} more by the reduced model, which drew\n",
                            counted(static_cast<std::size_t>(s.computed_by_reduced_model), "run", "runs"));
    }
    text += "\n" + sentences(findings(s));
    const auto outputs = s.study.outputs();
    if (s.converged()) {
        Table table({"", "mean", "sd", "2.5 %", "50 %", "97.5 %", "unit", "R-hat", "effective draws"});
        for (std::size_t k = 0; k < s.parameters.size(); ++k) {
            table.add(row_of(s.problem.space.axes[k].name, "", s.parameters[k], 1.0));
        }
        for (std::size_t o = 0; o < s.outputs.size(); ++o) {
            const data::Reading& reading = s.study.readings[outputs[o]];
            table.add(row_of(reading.output, std::string(reading.unit.name), s.outputs[o], reading.unit.to_si));
        }
        text += "\n" + prior_header(s.problem) + "\n" + table.text();
    } else {
        Table table({"", "R-hat", "effective draws"});
        for (std::size_t k = 0; k < s.parameters.size(); ++k) {
            table.add({s.problem.space.axes[k].name, fmt::format("{:.3f}", s.parameters[k].rhat),
                       fmt::format("{:.0f}", s.parameters[k].ess)});
        }
        for (std::size_t o = 0; o < s.outputs.size(); ++o) {
            table.add({s.study.readings[outputs[o]].output, fmt::format("{:.3f}", s.outputs[o].rhat),
                       fmt::format("{:.0f}", s.outputs[o].ess)});
        }
        text += "\n" + table.text();
    }
    text +=
        "\nEach reading as the draws predict it, with its noise (the fit saw it, so hardly one should lie outside)\n" +
        predicted_table(s.study, s.predicted);
    if (!s.telling.empty()) {
        text += fmt::format("\nWhat one reading more would tell of the parameters\n  {}\n", sign_convention);
        Table table({"reading", "value", "noise", "unit", "bits"});
        constexpr std::size_t shown = 6;
        for (std::size_t i = 0; i < std::min(shown, s.telling.size()); ++i) {
            const auto& [reading, bits] = s.telling[i];
            table.add({reading.words(), figure(reading.value), figure(reading.in_unit(reading.noise.absolute)),
                       std::string(reading.unit.name), fmt::format("{:.2f}", bits)});
        }
        text += table.text();
    }
    text += fmt::format("\n  log evidence {:.2f} +- {:.2f}: the logarithm of the density of these readings (SI) under "
                        "model, noise and box\n",
                        s.log_evidence, s.log_evidence_error);
    if (!run.folder.empty()) {
        text += fmt::format("  results: {0}/sample.json, every draw: {0}/samples.csv; pictures: pavescape report {1}\n",
                            run.folder, run::shell_word(run.folder));
    }
    return text;
}

std::string samples_csv(const SampleResult& s) {
    std::string text = "population,weight,log_likelihood";
    for (const auto& axis : s.problem.space.axes) {
        text += ',' + axis.name;
    }
    const auto outputs = s.study.outputs();
    for (const std::size_t o : outputs) {
        text += ',' + s.study.readings[o].label_with_unit();
    }
    text += "\n";
    const double mean = std::accumulate(s.descent.weight.begin(), s.descent.weight.end(), 0.0) /
                        static_cast<double>(std::max<std::size_t>(1, s.draws.size()));
    for (std::size_t i = 0; i < s.draws.size(); ++i) {
        const auto& draw = s.draws[i];
        text += fmt::format("{},{},{}", s.descent.population[i], s.descent.weight[i] / mean, draw.log_likelihood);
        for (const double value : draw.parameters) {
            text += fmt::format(",{}", value);
        }
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            text +=
                draw.outputs.empty() ? "," : fmt::format(",{}", s.study.readings[outputs[o]].in_unit(draw.outputs[o]));
        }
        text += "\n";
    }
    return text;
}

} // namespace explore::report

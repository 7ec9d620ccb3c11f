#include "report/compare.h"

#include "analysis/explore/build.h"
#include "base/text.h"
#include "material/law.h"
#include "report/text.h"
#include "run/program.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::CompareResult;
using analysis::FittedLaw;
using pave::figure;

Json laws_json(const CompareResult& result) {
    const bool of_studies = result.is_of_studies();
    const std::string list = of_studies ? "studies" : "laws";
    Json json = {{list, Json::array()}};
    if (of_studies) {
        json["same_noise"] = result.same_noise;
    } else {
        json["layer"] = result.layer;
    }
    for (const FittedLaw& f : result.laws) {
        const study::Study& study = f.study;
        Json law = {{of_studies ? "study" : "law", f.name()}, {"summary", f.summary()}};
        if (!f.failed.empty()) {
            law["status"] = "failed";
            law["reason"] = f.failed;
            json[list].push_back(std::move(law));
            continue;
        }
        law["status"] = "converged";
        law["misfit"] = f.misfit;
        law["chi2"] = f.chi2;
        law["dof"] = f.dof;
        law["p_value"] = optional_json(f.p_value);
        law["aicc"] = finite_json(f.aicc);
        law["weight"] = f.weight;
        if (f.evidence) {
            law["log_evidence"] = f.evidence->log;
            law["log_evidence_error"] = f.evidence->error;
            law["evidence_weight"] = f.evidence->weight;
            law["evidence_status"] = f.evidence->missing.empty() ? "converged" : "not-converged";
        }
        law["held_out_rms"] = optional_json(f.by_place);
        law["study_held_out_rms"] = optional_json(f.study_holds);
        law["verdict"] = std::string(landscape::verdict_names[static_cast<int>(f.answer.verdict)]);
        law["minima"] = f.answer.minima.size();
        law["parameters"] = Json::object();
        for (std::size_t k = 0; k < f.study.space.axes.size(); ++k) {
            Json value = {{"value", f.best.parameters[k]}};
            if (k < f.answer.parameters.size()) {
                value["low"] = f.answer.parameters[k].low;
                value["high"] = f.answer.parameters[k].high;
            }
            law["parameters"][f.study.space.axes[k].name] = std::move(value);
        }
        law["outputs"] = Json::array();
        const auto outputs = study.outputs();
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            const data::Reading& reading = study.readings[outputs[o]];
            Json output = {{"name", reading.output},
                           {"best", reading.in_unit(f.best.responses[outputs[o]])},
                           {"unit", std::string(reading.unit.name)}};
            if (o < f.answer.outputs.size()) {
                output["low"] = reading.in_unit(f.answer.outputs[o].low);
                output["high"] = reading.in_unit(f.answer.outputs[o].high);
            }
            law["outputs"].push_back(std::move(output));
        }
        law["groups"] = Json::object();
        for (std::size_t g = 0; g < study.groups.size(); ++g) {
            law["groups"][study.groups[g].name] = f.group_rms[g];
        }
        law["responses"] = responses_json(study, f.best.responses);
        law["warnings"] = warnings_json(f.best);
        json[list].push_back(std::move(law));
    }
    return json;
}

std::string comparison_text(const CompareResult& result) {
    const auto optional = [](const std::optional<double>& v) { return v ? figure(*v) : std::string("-"); };
    const std::string kind = result.is_of_studies() ? "study" : "law";
    Table table({kind, "varied", "chi2", "dof", "p", "AICc", "weight", "left out", "held out", "answer"});
    for (const FittedLaw& f : result.laws) {
        if (!f.failed.empty()) {
            table.add({f.name(), "", "", "", "", "", "", "", "", f.failed});
            continue;
        }
        table.add({f.name(), fmt::format("{}", f.study.space.axes.size()), figure(f.chi2), fmt::format("{}", f.dof),
                   f.p_value ? fmt::format("{:.2g}", *f.p_value) : "-", std::isfinite(f.aicc) ? figure(f.aicc) : "-",
                   std::isfinite(f.aicc) ? fmt::format("{:.0f} %", 100.0 * f.weight) : "-", optional(f.by_place),
                   optional(f.study_holds), std::string(landscape::verdict_names[static_cast<int>(f.answer.verdict)])});
    }
    Table evidences({kind, "ln evidence", "std. error", "weight"});
    bool sampled = false;
    for (const FittedLaw& f : result.laws) {
        if (f.evidence) {
            sampled = true;
            evidences.add({f.name(), fmt::format("{:.2f}", f.evidence->log), fmt::format("{:.2f}", f.evidence->error),
                           fmt::format("{:.1f} %", 100.0 * f.evidence->weight)});
        }
    }
    std::string text =
        table.text() +
        "  left out: error of readings predicted place by place by fits without them; held out: of those "
        "that the study\n  holds out; both root mean squares of residuals\n";
    text += sampled ? "\n" + evidences.text() : "";
    if (std::any_of(result.laws.begin(), result.laws.end(), [](const auto& f) { return !f.study.outputs().empty(); })) {
        text += fmt::format("  {}\n", sign_convention);
    }
    for (const FittedLaw& f : result.laws) {
        if (!f.failed.empty()) {
            continue;
        }
        const study::Study& study = f.study;
        const auto outputs = study.outputs();
        text += fmt::format("\n{}: {}\n", f.name(), f.summary());
        Table values({"", "best", "low", "high", "unit"});
        const bool ranges = !f.answer.parameters.empty();
        for (std::size_t k = 0; k < f.study.space.axes.size(); ++k) {
            values.add({f.study.space.axes[k].name, figure(f.best.parameters[k]),
                        ranges ? figure(f.answer.parameters[k].low) : "-",
                        ranges ? figure(f.answer.parameters[k].high) : "-", ""});
        }
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            const data::Reading& output = study.readings[outputs[o]];
            const bool range = o < f.answer.outputs.size();
            values.add({output.output, figure(output.in_unit(f.best.responses[outputs[o]])),
                        range ? figure(output.in_unit(f.answer.outputs[o].low)) : "-",
                        range ? figure(output.in_unit(f.answer.outputs[o].high)) : "-", std::string(output.unit.name)});
        }
        text += values.text();
        for (std::size_t g = 0; g < study.groups.size() && study.groups.size() > 1; ++g) {
            text += fmt::format("  {}{}: residual {}\n", study.groups[g].name,
                                study.groups[g].held_out ? " (held out)" : "", figure(f.group_rms[g]));
        }
    }
    return text;
}

} // namespace

Json compare_json(const CompareResult& result, const analysis::RunOptions& run) {
    Json json = laws_json(result);
    json["findings"] = findings(result);
    json["noise"] = result.study.noise_name();
    json["study"] = study_json(result.study);
    json["version"] = analysis::version;
    json["seed"] = run.seed;
    json["run"] = run.folder;
    if (result.failed()) {
        json["status"] = "failed";
        json["reason"] = result.laws[0].failed;
    }
    return json;
}

Answer compare_answer(const CompareResult& result, const analysis::RunOptions& run) {
    Answer answer;
    answer.verdict_and_notes(findings(result));
    if (result.failed()) {
        answer.next = "pavescape forward " + run::shell_word(result.study.file);
        return answer;
    }
    answer.heading =
        result.is_of_studies() ? "Studies, best first" : fmt::format("Laws in {}, best first", result.layer);
    answer.header = {"", "chi2", "p", "AICc", "weight", "left out", "answer"};
    const auto number = [](const std::optional<double>& v) { return v ? figure(*v) : std::string("-"); };
    for (const FittedLaw& f : result.laws) {
        if (!f.failed.empty()) {
            answer.rows.push_back({f.name(), "-", "-", "-", "-", "-", "no answer"});
            continue;
        }
        const bool is_weighed = std::isfinite(f.aicc) && result.same_noise;
        answer.rows.push_back({f.name(), figure(f.chi2), f.p_value ? fmt::format("{:.2g}", *f.p_value) : "-",
                               is_weighed ? figure(f.aicc) : "-",
                               is_weighed ? fmt::format("{:.0f} %", 100.0 * f.weight) : "-", number(f.by_place),
                               std::string(landscape::verdict_names[static_cast<int>(f.answer.verdict)])});
    }
    const FittedLaw& first = result.laws[0];
    const auto& layers = result.study.model.layers;
    const bool is_own = result.is_of_studies() || std::any_of(layers.begin(), layers.end(), [&](const auto& layer) {
                            return layer.name == result.layer && layer.law == first.law;
                        });
    const std::string file = run::shell_word(result.is_of_studies() ? first.study.file : result.study.file);
    const bool fits = std::any_of(result.laws.begin(), result.laws.end(), [](const FittedLaw& f) {
        return f.failed.empty() && f.p_value.value_or(1.0) >= 0.05;
    });
    answer.next =
        (is_own ? ""
                : fmt::format("law = \"{}\" of {} in {}, then the same command\n", first.name(), result.layer, file)) +
        fmt::format("pavescape {} {}\nPicture: pavescape report {}", fits ? "unique" : "diagnose", file,
                    run::shell_word(run.folder));
    return answer;
}

std::string compare_text(const CompareResult& result, const analysis::RunOptions& run) {
    return fmt::format(
        "{}\n  {}, {}\n\n{}\n{}\n  results: {}/compare.json\n", study_summary(result.study),
        result.is_of_studies()
            ? pave::counted(result.laws.size(), "study", "studies")
            : fmt::format("{} in \"{}\"", pave::counted(result.laws.size(), "law", "laws"), result.layer),
        run::duration_words(result.seconds), sentences(findings(result)), comparison_text(result), run.folder);
}

} // namespace explore::report

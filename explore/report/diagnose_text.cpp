// A diagnosis as a page of the terminal.
#include "report/diagnose.h"

#include "analysis/diagnose/diagnose_verdict.h"
#include "base/text.h"
#include "base/units.h"
#include "pavement/effects/effect.h"
#include "report/text.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {

using analysis::DiagnosedModel;
using analysis::DiagnoseResult;
using analysis::members_words;
using analysis::percent;
using diagnose::Diagnosis;
using diagnose::Verdict;
using pave::counted;
using pave::figure;

namespace {

// A bar of residuals from -4 to 4 standard deviations: "     ====|         "
std::string bar(double residual) {
    constexpr int half = 8;
    constexpr double reach = 4.0;
    const int cells = std::clamp(static_cast<int>(std::lround(std::abs(residual) / reach * half)), 0, half);
    const std::string full(static_cast<std::size_t>(cells), std::abs(residual) > reach ? '#' : '=');
    const std::string space(static_cast<std::size_t>(half - cells), ' ');
    const std::string none(static_cast<std::size_t>(half), ' ');
    return residual < 0.0 ? space + full + "|" + none : none + "|" + full + space;
}

// "+3.1"; "-": there is none.
std::string change_words(double change) {
    return std::isfinite(change) ? fmt::format("{:+.1f}", change) : "-";
}
} // namespace

std::string diagnosis_page(const DiagnoseResult& f) {
    const Diagnosis& d = f.diagnosis;
    const DiagnosedModel& reported_before = *f.before;
    const std::vector<double> before = residuals_of(f, d.baseline.model);
    const std::vector<double> after = d.extended ? residuals_of(f, d.extended->model) : std::vector<double>{};
    std::string text = sentences(findings(f)) + warning_lines((f.after ? *f.after : reported_before).evaluation);
    text += "\nResiduals (model - measured) in standard deviations, of the study's model";
    text += after.empty() ? "\n" : ", and with " + members_words(f.candidates, d.extended->model.members) + "\n";
    text += fmt::format("  {}\n", sign_convention);
    std::vector<std::string> header{"load", "reading", "before", "-4       0       4"};
    if (!after.empty()) {
        header.insert(header.end(), {"after", "-4       0       4"});
    }
    Table picture(header);
    for (const auto& group : f.layout.groups) {
        for (const std::size_t t : group.terms) {
            const std::size_t row = f.layout.rows[t];
            const data::Reading& m = f.study.readings[row];
            std::vector<std::string> line{m.load, m.place_words(), fmt::format("{:+.1f}", before[row]),
                                          bar(before[row])};
            if (!after.empty()) {
                line.push_back(fmt::format("{:+.1f}", after[row]));
                line.push_back(bar(after[row]));
            }
            picture.add(std::move(line));
        }
    }
    text += picture.text();
    for (const analysis::LocatedCorrection& found : f.located) {
        const auto& channel = info(found.correction.channel);
        text += fmt::format("\nCorrection: {}\n", analysis::channel_words(found.correction));
        Table places({fmt::format("{} [{}]", channel.name, channel.unit), "times", "95 % from", "to",
                      channel.of_layer ? "modulus [MPa]" : "", ""});
        for (const analysis::LocatedPlace& place : found.places) {
            places.add({figure(place.at), figure(place.value), figure(place.low), figure(place.high),
                        channel.of_layer ? figure(place.modulus / pave::unit::MPa) : "",
                        place.seen() ? "" : "not seen"});
        }
        text += places.text();
    }
    text +=
        fmt::format("\nCandidates (score in standard deviations; under noise alone the largest exceeds {:.1f} in 5 % "
                    "of cases)\n",
                    d.screening.threshold);
    Table table({"effect", "on", "score", "p", "chi2 falls by", "AICc", "size", "95 % from", "to", "unit"});
    for (const auto& effect : d.effects) {
        const auto& candidate = f.candidates[effect.candidate];
        if (!effect.fit) {
            table.add({candidate.effect, candidate.on, fmt::format("{:+.1f}", effect.score),
                       fmt::format("{:.2g}", effect.p_familywise), "-", "", "", "", "", effect.impossible});
            continue;
        }
        table.add({candidate.effect, candidate.on, fmt::format("{:+.1f}", effect.score),
                   fmt::format("{:.2g}", effect.p_familywise), figure(effect.gain), change_words(effect.delta_aicc),
                   figure(effect.size.value), figure(effect.size.low), figure(effect.size.high),
                   std::string(f.variants[effect.candidate].applied.effect->unit)});
        for (const auto& other : effect.alike) {
            table.add({"  or", f.candidates[other.candidate].on, "", "", figure(effect.gain - other.behind), "",
                       figure(other.size.value), figure(other.size.low), figure(other.size.high), ""});
        }
    }
    text += table.text();
    if (d.explanations.size() > 1) {
        text += "\nExplanations that these data cannot distinguish\n";
        const bool holds_out = reported_before.held_out_rms.has_value();
        std::vector<std::string> columns{"", "chi2", "p", "AICc", "behind by"};
        if (holds_out) {
            columns.emplace_back("error of what the study holds out");
        }
        Table alternatives(columns);
        for (std::size_t e = 0; e < d.explanations.size(); ++e) {
            const auto& own = d.explanations[e];
            std::vector<std::string> row{members_words(f.candidates, own.fit.model.members), figure(own.fit.chi2),
                                         fmt::format("{:.2g}", own.fit.p_value),
                                         change_words(own.fit.aicc - d.baseline.aicc), figure(own.behind)};
            if (holds_out) {
                row.push_back(figure(*f.held_out[e]));
            }
            alternatives.add(std::move(row));
        }
        if (holds_out) {
            alternatives.add({"the study's model", figure(d.baseline.chi2), fmt::format("{:.2g}", d.baseline.p_value),
                              "", "", figure(*reported_before.held_out_rms)});
        }
        text += alternatives.text();
    }
    if (!d.confounding.empty() && d.verdict() != Verdict::unexplained) {
        text += "\nHardest to tell from " + f.candidates[d.confounding[0].a].effect + " with these readings\n";
        Table pairs({"effect", "cosine", "best possible rate"});
        constexpr std::size_t shown = 4;
        for (std::size_t i = 0; i < std::min(shown, d.confounding.size()); ++i) {
            pairs.add({f.candidates[d.confounding[i].b].effect, fmt::format("{:.2f}", d.confounding[i].cosine),
                       percent(d.confounding[i].rate)});
        }
        text += pairs.text();
    }
    text += d.verdict() == Verdict::unexplained ? "\nParameters and outputs of models that do not explain these data\n"
                                                : "\nParameters and outputs\n";
    Table values(f.after ? std::vector<std::string>{"", "before", "95 % from", "to", "after", "95 % from", "to", "unit"}
                         : std::vector<std::string>{"", "value", "95 % from", "to", "unit"});
    const auto& space = (f.after ? f.after->study : reported_before.study).space;
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        std::vector<std::string> row{space.axes[k].name};
        const auto add = [&](const DiagnosedModel& r) {
            if (k < r.parameters.size()) {
                const auto& i = r.parameters[k];
                row.insert(row.end(), {figure(i.value), figure(i.low), figure(i.high)});
            } else {
                row.insert(row.end(), {"", "", ""});
            }
        };
        add(reported_before);
        if (f.after) {
            add(*f.after);
        }
        row.emplace_back("");
        values.add(std::move(row));
    }
    for (const std::size_t i : f.study.outputs()) {
        const data::Reading& output = f.study.readings[i];
        std::vector<std::string> row{output.output, figure(output.in_unit(reported_before.evaluation.responses[i])), "",
                                     ""};
        if (f.after) {
            row.insert(row.end(), {figure(output.in_unit(f.after->evaluation.responses[i])), "", ""});
        }
        row.emplace_back(output.unit.name);
        values.add(std::move(row));
    }
    return text + values.text();
}

std::string diagnose_text(const DiagnoseResult& result, const analysis::RunOptions& run) {
    std::string text = fmt::format(
        "{0}\n  {1} computed in {2}, {3} kept from before\n{4}\n{5}\n  results: {6}/diagnose.json, this page: "
        "{6}/diagnose.txt\n",
        study_summary(result.study), counted(static_cast<std::size_t>(result.tally.computed), "run", "runs"),
        run::duration_words(result.seconds), result.tally.kept,
        result.reduced
            ? fmt::format("{}  {} explored by the reduced model, all below is the full model's\n",
                          reduced_words(*result.reduced),
                          counted(static_cast<std::size_t>(result.options.settings.explore), "point", "points"))
            : "",
        diagnosis_page(result), run.folder);
    if (result.is_extended()) {
        text += fmt::format("  the extended study: {}\n", run.folder + "/extended.toml");
    }
    return text;
}

} // namespace explore::report

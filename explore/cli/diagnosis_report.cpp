#include "cli/diagnosis_report.h"

#include "cli/common.h"
#include "pavement/effects/effect.h"
#include "report/table.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::cli {
namespace {

using diagnose::Diagnosis;
using diagnose::Judged;
using diagnose::Members;
using diagnose::Verdict;
using report::counted;
using report::figure;
using report::Json;

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

std::string variant_words(const diagnose::Candidate& candidate) {
    return candidate.effect + (candidate.on.empty() ? "" : " (" + candidate.on + ")");
}

std::string members_words(const std::vector<diagnose::Candidate>& candidates, const Members& members) {
    std::vector<std::string> words;
    words.reserve(members.size());
    for (const std::size_t c : members) {
        words.push_back(variant_words(candidates[c]));
    }
    return pave::join(words, " with ");
}

std::string percent(double share) {
    return fmt::format("{:.{}f} %", 100.0 * share,
                       share > 0.999 || share < 0.001 ? 2
                       : share > 0.99 || share < 0.01 ? 1
                                                      : 0);
}

std::string chance(double p) {
    return p < 1e-4 ? "less than 1 in 10,000" : fmt::format("{:.2g}", p);
}

// "+3.1"; "-": there is none.
std::string change_words(double change) {
    return std::isfinite(change) ? fmt::format("{:+.1f}", change) : "-";
}

class Sentences : Findings {
public:
    explicit Sentences(const Findings& findings) : Findings(findings) {}

    std::vector<std::string> all() const {
        std::vector<std::string> text;
        verdict(text);
        wrong(text);
        if (after) {
            gain(text);
        }
        if (!next.empty()) {
            const Separating& best = next[0];
            text.push_back(fmt::format(
                "One reading more that would help most: {} (to {} {}). It would raise the rate of the right decision "
                "between the closest two from {} to {}.",
                best.reading, figure(best.sigma), best.unit, percent(best.rate_now), percent(best.power)));
        }
        return text;
    }

private:
    std::string effect_words(std::size_t member) const {
        const auto& interval = after->parameters[study.space.axes.size() + member];
        const std::size_t c = d.extended->model.members[member];
        const auto& effect = *variants[c].applied.effect;
        return fmt::format("{} = {} [{}] (95 %: {} to {})", variant_words(candidates[c]), figure(interval.value),
                           effect.unit, figure(interval.low), figure(interval.high));
    }

    void verdict(std::vector<std::string>& text) const {
        switch (d.verdict) {
        case Verdict::adequate:
            text.push_back("ADEQUATE: nothing in these data contradicts the model beyond their noise.");
            if (study.noise == study::NoiseSource::estimated) {
                text.push_back("The data state no noise: it was taken from what the fit leaves over, so a model that "
                               "is wrong everywhere by a like amount would not be noticed.");
            }
            break;
        case Verdict::cause_named: {
            std::vector<std::string> found;
            for (std::size_t m = 0; m < d.extended->model.members.size(); ++m) {
                found.push_back(effect_words(m));
            }
            text.push_back("CAUSE NAMED: the model lacks " + pave::join(found, " and ") + ".");
            for (const std::size_t c : d.extended->model.members) {
                text.emplace_back(variants[c].applied.effect->mechanism);
            }
            break;
        }
        case Verdict::ambiguous: {
            std::vector<std::string> sets;
            for (const auto& e : d.explanations) {
                sets.push_back(members_words(candidates, e.fit.model.members));
            }
            if (sets.size() > 1) {
                text.push_back(fmt::format("AMBIGUOUS: the model lacks something, and {} explanations fit these data "
                                           "so alike that they cannot be told apart: {}.",
                                           sets.size(), pave::join(sets, "; ")));
            } else if (d.leaves_more_than_noise) {
                text.push_back(
                    fmt::format("AMBIGUOUS: {} explains most of the contradiction, but leaves more than noise "
                                "(p = {:.2g}): something else is missing too, or this is not quite it.",
                                sets[0], std::min(d.extended->p_value, d.extended->pattern.p_value)));
            } else if (d.extended->model.members.size() > 1) {
                text.push_back(fmt::format("AMBIGUOUS: {} together explain the data, but one explains so little beyond "
                                           "the other that both may stand for one thing outside the catalogue.",
                                           sets[0]));
            } else {
                text.push_back(
                    fmt::format("AMBIGUOUS: {} explains the data, but the evidence is too weak to name it.", sets[0]));
            }
            break;
        }
        case Verdict::unexplained:
            text.push_back("UNEXPLAINED: the data contradict the model, and no effect of the catalogue, alone or in "
                           "pairs, explains it. The pattern that remains is shown below.");
            if (study.noise == study::NoiseSource::stated) {
                text.push_back(
                    fmt::format("If the model were right, the noise would have to be {} times what is stated.",
                                figure(std::sqrt(d.baseline.chi2 / std::max(1, d.baseline.dof)))));
            }
            break;
        }
    }

    void wrong(std::vector<std::string>& text) const {
        if (study.noise == study::NoiseSource::stated) {
            text.push_back(fmt::format(
                "The study's model leaves chi2 = {} with {}: {}.", figure(d.baseline.chi2),
                counted(static_cast<std::size_t>(std::max(0, d.baseline.dof)), "degree of freedom",
                        "degrees of freedom"),
                d.baseline.p_value < 0.01
                    ? fmt::format("the stated noise explains so much with probability {}", chance(d.baseline.p_value))
                    : fmt::format("the stated noise explains that (p = {:.2g})", d.baseline.p_value)));
        }
        if (d.verdict == Verdict::adequate) {
            return;
        }
        for (std::size_t g = 0; g < layout.groups.size(); ++g) {
            const auto& test = d.groups[g];
            constexpr double clear = 0.02;
            if (test.p_sign < clear) {
                text.push_back(fmt::format("{}: the model lies {} nearly everywhere (sign test p = {:.2g}).",
                                           layout.groups[g].name, test.mean > 0.0 ? "too high" : "too low",
                                           test.p_sign));
            }
            if (test.p_runs < clear) {
                text.push_back(
                    fmt::format("{}: the residuals follow a pattern along the positions (runs test p = {:.2g}).",
                                layout.groups[g].name, test.p_runs));
            }
        }
        constexpr double strong = 4.0;
        if (!d.constancy.empty() && std::abs(d.constancy[0].score) > strong) {
            const auto& c = d.constancy[0];
            text.push_back(fmt::format("{} wants a {} {} than the other readings ({:.1f} standard errors).",
                                       layout.groups[c.group].name, c.score > 0.0 ? "higher" : "lower",
                                       study.space.axes[c.axis].name, std::abs(c.score)));
        }
    }

    void gain(std::vector<std::string>& text) const {
        text.push_back(fmt::format(
            "With {} the misfit falls from {} to {}, chi2 from {} to {}{}{}.",
            members_words(candidates, d.extended->model.members), figure(before.misfit), figure(after->misfit),
            figure(d.baseline.chi2), figure(d.extended->chi2),
            study.noise == study::NoiseSource::stated ? fmt::format(" (p = {:.2g})", d.extended->p_value) : "",
            std::isfinite(d.extended->aicc - d.baseline.aicc)
                ? "; AICc changes by " + figure(d.extended->aicc - d.baseline.aicc)
                : "; AICc says nothing of so many parameters for so few readings"));
        if (d.places) {
            text.push_back(
                fmt::format("Readings left out of the fit, place by place, are predicted with an error of {} "
                            "instead of {} standard deviations.",
                            figure(d.places->after), figure(d.places->before)));
        }
        if (d.loads) {
            text.push_back(
                fmt::format("Load by load: {} instead of {}.", figure(d.loads->after), figure(d.loads->before)));
        }
        if (before.held_out_rms && after->held_out_rms) {
            text.push_back(fmt::format("The {} that the study holds out are predicted with {} instead of {}.",
                                       counted(before.held_out, "reading", "readings"), figure(*after->held_out_rms),
                                       figure(*before.held_out_rms)));
        }
        std::vector<std::string> biased;
        for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
            const auto& was = before.parameters[k];
            const auto& is = after->parameters[k];
            if (was.value < is.low || was.value > is.high) {
                biased.push_back(
                    fmt::format("{} {} instead of {}", study.space.axes[k].name, figure(is.value), figure(was.value)));
            }
        }
        if (!biased.empty()) {
            text.push_back("Without the effect the fit was biased: " + pave::join(biased) + ".");
        }
    }
};

// Residuals in standard deviations, one a reading in the order of the data files; those not fitted are not numbers.
std::vector<double> residuals_of(const Findings& f, const diagnose::Model& model) {
    std::vector<double> residuals(f.study.measurements.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t t = 0; t < f.layout.rows.size(); ++t) {
        residuals[f.layout.rows[t]] = model.residuals[static_cast<Eigen::Index>(t)] / std::sqrt(f.d.variance);
    }
    return residuals;
}

Json judged_json(const Judged& judged, double misfit, const std::string& study_path) {
    return {{"misfit", misfit},          {"chi2", judged.chi2}, {"dof", judged.dof},
            {"p_value", judged.p_value}, {"aicc", judged.aicc}, {"p_pattern", judged.pattern.p_value},
            {"study", study_path}};
}

Json intervals_json(const problem::ParameterSpace& space, const std::vector<diagnose::Interval>& intervals) {
    Json json = Json::object();
    for (std::size_t k = 0; k < intervals.size(); ++k) {
        json[space.axes[k].name] = {
            {"value", intervals[k].value}, {"low", intervals[k].low}, {"high", intervals[k].high}};
    }
    return json;
}

Json held_out_json(const diagnose::HeldOut& held) {
    Json folds = Json::array();
    for (const auto& fold : held.folds) {
        folds.push_back({{"left_out", fold.name}, {"rmse_before", fold.before}, {"rmse_after", fold.after}});
    }
    return {{"rmse_before", held.before}, {"rmse_after", held.after}, {"readings", held.readings}, {"folds", folds}};
}

Json separating_json(const Separating& s, const std::vector<diagnose::Candidate>& candidates, const Diagnosis& d) {
    Json foretold = Json::array();
    for (std::size_t e = 0; e < s.values.size(); ++e) {
        foretold.push_back(
            {{"explanation", members_words(candidates, d.explanations[e].fit.model.members)}, {"value", s.values[e]}});
    }
    return {{"reading", s.reading}, {"unit", s.unit},         {"sigma", s.sigma},
            {"power", s.power},     {"rate_now", s.rate_now}, {"foretold", foretold}};
}

} // namespace

Json diagnosis_json(const Findings& f) {
    const Diagnosis& d = f.d;
    const bool is_extended = f.after && d.verdict != Verdict::unexplained;
    Json json = {{"verdict", std::string(diagnose::verdict_names[static_cast<int>(d.verdict)])},
                 {"causes", d.causes},
                 {"baseline", judged_json(d.baseline, f.before.misfit, f.study.file)}};
    json["baseline"]["parameters"] = intervals_json(f.before.study.space, f.before.parameters);
    if (f.study.noise == study::NoiseSource::estimated) {
        json["baseline"]["p_value"] = d.screening.p_familywise; // the only evidence there is
    }
    json["baseline"]["p_familywise"] = d.screening.p_familywise;
    const Judged& best = is_extended ? *d.extended : d.baseline;
    const Reported& reported = is_extended ? *f.after : f.before;
    json["extended"] = judged_json(best, reported.misfit, is_extended ? f.extended_path : f.study.file);
    json["extended"]["parameters"] = intervals_json(reported.study.space, reported.parameters);
    if (is_extended) {
        json["extended"]["effects"] = Json::array();
        for (const std::size_t c : best.model.members) {
            json["extended"]["effects"].push_back({{"effect", f.candidates[c].effect}, {"on", f.candidates[c].on}});
        }
    }
    Json gain = {{"misfit_reduction", is_extended ? 1.0 - reported.misfit / f.before.misfit : 0.0},
                 {"held_out_rmse_before", nullptr},
                 {"held_out_rmse_after", nullptr},
                 {"delta_aicc", best.aicc - d.baseline.aicc}};
    if (d.places) {
        gain["held_out_rmse_before"] = d.places->before;
        gain["held_out_rmse_after"] = is_extended ? d.places->after : d.places->before;
        gain["by_place"] = held_out_json(*d.places);
    }
    if (d.loads) {
        gain["by_load"] = held_out_json(*d.loads);
    }
    if (f.before.held_out_rms) {
        gain["study_held_out"] = {{"readings", f.before.held_out},
                                  {"rms_before", *f.before.held_out_rms},
                                  {"rms_after", *reported.held_out_rms}};
    }
    json["gain"] = std::move(gain);
    json["evidence"] = {{"p_familywise", d.p_evidence},
                        {"bartlett_factor", d.bartlett},
                        {"bootstrap", d.bootstrap},
                        {"bootstrap_as_large", d.bootstrap_above}};
    Json candidates = Json::array();
    for (const auto& effect : d.effects) {
        Json one = {{"effect", f.candidates[effect.candidate].effect},
                    {"on", f.candidates[effect.candidate].on},
                    {"unit", std::string(f.variants[effect.candidate].applied.effect->unit)},
                    {"variants", effect.variants},
                    {"score_z", effect.score},
                    {"p_familywise", effect.p_familywise},
                    {"delta_aicc", nullptr},
                    {"size", nullptr},
                    {"size_low", nullptr},
                    {"size_high", nullptr}};
        if (effect.fit) {
            one["delta_aicc"] = effect.delta_aicc;
            one["delta_chi2"] = -effect.gain;
            one["chi2"] = effect.fit->chi2;
            one["p_value"] = effect.fit->p_value;
            one["size"] = effect.size.value;
            one["size_low"] = effect.size.low;
            one["size_high"] = effect.size.high;
        } else {
            one["not_fitted"] = effect.impossible;
        }
        candidates.push_back(std::move(one));
    }
    json["candidates"] = std::move(candidates);
    Json explanations = Json::array();
    for (const auto& e : d.explanations) {
        Json names = Json::array();
        for (const std::size_t c : e.fit.model.members) {
            names.push_back({{"effect", f.candidates[c].effect}, {"on", f.candidates[c].on}});
        }
        explanations.push_back({{"effects", names},
                                {"chi2", e.fit.chi2},
                                {"p_value", e.fit.p_value},
                                {"delta_aicc", e.fit.aicc - d.baseline.aicc},
                                {"behind", e.behind}});
        if (const auto& rms = f.held_out[explanations.size() - 1]) {
            explanations.back()["study_held_out_rms"] = *rms;
        }
    }
    json["explanations"] = std::move(explanations);
    Json confounding = Json::array();
    for (const auto& pair : d.confounding) {
        confounding.push_back({{"effect", f.candidates[pair.a].effect},
                               {"other", f.candidates[pair.b].effect},
                               {"cosine", pair.cosine},
                               {"rate", pair.rate}});
    }
    json["confounding"] = std::move(confounding);
    json["next_measurement"] = f.next.empty() ? Json::object() : separating_json(f.next[0], f.candidates, d);
    Json groups = Json::array();
    for (std::size_t g = 0; g < f.layout.groups.size() && g < d.groups.size(); ++g) {
        const auto& test = d.groups[g];
        groups.push_back({{"group", f.layout.groups[g].name},
                          {"readings", f.layout.groups[g].terms.size()},
                          {"chi2", test.chi2},
                          {"mean", test.mean},
                          {"p_sign", test.p_sign},
                          {"p_runs", test.p_runs}});
    }
    json["groups"] = std::move(groups);
    Json constancy = Json::array();
    for (const auto& c : d.constancy) {
        constancy.push_back({{"parameter", f.study.space.axes[c.axis].name},
                             {"group", f.layout.groups[c.group].name},
                             {"score_z", c.score}});
    }
    json["parameter_constancy"] = std::move(constancy);
    std::vector<double> measured;
    std::vector<double> baseline;
    std::vector<double> extended;
    for (std::size_t i = 0; i < f.study.measurements.size(); ++i) {
        const double si = f.study.response_to_si(i);
        measured.push_back(f.study.measurements[i].value * f.study.measurements[i].unit.to_si / si);
        baseline.push_back(f.before.evaluation.responses[i] / si);
        if (f.after) {
            extended.push_back(f.after->evaluation.responses[i] / si);
        }
    }
    json["readings"] = Json::array();
    for (std::size_t i = 0; i < f.study.measurements.size(); ++i) {
        Json reading = report::place_json(f.study, i);
        reading["unit"] = std::string(f.study.response_unit(i));
        json["readings"].push_back(std::move(reading));
    }
    json["responses"] = {{"measured", measured}, {"baseline", baseline}, {"extended", extended}};
    json["residuals"] = {{"baseline", residuals_of(f, d.baseline.model)},
                         {"extended", d.extended ? residuals_of(f, d.extended->model) : std::vector<double>{}}};
    Json outputs = Json::array();
    for (std::size_t o = 0; o < f.study.outputs.size(); ++o) {
        const std::size_t i = f.study.measurements.size() + o;
        const double si = f.study.response_to_si(i);
        outputs.push_back({{"name", f.study.outputs[o].name},
                           {"unit", std::string(f.study.response_unit(i))},
                           {"before", f.before.evaluation.responses[i] / si},
                           {"after", reported.evaluation.responses[i] / si}});
    }
    json["outputs"] = std::move(outputs);
    json["noise"] = {{"source", f.study.noise_name()}, {"residual_standard_deviation", std::sqrt(d.variance)}};
    json["findings"] = Sentences(f).all();
    return json;
}

std::string diagnosis_page(const Findings& f) {
    const Diagnosis& d = f.d;
    const std::vector<double> before = residuals_of(f, d.baseline.model);
    const std::vector<double> after = d.extended ? residuals_of(f, d.extended->model) : std::vector<double>{};
    std::string text;
    for (const std::string& sentence : Sentences(f).all()) {
        text += "  " + sentence + "\n";
    }
    text += "\nResiduals (model - measured) in standard deviations, of the study's model";
    text += after.empty() ? "\n" : ", and with " + members_words(f.candidates, d.extended->model.members) + "\n";
    text += fmt::format("  {}\n", sign_convention);
    std::vector<std::string> header{"load", "reading", "before", "-4       0       4"};
    if (!after.empty()) {
        header.insert(header.end(), {"after", "-4       0       4"});
    }
    report::Table picture(header);
    for (const auto& group : f.layout.groups) {
        for (const std::size_t t : group.terms) {
            const std::size_t row = f.layout.rows[t];
            const auto& m = f.study.measurements[row];
            std::vector<std::string> line{m.load, place_words(m), fmt::format("{:+.1f}", before[row]),
                                          bar(before[row])};
            if (!after.empty()) {
                line.push_back(fmt::format("{:+.1f}", after[row]));
                line.push_back(bar(after[row]));
            }
            picture.add(std::move(line));
        }
    }
    text += picture.text();
    text +=
        fmt::format("\nCandidates (score in standard deviations; under noise alone the largest exceeds {:.1f} in 5 % "
                    "of cases)\n",
                    d.screening.threshold);
    report::Table table({"effect", "on", "score", "p", "chi2 falls by", "AICc", "size", "95 % from", "to", "unit"});
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
    }
    text += table.text();
    if (d.explanations.size() > 1) {
        text += "\nExplanations that these data do not tell apart\n";
        const bool holds_out = f.before.held_out_rms.has_value();
        std::vector<std::string> columns{"", "chi2", "p", "AICc", "behind by"};
        if (holds_out) {
            columns.emplace_back("error of what the study holds out");
        }
        report::Table alternatives(columns);
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
                              "", "", figure(*f.before.held_out_rms)});
        }
        text += alternatives.text();
    }
    if (!d.confounding.empty() && d.verdict != Verdict::unexplained) {
        text += "\nHardest to tell from " + f.candidates[d.confounding[0].a].effect + " with these readings\n";
        report::Table pairs({"effect", "cosine", "best possible rate"});
        constexpr std::size_t shown = 4;
        for (std::size_t i = 0; i < std::min(shown, d.confounding.size()); ++i) {
            pairs.add({f.candidates[d.confounding[i].b].effect, fmt::format("{:.2f}", d.confounding[i].cosine),
                       percent(d.confounding[i].rate)});
        }
        text += pairs.text();
    }
    text += "\nParameters and outputs\n";
    report::Table values(
        f.after ? std::vector<std::string>{"", "before", "95 % from", "to", "after", "95 % from", "to", "unit"}
                : std::vector<std::string>{"", "value", "95 % from", "to", "unit"});
    const auto& space = (f.after ? f.after->study : f.before.study).space;
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        std::vector<std::string> row{space.axes[k].name};
        const auto add = [&](const Reported& r) {
            if (k < r.parameters.size()) {
                const auto& i = r.parameters[k];
                row.insert(row.end(), {figure(i.value), figure(i.low), figure(i.high)});
            } else {
                row.insert(row.end(), {"", "", ""});
            }
        };
        add(f.before);
        if (f.after) {
            add(*f.after);
        }
        row.emplace_back("");
        values.add(std::move(row));
    }
    for (std::size_t o = 0; o < f.study.outputs.size(); ++o) {
        const std::size_t i = f.study.measurements.size() + o;
        const double si = f.study.response_to_si(i);
        std::vector<std::string> row{f.study.outputs[o].name, figure(f.before.evaluation.responses[i] / si), "", ""};
        if (f.after) {
            row.insert(row.end(), {figure(f.after->evaluation.responses[i] / si), "", ""});
        }
        row.emplace_back(f.study.response_unit(i));
        values.add(std::move(row));
    }
    return text + values.text();
}

} // namespace explore::cli

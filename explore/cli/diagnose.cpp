// pavescape diagnose: what the simulation gets wrong, the cause, the extended model, the gain.
#include "cli/common.h"
#include "cli/groups.h"
#include "diagnose/diagnosis.h"
#include "pavement/effects/effect.h"
#include "report/table.h"
#include "run/progress.h"
#include "study/candidates.h"
#include "study/variants.h"

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
using report::figure;
using report::Json;

struct DiagnoseOptions {
    CommonOptions common;
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

// "deflection at 300 mm", "strain_zz 112 mm deep"
std::string place_words(const data::Measurement& m) {
    return m.quantity == "deflection" ? fmt::format("deflection at {:g} mm", m.x_mm)
           : m.x_mm != 0.0            ? fmt::format("{} {:g} mm deep at {:g} mm", m.quantity, m.depth_mm, m.x_mm)
                                      : fmt::format("{} {:g} mm deep", m.quantity, m.depth_mm);
}

// The study and everything that names its terms: the fitted readings in the order of its groups.
struct Layout {
    std::vector<std::size_t> rows; // the reading of each term
    std::vector<diagnose::ReadingGroup> groups;
    std::vector<diagnose::Fold> places, loads;
};

Layout layout_of(const study::Study& study) {
    Layout layout;
    std::vector<diagnose::Fold> places;
    for (const auto& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        diagnose::ReadingGroup own{.name = group.name, .terms = {}};
        for (const std::size_t row : group.rows) {
            const std::size_t term = layout.rows.size();
            layout.rows.push_back(row);
            own.terms.push_back(term);
            const auto& m = study.measurements[row];
            const auto add = [&](std::vector<diagnose::Fold>& folds, const std::string& name) {
                auto fold = std::find_if(folds.begin(), folds.end(), [&](const auto& f) { return f.name == name; });
                if (fold == folds.end()) {
                    fold = folds.insert(folds.end(), {.name = name, .terms = {}});
                }
                fold->terms.push_back(term);
            };
            add(places, place_words(m));
            add(layout.loads, m.load);
        }
        std::stable_sort(own.terms.begin(), own.terms.end(), [&](std::size_t a, std::size_t b) {
            const auto& first = study.measurements[layout.rows[a]];
            const auto& second = study.measurements[layout.rows[b]];
            return std::tie(first.x_mm, first.y_mm, first.depth_mm) <
                   std::tie(second.x_mm, second.y_mm, second.depth_mm);
        });
        layout.groups.push_back(std::move(own));
    }
    constexpr std::size_t most = 10; // folds
    for (std::size_t p = 0; p < places.size(); ++p) {
        if (p < most) {
            layout.places.push_back(places[p]);
        } else {
            auto& fold = layout.places[p % most];
            fold.name += " and " + places[p].name;
            fold.terms.insert(fold.terms.end(), places[p].terms.begin(), places[p].terms.end());
        }
    }
    return layout;
}

// A model of the diagnosis with everything a report asks of it.
struct Reported {
    study::Study study; // with the effects, their sizes free
    problem::Evaluation evaluation;
    double misfit = 0.0;                        // the study's own
    std::vector<diagnose::Interval> parameters; // the effects' sizes last
    std::optional<double> held_out_rms;         // of the readings the study holds out, standard deviations
    std::size_t held_out = 0;
};

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
    double squares = 0.0;
    for (const auto& group : study.groups) {
        if (!group.held_out || study.sigma.empty()) {
            continue;
        }
        for (const std::size_t i : group.rows) {
            const double measured = study.measurements[i].value * study.measurements[i].unit.to_si;
            squares += std::pow((r.evaluation.responses[i] - measured) / study.sigma[i], 2);
            ++r.held_out;
        }
    }
    if (r.held_out > 0) {
        r.held_out_rms = std::sqrt(squares / static_cast<double>(r.held_out));
    }
    r.misfit = study::make_problem(study, study::Scope::fitted).misfit.residuals(r.evaluation.responses).norm();
    return r;
}

// One reading that would separate what the data leave ambiguous.
struct Separating {
    std::string reading, unit;
    double sigma = 0.0;
    std::vector<double> values; // foretold by each explanation
    double power = 0.0;         // the rate of the right decision between the best explanation and its closest rival
    double rate_now = 0.0;      // the same with the present readings
};

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

struct Findings {
    const study::Study& study;
    const std::vector<study::Variant>& variants;
    const std::vector<diagnose::Candidate>& candidates;
    const Layout& layout;
    const Diagnosis& d;
    const Reported& before;
    const std::optional<Reported>& after;
    const std::vector<Separating>& next;
    const std::vector<std::optional<double>>& held_out; // of each explanation: see Reported

    std::vector<std::string> sentences() const {
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
            "With {} the misfit falls from {} to {}, chi2 from {} to {}{}; AICc changes by {}.",
            members_words(candidates, d.extended->model.members), figure(before.misfit), figure(after->misfit),
            figure(d.baseline.chi2), figure(d.extended->chi2),
            study.noise == study::NoiseSource::stated ? fmt::format(" (p = {:.2g})", d.extended->p_value) : "",
            figure(d.extended->aicc - d.baseline.aicc)));
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

Json diagnosis_json(const Findings& f, const std::string& extended_path, const std::vector<double>& baseline_residuals,
                    const std::vector<double>& extended_residuals) {
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
    json["extended"] = judged_json(best, reported.misfit, is_extended ? extended_path : f.study.file);
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
    json["residuals"] = {{"baseline", baseline_residuals}, {"extended", extended_residuals}};
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
    json["noise"] = {{"source", f.study.noise == study::NoiseSource::stated ? "stated" : "estimated"},
                     {"residual_standard_deviation", std::sqrt(d.variance)}};
    json["findings"] = f.sentences();
    return json;
}

// Residuals in standard deviations, one a reading in the order of the data files; those not fitted are not numbers.
std::vector<double> residuals_of(const study::Study& study, const Layout& layout, const diagnose::Model& model,
                                 double variance) {
    std::vector<double> residuals(study.measurements.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t t = 0; t < layout.rows.size(); ++t) {
        residuals[layout.rows[t]] = model.residuals[static_cast<Eigen::Index>(t)] / std::sqrt(variance);
    }
    return residuals;
}

std::string page(const Findings& f, const std::vector<double>& before, const std::vector<double>& after) {
    const Diagnosis& d = f.d;
    std::string text;
    for (const std::string& sentence : f.sentences()) {
        text += "  " + sentence + "\n";
    }
    text += "\nResiduals (model - measured) in standard deviations, of the study's model";
    text += after.empty() ? "\n" : ", and with " + members_words(f.candidates, d.extended->model.members) + "\n";
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
                   fmt::format("{:.2g}", effect.p_familywise), figure(effect.gain),
                   fmt::format("{:+.1f}", effect.delta_aicc), figure(effect.size.value), figure(effect.size.low),
                   figure(effect.size.high), std::string(f.variants[effect.candidate].applied.effect->unit)});
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
                                         fmt::format("{:+.1f}", own.fit.aicc - d.baseline.aicc), figure(own.behind)};
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

int diagnose_study(const DiagnoseOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    const study::Study study = study::load_study(options.common.study);
    study::make_problem(study, study::Scope::fitted); // complains of what is missing
    for (const std::string& name : options.without) {
        study::effect_named(name, {.key = "--without"});
    }
    const std::vector<study::Variant> variants = study::variants(study, options.without);
    const Layout layout = layout_of(study);
    const std::string settings = fmt::format("{} explored, {} starts, {} simulated, seed {}", options.analysis.explore,
                                             options.analysis.starts, options.analysis.bootstrap, options.common.seed);
    const std::string folder = options.common.folder(study);
    run::Store store(folder, true);
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
    const auto result = diagnose::diagnose(task, options.analysis);
    if (!result) {
        return report_interrupt(folder);
    }
    const Diagnosis& d = *result;
    if (!d.failed.empty()) {
        if (options.common.json) {
            fmt::print("{}\n", Json{{"status", "failed"}, {"reason", d.failed}}.dump(2));
        }
        fmt::print(stderr, "pavescape: {}\n", d.failed);
        return computation_failed;
    }
    const Reported before = report_of(study, variants, bench, d.baseline, d.variance);
    std::optional<Reported> after;
    std::vector<double> residuals_after;
    std::string extended_path;
    if (d.extended) {
        after = report_of(study, variants, bench, *d.extended, d.variance);
        residuals_after = residuals_of(study, layout, d.extended->model, d.variance);
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
    const Findings findings{study, variants, task.candidates, layout, d, before, after, next, held_out};
    const auto residuals_before = residuals_of(study, layout, d.baseline.model, d.variance);
    Json json = diagnosis_json(findings, extended_path, residuals_before, residuals_after);
    json["study"] = {{"file", study.file}, {"title", study.title}, {"hash", study.hash}};
    json["version"] = PAVESCAPE_VERSION;
    json["seed"] = options.common.seed;
    json["run"] = folder;
    store.put_result(store.begin(run_header(study, "diagnose", settings)), json.dump());
    write_file(folder, "diagnose.json", json.dump(2) + "\n");
    const std::string text = page(findings, residuals_before, residuals_after);
    write_file(folder, "diagnose.txt", text);
    if (options.common.json) {
        fmt::print("{}\n", json.dump(2));
        return done;
    }
    const run::Tally tally = bench.tally();
    fmt::print(
        "{}\n  {} computed in {}, {} kept from before\n\n{}\n  results: {}/diagnose.json, this page: {}/diagnose.txt\n",
        study_summary(study), counted(static_cast<std::size_t>(tally.computed), "run", "runs"),
        run::duration_words(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()),
        tally.kept, text, folder, folder);
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

#include "analysis/diagnose/diagnose_verdict.h"

#include "analysis/common/say.h"
#include "analysis/diagnose/bottom_hint.h"
#include "base/text.h"
#include "inference/nuisance.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using diagnose::Verdict;
using pave::counted;
using pave::figure;
using pave::p_words;

namespace {

class VerdictSentences {
public:
    explicit VerdictSentences(const DiagnoseResult& of)
        : result(of),
          study(result.study),
          variants(result.variants),
          candidates(result.candidates),
          layout(result.layout),
          d(result.diagnosis),
          after(result.after) {}

    std::vector<std::string> all() const {
        std::vector<std::string> text;
        verdict(text);
        if (d.verdict() == Verdict::ambiguous && d.decision.is_noise_possible() &&
            d.decision.reason != diagnose::Reason::noise) {
            text.push_back(fmt::format("Noise alone is possible too: {}.", of_noise_words()));
        }
        if (d.decision.premise && d.extended) {
            text.push_back(fmt::format("{}: {}. All else is said with that mended.", seen_by(), premise_words()));
        }
        for (const data::BowlFault& fault : result.premises.faults) {
            if (!fault.is_mendable()) {
                text.push_back(fmt::format("Before any model: {}.", fault.words()));
            }
        }
        if (std::string words = probability_words(); !d.decision.as_stated && !words.empty()) {
            text.insert(text.begin() + 1, std::move(words));
        }
        return text;
    }

private:
    std::string effect_words(std::size_t member) const {
        const auto& interval = after->parameters[study.space.axes.size() + member];
        const std::size_t c = d.extended->model.members[member];
        pave::pavement::AppliedEffect applied = variants[c].applied;
        applied.size = interval.value;
        const auto& effect = *applied.effect;
        return fmt::format("{} = {} [{}] (95 %: {} to {}{}): {}", candidates[c].words(), figure(interval.value),
                           effect.unit, figure(interval.low), figure(interval.high),
                           d.extended->ends_range(member) ? "; its size is at the end of its range"
                           : d.extended->at_end && d.extended->model.members.size() == 1
                               ? ", which reaches the end of its range"
                               : "",
                           effect.in_words(applied));
    }

    std::string named_words() const {
        std::vector<std::string> words;
        for (std::size_t m = 0; m < d.extended->model.members.size(); ++m) {
            words.push_back(effect_words(m));
        }
        return pave::join(words, "; and ");
    }

    // The variants of the named effect that fit these readings as well.
    std::string alike_words() const {
        const auto& members = d.extended->model.members;
        const auto found = std::find_if(d.effects.begin(), d.effects.end(), [&](const auto& effect) {
            return members.size() == 1 && effect.candidate == members[0];
        });
        if (found == d.effects.end() || found->alike.empty()) {
            return "";
        }
        std::vector<std::string> others;
        for (const auto& other : found->alike) {
            others.push_back(fmt::format("{} = {} (95 %: {} to {}; chi2 {:.1f} higher)",
                                         candidates[other.candidate].words(), figure(other.size.value),
                                         figure(other.size.low), figure(other.size.high), other.behind));
        }
        return fmt::format("These readings do not tell it from {}: they say what acts, not where.",
                           pave::join(others, " or "));
    }

    // Other causes of a wrong deflection whose sensor reads once.
    std::string instrument_words(const pave::pavement::AppliedEffect& applied) const {
        if (!applied.effect->is_error_of_reading || !applied.reading || study.has_own_model) {
            return "";
        }
        const auto reading = static_cast<std::size_t>(*applied.reading);
        const pave::pavement::Sensor& sensor = study.model.sensors[reading];
        const std::string place = study.readings[reading].place_words();
        const bool reads_once = std::none_of(layout.rows.begin(), layout.rows.end(), [&](std::size_t row) {
            return row != reading && study.readings[row].place_words() == place;
        });
        return sensor.quantity == pave::pavement::Quantity::deflection && sensor.depth == 0.0 && reads_once
                   ? fmt::format("Its sensor ({}) may as well stand elsewhere or have another gain: readings under one "
                                 "load do not tell. Check where it stood.",
                                 place)
                   : "";
    }

    // Where every parameter of the study's model is pressed against an end of its range: "" elsewhere.
    std::string at_ends_words() const {
        const auto& unit = d.baseline.model.unit;
        const std::size_t axes = study.space.axes.size();
        const auto is_at_end = [](double u) { return std::min(u, 1.0 - u) < inference::end_of_range; };
        const bool are_at_ends =
            axes > 1 && unit.size() >= axes && std::all_of(unit.data(), unit.data() + axes, is_at_end);
        return are_at_ends ? "Every parameter of the study's model is on its bound: look first for a wrong unit of the "
                             "readings, a wrong load or a wrong section."
                           : "";
    }

    void verdict(std::vector<std::string>& text) const {
        if (d.decision.reason == diagnose::Reason::other_premise) {
            text.push_back(
                fmt::format("AMBIGUOUS: {}; or, with probability {}, {}. These readings do not tell which; what "
                            "lies below, by borings or maps, does.",
                            d.extended ? named_words() : premise_words(), percent(d.ledger.elsewhere()->probability),
                            d.ledger.elsewhere()->words));
            return;
        }
        switch (d.verdict()) {
        case Verdict::adequate:
            text.push_back(adequate_words());
            if (d.noise_is_overstated) {
                text.push_back(fmt::format(
                    "The readings scatter less than their stated noise: chi2 = {} with {}, some {} of it. Ranges and "
                    "tests "
                    "that rest on the stated noise are too cautious by that.",
                    figure(d.baseline.chi2),
                    counted(static_cast<std::size_t>(d.baseline.dof), "degree of freedom", "degrees of freedom"),
                    percent(std::sqrt(d.baseline.chi2 / d.baseline.dof))));
            }
            if (study.noise == study::NoiseSource::estimated) {
                text.push_back("The data state no noise: it was estimated from the residuals of the fit, so a model "
                               "that is wrong everywhere by a similar amount would not be noticed.");
            }
            break;
        case Verdict::cause_named: {
            std::vector<std::string> found;
            if (!d.extended) { // what was seen in the readings is all
                text.push_back(
                    d.decision.as_stated
                        ? fmt::format(
                              "CAUSE NAMED: {}. With that corrected the model fits the data within their noise.",
                              premise_words())
                        : fmt::format("CAUSE NAMED: {}. With that corrected the model fits, provided the noise is as "
                                      "follows: {}.",
                                      premise_words(), row_words(d.ledger.rows()[*d.decision.noise])));
                break;
            }
            for (std::size_t m = 0; m < d.extended->model.members.size(); ++m) {
                found.push_back(effect_words(m));
            }
            const auto& members = d.extended->model.members;
            const bool are_readings = std::all_of(members.begin(), members.end(), [&](std::size_t c) {
                return variants[c].applied.effect->is_error_of_reading;
            });
            text.push_back(fmt::format("CAUSE NAMED: {}{}.",
                                       !are_readings      ? "the model lacks "
                                       : found.size() > 1 ? "wrong readings, "
                                                          : "a wrong reading, ",
                                       pave::join(found, " and ")));
            if (d.decision.leaves_more_than_noise) {
                text.push_back(fmt::format("It leaves a little more than the stated noise ({}), as one right "
                                           "answer in twenty does; nothing else that was tried comes near.",
                                           p_words(std::min(d.extended->p_value, d.extended->pattern.p_value))));
            }
            say(text, alike_words());
            for (const std::size_t c : members) {
                say(text, instrument_words(variants[c].applied));
            }
            say(text, bottom_hint(result));
            for (const std::size_t c : members) {
                const std::string mechanism(variants[c].applied.effect->mechanism);
                say(text, std::find(text.begin(), text.end(), mechanism) == text.end() ? mechanism : "");
            }
            break;
        }
        case Verdict::ambiguous: {
            std::vector<std::string> sets;
            for (const auto& e : d.explanations) {
                sets.push_back(members_words(candidates, e.fit.model.members));
            }
            text.push_back(ambiguous_words(sets));
            say(text, bottom_hint(result));
            text.push_back(fmt::format("Best of them: {}.", named_words()));
            say(text, alike_words());
            break;
        }
        case Verdict::located: corrections(text); break;
        case Verdict::unexplained:
            unexplained(text);
            say(text, bottom_hint(result));
            text.emplace_back(
                "The values and 95 % ranges below are those of models that do not explain these data: they "
                "are no answer.");
            leftovers(text);
            break;
        }
    }

    // "probability 72 % in all; of these kinds of noise most probable: ... (24 %)"
    std::string of_noise_words() const {
        const double one = d.decision.probability_of(*d.decision.noise);
        const std::string words = row_words(d.ledger.rows()[*d.decision.noise]);
        constexpr double rest = 0.01;
        return d.decision.of_noise - one < rest
                   ? fmt::format("probability {}: {}", percent(one), words)
                   : fmt::format("probability {} over all kinds of noise; the most probable of them, {}: {}",
                                 percent(d.decision.of_noise), percent(one), words);
    }

    std::string_view seen_by() const {
        const auto& [faults, no_floor] = result.premises;
        return no_floor || std::ranges::any_of(faults, &data::BowlFault::is_by_model) ? "By the study's model"
                                                                                      : "Before any model";
    }

    std::string premise_words() const {
        std::vector<std::string> words;
        for (const auto& row : d.ledger.rows()) {
            if (row.is_premise) {
                words.push_back(row.hypothesis.name);
            }
        }
        return pave::join(words, "; ");
    }

    // The study's model as it is.
    std::string adequate_words() const {
        if (d.baseline.dof <= 0) {
            return "ADEQUATE, BUT UNTESTED: the parameters can follow every reading, so these data could not "
                   "contradict "
                   "any model. It takes more readings than parameters.";
        }
        if (d.decision.as_stated || !d.decision.noise) {
            return "ADEQUATE: nothing in these data contradicts the model beyond their noise.";
        }
        const auto& leading = d.ledger.rows()[*d.decision.noise];
        if (leading.hypothesis.kind == hypotheses::Kind::none) {
            return fmt::format("ADEQUATE: one test of the model stands out, but chance is more probable than all else "
                               "that was tried (probability {}).",
                               percent(d.decision.of_noise));
        }
        return fmt::format(
            "ADEQUATE, but for the noise: {}. Nothing else is needed to explain these data (all kinds of noise "
            "together: probability {}). State the noise so under [data.noise].",
            row_words(leading), percent(d.decision.of_noise));
    }

    std::string ambiguous_words(const std::vector<std::string>& sets) const {
        using diagnose::Reason;
        const std::string together = d.extended->model.members.size() > 1 ? "together explain" : "explains";
        switch (d.decision.reason) {
        case Reason::leaves_more_than_noise:
            return fmt::format(
                "AMBIGUOUS: the model lacks something, and no known effect explains all of it. {}: "
                "{}. {} ({}): something else is missing too, or this is not quite it{}.",
                sets.size() > 1 ? "What comes nearest, alike" : "What comes nearest", pave::join(sets, "; "),
                sets.size() > 1 ? "The best of them leaves more than noise" : "It leaves more than noise",
                p_words(std::min(d.extended->p_value, d.extended->pattern.p_value)), noise_words());
        case Reason::several_names:
            if (const double first = d.decision.probability_of(d.explanations[0].row); first > 0.9) {
                return fmt::format("AMBIGUOUS: the data favour {} (probability {}), but readings such as these do not "
                                   "surely tell it from {}.",
                                   sets[0], percent(first), pave::join({sets.begin() + 1, sets.end()}, "; "));
            }
            return fmt::format("AMBIGUOUS: the model lacks something, and {} explanations fit these data about equally "
                               "well; the readings cannot tell them apart: {}.",
                               sets.size(), pave::join(sets, "; "));
        case Reason::noise:
            return fmt::format("AMBIGUOUS: {} {} the data; so may noise alone: {}.", sets[0], together,
                               of_noise_words());
        case Reason::at_end:
            return fmt::format("AMBIGUOUS: {} {} the data, but {} the end of its range: the cause may be stronger, of "
                               "another form, or another one.",
                               sets[0], together,
                               d.extended->ends_range() ? "only with a size at" : "its size may as well lie at");
        case Reason::correction: {
            std::vector<std::string> where;
            for (const LocatedCorrection& found : result.located) {
                where.push_back(channel_words(found.correction));
            }
            return fmt::format("AMBIGUOUS: {} {} the data, but a smooth correction ({}) does so as well or better: the "
                               "cause may have another form, or be another one that the catalogue lacks.",
                               sets[0], together, pave::join(where, "; "));
        }
        case Reason::two_effects:
            return fmt::format("AMBIGUOUS: {} together explain the data, and no effect alone does. It takes two at "
                               "once: one thing that the catalogue lacks may do so as well.",
                               sets[0]);
        case Reason::finds_more:
            return fmt::format(
                "AMBIGUOUS: {} explains most of the data, but beside it a smooth correction of the model "
                "finds more: this is not quite it, or not all.",
                sets[0]);
        default:
            return fmt::format("AMBIGUOUS: {} {} the data, but the evidence is too weak to be sure of it.", sets[0],
                               together);
        }
    }

    void unexplained(std::vector<std::string>& text) const {
        using diagnose::Reason;
        std::string why = ", and no effect of the catalogue, alone or in pairs, explains it";
        constexpr double most = 0.5;
        if (d.decision.reason == Reason::nothing_explains && d.decision.noise && d.decision.of_noise >= most) {
            why += fmt::format(", unless {}", row_words(d.ledger.rows()[*d.decision.noise]));
        } else if (d.decision.reason == Reason::noise && d.decision.noise) {
            why = fmt::format(", or the noise is not as stated ({})", of_noise_words());
        } else if (!d.nearest.empty() && d.nearest[0].fit.p_value >= diagnose::level_noise) {
            why = fmt::format(", and no effect of the catalogue, alone or in pairs, has evidence enough to be "
                              "named (chance makes as much in {} of cases)",
                              percent(d.p_evidence));
        }
        text.push_back(fmt::format("UNEXPLAINED: the data contradict the model{}. The pattern that remains is shown "
                                   "below.",
                                   why));
        say(text, at_ends_words());
        if (study.noise == study::NoiseSource::stated) {
            text.push_back(fmt::format("If the model were right, the noise would have to be {} times what is stated.",
                                       figure(std::sqrt(d.baseline.chi2 / std::max(1, d.baseline.dof)), 2)));
        }
        if (!d.nearest.empty()) {
            text.push_back(fmt::format("What comes nearest is {}; it leaves chi2 = {} ({}){}.",
                                       members_words(candidates, d.nearest[0].fit.model.members),
                                       figure(d.nearest[0].fit.chi2), p_words(d.nearest[0].fit.p_value),
                                       noise_words()));
        }
        if (!result.located.empty()) {
            std::vector<std::string> where;
            for (const LocatedCorrection& found : result.located) {
                where.push_back(channel_words(found.correction));
            }
            text.push_back(fmt::format("A smooth correction ({}) leaves chi2 = {} ({}){}.", pave::join(where, "; "),
                                       figure(d.location->fit.chi2), p_words(d.location->fit.p_value),
                                       d.decision.reason == Reason::predicts_worse
                                           ? ", but readings that were left out are predicted worse with it than "
                                             "without: it follows these readings, not the road"
                                       : d.decision.reason == Reason::no_place
                                           ? ", but these readings do not say where it is"
                                           : ""));
        }
    }

    // The most probable explanation, its probability, the others; "": nothing was compared.
    std::string probability_words() const {
        const auto& ranked = d.decision.hypotheses;
        std::vector<std::string> words;
        constexpr std::size_t most = 4;
        constexpr double least = 0.005;
        for (const auto& [row, probability] : ranked) {
            if (!d.ledger.rows()[row].is_premise && words.size() < most && (probability >= least || words.empty())) {
                words.push_back(fmt::format("{} ({})", row_words(d.ledger.rows()[row]), percent(probability)));
            }
        }
        return words.empty() ? "" : fmt::format("Most probable of what was tried: {}.", pave::join(words, "; "));
    }

    // The result of every correction, and which effects of the catalogue it looks like.
    void corrections(std::vector<std::string>& text) const {
        std::vector<std::string> where;
        std::vector<std::string> certain;
        std::vector<std::string> vague;
        for (const LocatedCorrection& found : result.located) {
            where.push_back(channel_words(found.correction));
            (found.says_where() != diagnose::Says::nothing ? certain : vague).push_back(where.back());
        }
        const bool is_at_end =
            std::any_of(d.nearest.begin(), d.nearest.end(), [](const auto& e) { return e.fit.ends_range(); });
        text.push_back(fmt::format(
            "LOCATED: the data contradict the model, and no effect of the catalogue {}leaves noise only, but they say "
            "where it errs: {}{}. A smooth correction there {}.",
            is_at_end ? "within its range " : "", pave::join(certain, "; "),
            vague.empty() ? "" : fmt::format(" (with {}, of which they do not say where)", pave::join(vague, "; ")),
            d.decision.leaves_more_than_noise
                ? fmt::format("explains most of it, and still leaves more than noise ({})",
                              p_words(d.extended->p_value))
                : "leaves noise only"));
        for (std::size_t i = 0; i < result.located.size(); ++i) {
            const auto& own = d.location->corrections[i];
            for (std::string& words : result.located[i].says_where() != diagnose::Says::nothing
                                          ? words_of(result.located[i])
                                          : std::vector<std::string>()) {
                text.push_back(std::move(words));
            }
            std::string sentence = fmt::format("Noise alone would make some correction as likely as that of {} with "
                                               "probability {}.",
                                               where[i], chance_words(own.p_familywise));
            if (!own.alike.empty()) {
                std::vector<std::string> others;
                for (const std::size_t c : own.alike) {
                    others.push_back(channel_words(result.corrections[c]));
                }
                sentence += fmt::format(" Nearly as likely in its place: {}.", pave::join(others, "; "));
            }
            text.push_back(std::move(sentence));
            std::vector<std::string> names;
            constexpr std::size_t most = 3;
            for (std::size_t e = 0; e < std::min(most, own.explained_by.size()); ++e) {
                const auto& like = own.explained_by[e];
                const auto& effect = d.effects[like.effect];
                const bool ends = effect.fit && effect.fit->ends_range();
                names.push_back(
                    fmt::format("{} ({} of it, leaving {}{})", candidates[effect.candidate].words(),
                                percent(like.share), like.leaves_noise ? "noise" : "more than noise",
                                ends ? ", its size " + figure(effect.size.value) + " where its range ends" : ""));
            }
            if (!names.empty()) {
                text.push_back(fmt::format("Effects of the catalogue that look like it: {}.", pave::join(names, "; ")));
            }
        }
    }

    std::string noise_words() const {
        return d.decision.noise_factor > 1.0
                   ? fmt::format(", or the noise is {} times what is stated", figure(d.decision.noise_factor, 2))
                   : "";
    }

    // Where the study's model errs most: place, load and sign.
    void leftovers(std::vector<std::string>& text) const {
        const std::vector<double> residuals = residuals_of(result, d.baseline.model);
        std::vector<std::size_t> order = layout.rows;
        const auto size = [&](std::size_t row) { return std::abs(residuals[row]); };
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
        std::vector<std::string> places;
        constexpr std::size_t most = 4;
        constexpr double clear = 2.0;
        for (std::size_t i = 0; i < std::min(most, order.size()) && size(order[i]) > clear; ++i) {
            const double residual = residuals[order[i]];
            places.push_back(fmt::format("{}: {} by {} standard deviations", study.readings[order[i]].words(),
                                         residual > 0.0 ? "too high" : "too low", figure(std::abs(residual), 2)));
        }
        if (!places.empty()) {
            text.push_back("The model misses most at " + pave::join(places, "; ") + ".");
        }
    }

    const DiagnoseResult& result;
    const study::Study& study;
    const std::vector<study::Variant>& variants;
    const std::vector<diagnose::Candidate>& candidates;
    const Layout& layout;
    const diagnose::Diagnosis& d;
    const std::optional<DiagnosedModel>& after;
};

} // namespace

std::string chance_words(double p) {
    return p < 1e-4 ? "less than 1 in 10,000" : fmt::format("{:.2g}", p);
}

std::vector<std::string> verdict_words(const DiagnoseResult& result) {
    return VerdictSentences(result).all();
}

} // namespace explore::analysis

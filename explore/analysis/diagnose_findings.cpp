#include "analysis/diagnose.h"

#include "base/error.h"
#include "base/text.h"
#include "pavement/effects/effect.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using diagnose::Members;
using diagnose::Verdict;
using pave::counted;
using pave::figure;

namespace {

std::string variant_words(const diagnose::Candidate& candidate) {
    return candidate.effect + (candidate.on.empty() ? "" : " (" + candidate.on + ")");
}

std::string chance(double p) {
    return p < 1e-4 ? "less than 1 in 10,000" : fmt::format("{:.2g}", p);
}

} // namespace

std::string members_words(const std::vector<diagnose::Candidate>& candidates, const Members& members) {
    std::vector<std::string> words;
    words.reserve(members.size());
    for (const std::size_t c : members) {
        if (c < candidates.size()) {
            words.push_back(variant_words(candidates[c]));
        }
    }
    return words.empty() ? "the correction" : pave::join(words, " with ");
}

std::string percent(double share) {
    return fmt::format("{:.{}f} %", 100.0 * share,
                       share > 0.999 || share < 0.001 ? 2
                       : share > 0.99 || share < 0.01 ? 1
                                                      : 0);
}

namespace {

class Sentences {
public:
    explicit Sentences(const DiagnoseResult& of)
        : result(of),
          study(result.study),
          variants(result.variants),
          candidates(result.candidates),
          layout(result.layout),
          d(result.diagnosis),
          before(*result.before),
          after(result.after),
          mesh(result.mesh),
          outputs(result.outputs),
          next(result.next),
          telling(result.telling) {}

    std::vector<std::string> all() const {
        std::vector<std::string> text;
        verdict(text);
        if (std::string words = not_borne_out_words(); !words.empty()) {
            text.push_back(std::move(words));
        }
        wrong(text);
        if (after) {
            gain(text);
        }
        for (std::string& words : output_words(study, outputs)) {
            text.push_back(std::move(words));
        }
        if (std::string words = mesh_words(study, mesh); !words.empty()) {
            text.push_back(std::move(words));
        }
        if (std::string words = path_words(study, result.path); !words.empty()) {
            text.push_back(std::move(words));
        }
        if (const std::string weights = weights_words(study); !weights.empty()) {
            text.push_back(weights);
        }
        if (std::string words = noise_key_words(study); !words.empty()) {
            text.push_back(std::move(words));
        }
        if (!next.empty()) {
            const SeparatingReading& best = next[0];
            text.push_back(fmt::format(
                "The most informative further reading: {} (to {} {}). It would raise the rate of the right decision "
                "between the closest two from {} to {}.",
                best.words(), figure(best.reading.in_unit(best.reading.noise.absolute)), best.reading.unit.name,
                percent(best.rate_now), percent(best.power)));
        }
        if (!telling.empty()) {
            const auto& [reading, bits] = telling.front();
            text.push_back(
                fmt::format("The further reading that would say most of where the model errs: {} (noise {} {} "
                            "assumed), {:.1f} bits.",
                            reading.words(), figure(reading.in_unit(reading.noise.absolute)), reading.unit.name, bits));
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
        return fmt::format("{} = {} [{}] (95 %: {} to {}{}): {}", variant_words(candidates[c]), figure(interval.value),
                           effect.unit, figure(interval.low), figure(interval.high),
                           d.extended->ends_range(member) ? "; its size is at the end of its range" : "",
                           effect.in_words(applied));
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
                                         variant_words(candidates[other.candidate]), figure(other.size.value),
                                         figure(other.size.low), figure(other.size.high), other.behind));
        }
        return fmt::format("These readings do not tell it from {}: the effect is named, not where it acts.",
                           pave::join(others, " or "));
    }

    void verdict(std::vector<std::string>& text) const {
        switch (d.verdict) {
        case Verdict::adequate:
            text.push_back("ADEQUATE: nothing in these data contradicts the model beyond their noise.");
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
            for (std::size_t m = 0; m < d.extended->model.members.size(); ++m) {
                found.push_back(effect_words(m));
            }
            text.push_back("CAUSE NAMED: the model lacks " + pave::join(found, " and ") + ".");
            if (std::string words = alike_words(); !words.empty()) {
                text.push_back(std::move(words));
            }
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
            if (d.leaves_more_than_noise) {
                text.push_back(fmt::format(
                    "AMBIGUOUS: the model lacks something, and none of the catalogue explains all "
                    "of it. {}: {}. {} (p = {:.2g}): something else is missing too, or this is "
                    "not quite it{}.",
                    sets.size() > 1 ? "What comes nearest, alike" : "What comes nearest", pave::join(sets, "; "),
                    sets.size() > 1 ? "The best of them leaves more than noise" : "It leaves more than noise",
                    std::min(d.extended->p_value, d.extended->pattern.p_value), noise_words()));
            } else if (sets.size() > 1) {
                text.push_back(fmt::format("AMBIGUOUS: the model lacks something, and {} explanations fit these data "
                                           "so alike that they cannot be told apart: {}.",
                                           sets.size(), pave::join(sets, "; ")));
            } else if (d.extended->ends_range()) {
                text.push_back(fmt::format("AMBIGUOUS: {} explains the data, but only with a size at the end of its "
                                           "range: the cause may be stronger, of another form, or another one.",
                                           sets[0]));
            } else if (d.location) {
                std::vector<std::string> where;
                for (const LocatedCorrection& found : result.located) {
                    where.push_back(channel_words(found.correction));
                }
                text.push_back(fmt::format("AMBIGUOUS: {} {} the data, but a smooth correction ({}) does so as well "
                                           "or better: the cause may have another form, or be another one that the "
                                           "catalogue lacks.",
                                           sets[0],
                                           d.extended->model.members.size() > 1 ? "together explain" : "explains",
                                           pave::join(where, "; ")));
            } else if (d.extended->model.members.size() > 1) {
                text.push_back(
                    fmt::format("AMBIGUOUS: {} together explain the data, and no effect alone does. It takes "
                                "two at once: one thing that the catalogue lacks may do so as well.",
                                sets[0]));
            } else if (d.asks_for_correction) {
                text.push_back(fmt::format("AMBIGUOUS: {} explains most of the data, but beside it a smooth correction "
                                           "of the model finds more: this is not quite it, or not all.",
                                           sets[0]));
            } else {
                text.push_back(
                    fmt::format("AMBIGUOUS: {} explains the data, but the evidence is too weak to name it.", sets[0]));
            }
            for (std::size_t m = 0; m < d.extended->model.members.size(); ++m) {
                text.push_back("Best of them: " + effect_words(m) + ".");
            }
            break;
        }
        case Verdict::located: corrections(text); break;
        case Verdict::unexplained:
            text.push_back(
                fmt::format("UNEXPLAINED: the data contradict the model, and no effect of the catalogue, alone or in "
                            "pairs, {}. The "
                            "pattern that remains is shown below.",
                            !d.nearest.empty() && d.nearest[0].fit.p_value >= diagnose::level_noise
                                ? fmt::format("has evidence enough to be named (chance makes as much in {} of cases)",
                                              percent(d.p_evidence))
                                : "explains it"));
            if (study.noise == study::NoiseSource::stated) {
                text.push_back(
                    fmt::format("If the model were right, the noise would have to be {} times what is stated.",
                                figure(std::sqrt(d.baseline.chi2 / std::max(1, d.baseline.dof)), 2)));
            }
            if (!d.nearest.empty()) {
                text.push_back(fmt::format("What comes nearest is {}; it leaves chi2 = {} (p = {:.2g}){}.",
                                           members_words(candidates, d.nearest[0].fit.model.members),
                                           figure(d.nearest[0].fit.chi2), d.nearest[0].fit.p_value, noise_words()));
            }
            text.emplace_back(
                "The values and 95 % ranges below are those of models that do not explain these data: they "
                "are no answer.");
            leftovers(text);
            break;
        }
    }

    // What was found of every correction, and which effects of the catalogue it looks like.
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
            "LOCATED: the data contradict the model, and no effect of the catalogue {}explains it, but they say where "
            "it errs: {}{}. A smooth correction there {}.",
            is_at_end ? "within its range " : "", pave::join(certain, "; "),
            vague.empty() ? "" : fmt::format(" (with {}, of which they do not say where)", pave::join(vague, "; ")),
            d.leaves_more_than_noise
                ? fmt::format("explains most of it, and still leaves more than noise (p = {:.2g})", d.extended->p_value)
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
                                               where[i], chance(own.p_familywise));
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
                    fmt::format("{} ({} of it, leaving {}{})", variant_words(candidates[effect.candidate]),
                                percent(like.share), like.leaves_noise ? "noise" : "more than noise",
                                ends ? ", its size " + figure(effect.size.value) + " where its range ends" : ""));
            }
            if (!names.empty()) {
                text.push_back(fmt::format("Effects of the catalogue that look like it: {}.", pave::join(names, "; ")));
            }
        }
    }

    std::string noise_words() const {
        return d.noise_factor > 1.0
                   ? fmt::format(", or the noise is {} times what is stated", figure(d.noise_factor, 2))
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
            text.push_back(fmt::format("{} calls for a {} {} than the other readings ({:.1f} standard errors).",
                                       layout.groups[c.group].name, c.score > 0.0 ? "higher" : "lower",
                                       study.space.axes[c.axis].name, std::abs(c.score)));
        }
    }

    // Where readings that were left out speak against the extended model; "": they do not, or there is none.
    std::string not_borne_out_words() const {
        if (!result.is_extended()) {
            return "";
        }
        constexpr double clearly = 1.05;
        const auto is_worse = [](const auto& held) { return held && held->after > clearly * held->before; };
        const bool is_worse_held_out =
            before.held_out_rms && after->held_out_rms && *after->held_out_rms > clearly * *before.held_out_rms;
        if (!is_worse(d.places) && !is_worse(d.loads) && !is_worse_held_out) {
            return "";
        }
        const std::string words = members_words(candidates, d.extended->model.members);
        return fmt::format("What is left out of the fit speaks against it: it is predicted worse with {0} than without "
                           "(below). It follows these readings, not the road: more than one thing may differ from the "
                           "study, its thicknesses and the places of the sensors among them. Do not rely on {0}.",
                           words);
    }

    void gain(std::vector<std::string>& text) const {
        text.push_back(fmt::format(
            "With {} the misfit falls from {} to {}, chi2 from {} to {}{}{}.",
            members_words(candidates, d.extended->model.members), figure(before.misfit), figure(after->misfit),
            figure(d.baseline.chi2), figure(d.extended->chi2),
            study.noise == study::NoiseSource::stated ? fmt::format(" (p = {:.2g})", d.extended->p_value) : "",
            std::isfinite(d.extended->aicc - d.baseline.aicc)
                ? "; AICc changes by " + figure(d.extended->aicc - d.baseline.aicc)
                : "; AICc is not defined for so many parameters and so few readings"));
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
                                       counted(study.held_out_readings(), "reading", "readings"),
                                       figure(*after->held_out_rms), figure(*before.held_out_rms)));
        }
        std::vector<std::string> biased;
        for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
            const auto& was = before.parameters[k];
            const auto& is = after->parameters[k];
            if (was.value < is.low || was.value > is.high) {
                biased.push_back(
                    fmt::format("{} {} instead of {}", study.space.axes[k].name, figure(was.value), figure(is.value)));
            }
        }
        if (!biased.empty() && d.verdict != Verdict::unexplained && !d.leaves_more_than_noise) {
            text.push_back(fmt::format("Without the {} the fit was biased: {}.",
                                       d.is_located() ? "correction" : "effect", pave::join(biased)));
        }
    }

    const DiagnoseResult& result;
    const study::Study& study;
    const std::vector<study::Variant>& variants;
    const std::vector<diagnose::Candidate>& candidates;
    const Layout& layout;
    const diagnose::Diagnosis& d;
    const DiagnosedModel& before;
    const std::optional<DiagnosedModel>& after;
    const std::optional<MeshError>& mesh;
    const std::vector<OutputUncertainty>& outputs;
    const std::vector<SeparatingReading>& next;
    const std::vector<TellingReading>& telling;
};

} // namespace

std::vector<std::string> findings(const DiagnoseResult& result) {
    return Sentences(result).all();
}

} // namespace explore::analysis

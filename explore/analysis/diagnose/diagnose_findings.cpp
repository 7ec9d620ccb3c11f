#include "analysis/common/limit_words.h"
#include "analysis/common/say.h"
#include "analysis/diagnose/diagnose_verdict.h"

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
using pave::p_words;

std::string members_words(const std::vector<diagnose::Candidate>& candidates, const Members& members) {
    std::vector<std::string> words;
    words.reserve(members.size());
    for (const std::size_t c : members) {
        if (c < candidates.size()) {
            words.push_back(candidates[c].words());
        }
    }
    return words.empty() ? "the correction" : pave::join(words, " with ");
}

std::string percent(double share) {
    constexpr double shown = 5e-5; // what two decimals show
    if (share > 1.0 - shown && share < 1.0) {
        return "over 99.99 %";
    }
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
        std::vector<std::string> text = verdict_words(result);
        say(text, not_borne_out_words());
        say(text, bounds_words());
        wrong(text);
        if (after) {
            gain(text);
        }
        if (const auto doubtful = doubtful_noise(study)) {
            text.insert(text.begin() + 1, fmt::format("Before any model: {}.", doubtful->words));
        }
        for (const Rounding& rounding : result.roundings) {
            std::string words = rounding.words() + ".";
            words[0] = 'R';
            text.push_back(std::move(words));
        }
        say(text, minima_words());
        for (std::string& words : output_words(study, outputs)) {
            text.push_back(std::move(words));
        }
        if (result.is_otherwise_layered) {
            text.emplace_back(
                "fit and unique compute this linear section by layered theory, diagnose by finite elements, "
                "which most effects need: their values differ in the third digit.");
        }
        say(text, mesh_words(study, mesh));
        say(text, path_words(study, result.path));
        say(text, weights_words(study));
        say(text, noise_key_words(study));
        say(text, limit_words(study));
        say(text, next_words());
        return text;
    }

private:
    // Parameters of the study on a bound, in the model that the answer is about; all of them: the verdict says so.
    std::string bounds_words() const {
        const auto& unit = (result.is_extended() ? *d.extended : d.baseline).model.unit;
        const std::size_t axes = study.space.axes.size();
        std::vector<double> own(unit.begin(), unit.begin() + static_cast<std::ptrdiff_t>(std::min(axes, unit.size())));
        const auto met = landscape::bounds_met(own);
        return met.empty() || (met.size() == axes && axes > 1)
                   ? ""
                   : fmt::format("{}: the data ask for a value beyond the bound, or are not sensitive to it.",
                                 pave::join(landscape::bound_words(study.space, met)));
    }

    void wrong(std::vector<std::string>& text) const {
        if (study.noise == study::NoiseSource::stated) {
            text.push_back(
                fmt::format("The study's model leaves chi2 = {} with {}: {}.", figure(d.baseline.chi2),
                            counted(static_cast<std::size_t>(std::max(0, d.baseline.dof)), "degree of freedom",
                                    "degrees of freedom"),
                            d.baseline.p_value < diagnose::level_noise
                                ? fmt::format("noise as stated alone makes as much with probability {}",
                                              chance_words(d.baseline.p_value))
                                : fmt::format("the stated noise explains that ({})", p_words(d.baseline.p_value))));
        }
        if (d.verdict() == Verdict::adequate) {
            return;
        }
        for (std::size_t g = 0; g < layout.groups.size(); ++g) {
            const auto& test = d.groups[g];
            constexpr double clear = 0.02;
            if (test.p_sign < clear) {
                text.push_back(fmt::format("{}: the model lies {} nearly everywhere (sign test {}).",
                                           layout.groups[g].name, test.mean > 0.0 ? "too high" : "too low",
                                           p_words(test.p_sign)));
            }
            if (test.p_runs < clear) {
                text.push_back(fmt::format("{}: the residuals follow a pattern along the positions (runs test {}).",
                                           layout.groups[g].name, p_words(test.p_runs)));
            }
        }
        constexpr double strong = 4.0;
        if (!d.constancy.empty() && std::abs(d.constancy[0].score) > strong) {
            const auto& c = d.constancy[0];
            text.push_back(fmt::format("{} asks for a {} {} than the other readings ({:.1f} standard errors).",
                                       layout.groups[c.group].name, c.score > 0.0 ? "higher" : "lower",
                                       study.space.axes[c.axis].name, std::abs(c.score)));
        }
    }

    bool doubts_instruments(const diagnose::Explanation& explanation) const {
        const auto& members = explanation.fit.model.members;
        return std::all_of(members.begin(), members.end(),
                           [&](std::size_t c) { return candidates[c].is_of_readings && !candidates[c].reading; });
    }

    // The reading that would decide; "": none is proposed.
    std::string next_words() const {
        if (!next.empty() && next[0].explanations.empty()) {
            return fmt::format("What would settle it: {}.", next[0].words());
        }
        if (!next.empty()) {
            const SeparatingReading& best = next[0];
            if (constexpr double worth_it = 0.01; best.power - best.rate_now < worth_it) {
                const auto& compared = d.to_compare();
                return fmt::format(
                    "No further reading of the kinds that the study has tells the closest two apart: with "
                    "the best of them the right decision is made in {} of cases, as it is now.{}",
                    percent(best.rate_now),
                    doubts_instruments(compared[0]) && doubts_instruments(compared[1])
                        ? " A calibration of the instruments in question does."
                        : "");
            }
            return fmt::format(
                "Best next measurement: {} (to {} {}). With it the two most similar explanations would be "
                "told apart correctly in {} of cases ({} now).",
                best.words(), figure(best.reading.in_unit(best.reading.noise.absolute)), best.reading.unit.name,
                percent(best.power), percent(best.rate_now));
        }
        if (!telling.empty()) {
            const auto& [reading, bits] = telling.front();
            const char* const what = d.is_located() ? "where the model errs" : "how large it is";
            const double narrowed = 1.0 - std::exp2(-bits);
            if (constexpr double worth_it = 0.1; narrowed < worth_it) {
                return fmt::format("No further reading of the kinds that the study has says more of {}.", what);
            }
            return fmt::format("Best next measurement for {}: {} (noise {} {} assumed). The range would shrink by {}.",
                               what, reading.words(), figure(reading.in_unit(reading.noise.absolute)),
                               reading.unit.name, percent(narrowed));
        }
        return "";
    }

    // The minima of an adequate model; "": one.
    std::string minima_words() const {
        if (result.minima.empty()) {
            return "";
        }
        std::vector<std::string> points;
        std::vector<std::vector<double>> units{d.baseline.model.unit};
        units.insert(units.end(), result.minima.begin(), result.minima.end());
        for (const std::vector<double>& unit : units) {
            std::vector<std::string> values;
            for (std::size_t k = 0; k < unit.size(); ++k) {
                const problem::Axis& axis = study.space.axes[k];
                const bool is_on_bound = unit[k] < 1e-6 || unit[k] > 1.0 - 1e-6;
                values.push_back(fmt::format("{} = {}{}", axis.name, figure(axis.physical(unit[k])),
                                             is_on_bound ? " (its bound)" : ""));
            }
            points.push_back(pave::join(values, ", "));
        }
        return fmt::format("{} minima fit these data about as well: {}. Ranges of outputs are over all of them.",
                           units.size(), pave::join(points, "; "));
    }

    // Where readings that were left out speak against the extended model; "": they do not, or there is none.
    std::string not_borne_out_words() const {
        if (!result.is_extended() || !d.decision.model ||
            !d.ledger.is_predicted_worse(d.ledger.rows()[*d.decision.model].hypothesis.key())) {
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
            study.noise == study::NoiseSource::stated ? fmt::format(" ({})", p_words(d.extended->p_value)) : "",
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
        if (!biased.empty() && d.verdict() != Verdict::unexplained && !d.decision.leaves_more_than_noise) {
            text.push_back(fmt::format("Without the {} the fit was biased: {}.",
                                       d.is_located() ? "correction" : "effect", pave::join(biased)));
        }
    }

    const DiagnoseResult& result;
    const study::Study& study;
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

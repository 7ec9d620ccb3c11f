#include "analysis/common/say.h"
#include "analysis/design/design.h"
#include "base/text.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using pave::figure;

// "> 200" within a sentence.
std::string spoken(std::string words) {
    if (words.starts_with("> ")) {
        words.replace(0, 1, "more than");
    } else if (words.starts_with("< ")) {
        words.replace(0, 1, "less than");
    }
    return words;
}

std::string sentence_start(std::string words) {
    words = spoken(std::move(words));
    words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
    return words;
}

// The life that is left if the model may lack something; "": not known, or not much else than if it is right.
std::string wide_words(const CriterionLife& c) {
    if (!(c.strain.best > 0.0)) {
        return "";
    }
    const bool has_short = c.short_is_held && c.beyond(c.allowable.wide_low) >= 0;
    const bool has_long = c.long_is_held && c.beyond(c.allowable.wide_high) <= 0;
    if (!has_short && !has_long) {
        const std::string within =
            c.criterion.guide == nullptr
                ? ""
                : fmt::format(" within what {} is used for, {} to {} repetitions", c.criterion.law,
                              repetitions_figure(c.least()), repetitions_figure(c.most()));
        return fmt::format("If the model may lack something, these data do not bound the life{}.", within);
    }
    if (!c.long_is_held) {
        return fmt::format("If the model may lack something, {} years are left or more: these data set no upper end.",
                           years_words(c, c.allowable.wide_low));
    }
    if (!c.short_is_held) {
        return fmt::format("If the model may lack something, {} years are left or fewer: these data set no lower end.",
                           years_words(c, c.allowable.wide_high));
    }
    if (!(c.years.wide_high > 0.0 &&
          (c.allowable.wide_low < 0.8 * c.allowable.low || c.allowable.wide_high > 1.25 * c.allowable.high))) {
        return "";
    }
    return fmt::format("If the model may lack something, {} to {} years are left.",
                       spoken(years_words(c, c.allowable.wide_low)), spoken(years_words(c, c.allowable.wide_high)));
}

std::string step_words(const DesignResult& result, const NarrowingStep& step) {
    std::string words =
        fmt::format("{} leaves {:.0f} % of the range of the life, as a logarithm", step.words(), 100.0 * step.left);
    const double saved = result.overlay->cost().value_or(0.0) * (1.0 - step.left);
    return words + (saved >= 1.0 ? fmt::format(", and about {:.0f} mm less to build", saved) : "");
}

// Nothing: hardly anything is open, or nothing tells of it.
std::vector<std::string> next_words(const DesignResult& result) {
    constexpr double wide = 2.0;
    constexpr double dear = 5.0; // mm
    constexpr double worth = 0.9;
    const CriterionLife& first = result.governing();
    std::vector<std::string> words;
    const bool is_open =
        first.allowable.high > wide * first.allowable.low || result.overlay->cost().value_or(0.0) >= dear;
    if (!result.no_range.empty() || result.next.empty() || result.next[0].left > worth || !is_open) {
        return words;
    }
    words.push_back(fmt::format("What would decide: {}.", step_words(result, result.next[0])));
    const auto at_hand =
        std::find_if(result.next.begin(), result.next.end(), [](const auto& step) { return step.is_at_hand; });
    if (at_hand != result.next.begin() && at_hand != result.next.end() && at_hand->left <= worth) {
        words.push_back(fmt::format("Of what can be had already: {}.", step_words(result, *at_hand)));
    }
    return words;
}

std::string overlay_words(const DesignResult& result) {
    const Overlay& overlay = *result.overlay;
    const std::string top = result.study.model.layers[0].name;
    const bool sure = result.no_range.empty();
    const std::string reliability =
        sure ? fmt::format(" with {:g} % reliability", result.options.reliability_percent) : "";
    if (!overlay.reliable) {
        return fmt::format(
            "No overlay up to {:g} mm on {} lasts the design traffic{}{}.", overlay.most, top, reliability,
            overlay.best ? fmt::format("; at the best set {} do", fmt::format("{:.0f} mm", *overlay.best)) : "");
    }
    if (*overlay.reliable <= 0.0) {
        return fmt::format("No overlay is needed for the design traffic{}{}.", reliability,
                           *overlay.reliable <= -1.0
                               ? fmt::format("; {:.0f} mm of {} may be milled off", -*overlay.reliable, top)
                               : "");
    }
    std::string words =
        fmt::format("An overlay of {:.0f} mm lasts the design traffic{}", std::ceil(*overlay.reliable), reliability);
    if (sure && overlay.best) {
        words += fmt::format("; {:.0f} mm at the best set, so what the data leave open costs {:.0f} mm",
                             std::max(0.0, std::ceil(*overlay.best)),
                             std::ceil(*overlay.reliable) - std::max(0.0, std::ceil(*overlay.best)));
    }
    return words + ".";
}

} // namespace

std::vector<std::string> findings(const DesignResult& result) {
    const CriterionLife& first = result.governing();
    std::vector<std::string> words;
    if (result.no_range.empty()) {
        words.push_back(fmt::format(
            "{} years are left, {} to {} over what the data accept (95 %): \"{}\" ends first{}.",
            sentence_start(years_words(first, first.allowable.best)), spoken(years_words(first, first.allowable.low)),
            spoken(years_words(first, first.allowable.high)), first.criterion.name,
            result.criteria.size() > 1 ? fmt::format(" (probability {:.0f} %)", 100.0 * first.governs) : ""));
    } else {
        words.push_back(fmt::format("{} years are left at the best set: \"{}\" ends first. No range is known: {}.",
                                    sentence_start(years_words(first, first.allowable.best)), first.criterion.name,
                                    result.no_range));
    }
    words.push_back(overlay_words(result));
    say(words, wide_words(first));
    for (const CriterionLife& c : result.criteria) {
        if (c.strain.best <= 1.0) {
            words.push_back(fmt::format("\"{}\": nothing strains its place in that sense.", c.criterion.name));
        } else if (c.extrapolated()) {
            words.push_back(fmt::format("\"{}\": {} are beyond what {} is used for, {} to {} repetitions: "
                                        "extrapolated.",
                                        c.criterion.name,
                                        std::isfinite(c.strain.best)
                                            ? fmt::format("{} microstrain", figure(c.strain.best))
                                            : fmt::format("{:.2g} repetitions", c.allowable.best),
                                        c.criterion.law, repetitions_figure(c.least()), repetitions_figure(c.most())));
        }
    }
    for (std::string& step : next_words(result)) {
        words.push_back(std::move(step));
    }
    return words;
}

} // namespace explore::analysis

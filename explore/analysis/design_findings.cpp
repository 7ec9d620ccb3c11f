#include "analysis/design.h"
#include "base/text.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using pave::figure;

constexpr double long_time = 200.0; // years: more is as good as for ever

std::string years_words(double years) {
    return years > long_time ? "more than 200" : figure(years, 2);
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
        fmt::format("{:.0f} mm more of {} last the design traffic{}", std::ceil(*overlay.reliable), top, reliability);
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
            years_words(first.years.best), years_words(first.years.low), years_words(first.years.high),
            first.criterion.name,
            result.criteria.size() > 1 ? fmt::format(" (probability {:.0f} %)", 100.0 * first.governs) : ""));
    } else {
        words.push_back(fmt::format("{} years are left at the best set: \"{}\" ends first. No range is known: {}.",
                                    years_words(first.years.best), first.criterion.name, result.no_range));
    }
    words.push_back(overlay_words(result));
    if (first.years.wide_high > 0.0 &&
        (first.years.wide_low < 0.8 * first.years.low || first.years.wide_high > 1.25 * first.years.high)) {
        words.push_back(fmt::format("If the model may lack something, {} to {} years are left.",
                                    years_words(first.years.wide_low), years_words(first.years.wide_high)));
    }
    for (const CriterionLife& c : result.criteria) {
        if (c.strain.best <= 1.0) {
            words.push_back(fmt::format("\"{}\": nothing strains its place in that sense.", c.criterion.name));
        } else if (c.extrapolated) {
            words.push_back(fmt::format("\"{}\": {} are beyond what {} is used for, {} to {} repetitions: "
                                        "extrapolated.",
                                        c.criterion.name,
                                        std::isfinite(c.strain.best)
                                            ? fmt::format("{} microstrain", figure(c.strain.best))
                                            : fmt::format("{:.2g} repetitions", c.allowable.best),
                                        c.criterion.law, fmt::format("{:.0g}", c.criterion.guide->least),
                                        fmt::format("{:.0g}", c.criterion.guide->most)));
        }
    }
    if (result.no_range.empty() && first.allowable.high > 4.0 * first.allowable.low) {
        words.push_back(
            fmt::format("Next: another reading narrows this; pavescape unique {} says which.", result.study.file));
    }
    return words;
}

} // namespace explore::analysis

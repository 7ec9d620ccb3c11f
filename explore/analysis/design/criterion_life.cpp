#include "analysis/design/criterion_life.h"

#include "base/text.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

constexpr double long_time = 200.0; // years: more is as good as for ever

LifeRange mapped(const LifeRange& range, const auto& function) {
    return {function(range.best), function(range.low), function(range.high), function(range.wide_low),
            function(range.wide_high)};
}

} // namespace

void CriterionLife::set_remaining() {
    const auto none_below = [](double value) { return std::isnan(value) ? value : std::max(0.0, value); };
    remaining = mapped(allowable, [&](double n) { return none_below(n - criterion.passed); });
    years = mapped(remaining, [&](double n) { return criterion.years_of(n); });
}

const CriterionLife& ends_first(const std::vector<CriterionLife>& lives) {
    return *std::min_element(lives.begin(), lives.end(), [](const auto& a, const auto& b) {
        return a.criterion.years_of(a.allowable.best - a.criterion.passed) <
               b.criterion.years_of(b.allowable.best - b.criterion.passed);
    });
}

std::optional<double> Overlay::cost() const {
    if (!best || !reliable) {
        return std::nullopt;
    }
    return std::max(0.0, *reliable) - std::max(0.0, *best);
}

std::string repetitions_figure(double value) { // 2.6e7, not 2.6e+07
    std::string text = fmt::format("{:.2g}", value);
    if (const auto at = text.find("e+"); at != std::string::npos) {
        text.erase(at + 1, text[at + 2] == '0' ? 2 : 1);
    }
    return text;
}

std::string repetitions_words(const CriterionLife& c, double allowable) {
    constexpr double endless = 1e12;
    if (std::isnan(allowable)) {
        return "-";
    }
    const double most = std::min(c.most(), endless);
    return allowable > most          ? "> " + repetitions_figure(most)
           : c.beyond(allowable) < 0 ? "< " + repetitions_figure(c.least())
                                     : repetitions_figure(allowable);
}

std::string years_words(const CriterionLife& c, double allowable) {
    if (std::isnan(allowable)) {
        return "-";
    }
    const double left = std::clamp(allowable, c.least(), c.most()) - c.criterion.passed;
    const double years = c.criterion.years_of(std::max(0.0, left));
    const bool is_less = c.beyond(allowable) < 0 && years > 0.0;
    const bool is_more = c.beyond(allowable) > 0 || (!is_less && years > long_time);
    return (is_less ? "< " : is_more ? "> " : "") + pave::figure(is_more ? std::min(years, long_time) : years, 2);
}

} // namespace explore::analysis

#include "analysis/survey/weak_stations.h"

#include "base/error.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

double median(std::vector<double> values) {
    return percentiles_of(std::move(values)).p50;
}

// How many robust standard deviations a value lies above the median.
struct Scatter {
    double middle = 0.0, deviation = 0.0;
    explicit Scatter(const std::vector<double>& logarithms) : middle{median(logarithms)} {
        constexpr double of_normal = 1.4826;
        std::vector<double> away;
        std::transform(logarithms.begin(), logarithms.end(), std::back_inserter(away),
                       [this](double v) { return std::abs(v - middle); });
        deviation = std::max(weak_scatter, of_normal * median(away));
    }
    double above(double logarithm) const { return (logarithm - middle) / deviation; }
};

// The parameter that best explains why station `own` is weak.
void add_parameter(const SurveyResult& result, const std::vector<std::size_t>& group, WeakStation& own) {
    double lowest = -weak_deviations;
    for (std::size_t k = 0; k < result.parameter_names().size(); ++k) {
        const auto value = [&](std::size_t i) {
            const StationResult& s = result.stations[i];
            const bool is_known = s.is_fitted() && s.fit->parameters[k].determined && s.fit->parameters[k].value > 0.0;
            return is_known ? std::optional(std::log(s.fit->parameters[k].value)) : std::nullopt;
        };
        std::vector<double> values;
        for (const std::size_t i : group) {
            if (const auto known = value(i)) {
                values.push_back(*known);
            }
        }
        const auto here = value(own.station);
        if (!here || values.size() < section_stations) {
            continue;
        }
        const Scatter scatter(values);
        if (scatter.above(*here) < lowest) {
            lowest = scatter.above(*here);
            own.parameter = k;
            own.parameter_ratio = std::exp(*here - scatter.middle);
        }
    }
}

} // namespace

std::optional<std::vector<WeakStation>> weak_stations(const SurveyResult& result) {
    std::vector<std::vector<std::size_t>> groups;
    const auto add = [&](std::size_t begin, std::size_t end) {
        groups.emplace_back();
        for (std::size_t i = begin; i < end; ++i) {
            if (result.stations[i].has_bowl()) {
                groups.back().push_back(i);
            }
        }
    };
    for (const RoadSection& section : result.sections) {
        add(section.first, section.last + 1);
    }
    for (std::size_t begin = 0; result.sections.empty() && begin < result.stations.size();
         begin = result.end_of_lane(begin)) {
        add(begin, result.end_of_lane(begin));
    }
    std::erase_if(groups, [](const auto& group) { return group.size() < section_stations; });
    if (groups.empty()) {
        return std::nullopt;
    }
    std::vector<WeakStation> weak;
    for (const auto& group : groups) {
        std::vector<double> d0;
        std::transform(group.begin(), group.end(), std::back_inserter(d0),
                       [&](std::size_t i) { return std::log(result.d0_at_common(result.stations[i])); });
        const Scatter scatter(d0);
        for (std::size_t i = 0; i < group.size(); ++i) {
            if (scatter.above(d0[i]) > weak_deviations) {
                weak.push_back({.station = group[i], .d0_ratio = std::exp(d0[i] - scatter.middle), .parameter = {}});
                add_parameter(result, group, weak.back());
            }
        }
    }
    std::stable_sort(weak.begin(), weak.end(),
                     [](const WeakStation& a, const WeakStation& b) { return a.d0_ratio > b.d0_ratio; });
    return weak;
}

std::string weak_words(const SurveyResult& result) {
    const auto weak = weak_stations(result).value_or(std::vector<WeakStation>());
    constexpr std::size_t named = 3;
    std::vector<std::string> words;
    for (std::size_t i = 0; i < std::min(named, weak.size()); ++i) {
        const WeakStation& w = weak[i];
        const data::FwdStation& place = result.stations[w.station].station;
        words.push_back(fmt::format(
            "{}{} (D0 {:.0f} % above the median{})", place.name,
            place.chainage_m ? fmt::format(" at {:g} m", *place.chainage_m) : "", 100.0 * (w.d0_ratio - 1.0),
            w.parameter ? fmt::format(", {} {:.0f} % below it", result.parameter_names()[*w.parameter],
                                      100.0 * (1.0 - w.parameter_ratio))
                        : ""));
    }
    if (words.empty()) {
        return "";
    }
    return fmt::format("Weak {}: {}{}.", weak.size() == 1 ? "station" : "stations", pave::join(words),
                       weak.size() > named ? fmt::format(" and {} more", weak.size() - named) : "");
}

} // namespace explore::analysis

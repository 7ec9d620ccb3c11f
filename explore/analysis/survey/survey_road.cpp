#include "analysis/survey/survey_road.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>
#include <numeric>

namespace explore::analysis {
namespace {

constexpr double significant = 0.01;

// Two-sided p of Welch's t of two samples; 1 where both do not vary.
double p_of_means(const std::vector<double>& values, std::size_t begin, std::size_t middle, std::size_t end) {
    const auto moments = [&](std::size_t from, std::size_t to) {
        const auto n = static_cast<double>(to - from);
        double mean = 0.0;
        double squares = 0.0;
        for (std::size_t i = from; i < to; ++i) {
            mean += values[i] / n;
        }
        for (std::size_t i = from; i < to; ++i) {
            squares += std::pow(values[i] - mean, 2);
        }
        return std::tuple(n, mean, squares / (n - 1.0) / n); // the last: variance of the mean
    };
    const auto [n1, mean1, v1] = moments(begin, middle);
    const auto [n2, mean2, v2] = moments(middle, end);
    const double v = v1 + v2;
    // Values (logarithms) that are the same but for rounding vary by nothing that a mean could be held against.
    constexpr double same = 1e-9;
    if (v <= same * same) {
        return std::abs(mean1 - mean2) <= same ? 1.0 : 0.0;
    }
    const double degrees = v * v / (v1 * v1 / (n1 - 1.0) + v2 * v2 / (n2 - 1.0));
    return 2.0 * gsl_cdf_tdist_Q(std::abs(mean1 - mean2) / std::sqrt(v), degrees);
}

// Appends the ends of the homogeneous parts of [begin, end).
void part(const std::vector<double>& values, std::size_t begin, std::size_t end, std::vector<std::size_t>& ends) {
    const double mean = std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(begin),
                                        values.begin() + static_cast<std::ptrdiff_t>(end), 0.0) /
                        static_cast<double>(end - begin);
    double cumulative = 0.0;
    double farthest = -1.0;
    std::size_t middle = 0;
    for (std::size_t i = begin; i < end; ++i) {
        cumulative += values[i] - mean;
        if (i + 1 >= begin + section_stations && i + 1 + section_stations <= end && std::abs(cumulative) > farthest) {
            farthest = std::abs(cumulative);
            middle = i + 1;
        }
    }
    if (farthest >= 0.0 && p_of_means(values, begin, middle, end) < significant) {
        part(values, begin, middle, ends);
        part(values, middle, end, ends);
    } else {
        ends.push_back(end);
    }
}

RoadSection section_of(const SurveyResult& result, const std::vector<std::size_t>& stations) {
    RoadSection section;
    section.profile = result.stations[stations[0]].station.profile;
    section.lane = result.stations[stations[0]].station.lane;
    section.first = stations.front();
    section.last = stations.back();
    std::vector<double> d0;
    std::vector<std::vector<double>> parameters(result.parameter_names().size());
    for (const std::size_t i : stations) {
        const StationResult& s = result.stations[i];
        d0.push_back(s.indices->d0_um);
        section.fitted += s.is_fitted() ? 1 : 0;
        for (std::size_t k = 0; s.is_fitted() && k < parameters.size(); ++k) {
            if (s.fit->parameters[k].determined) {
                parameters[k].push_back(s.fit->parameters[k].value);
            }
        }
    }
    section.d0_um = percentiles_of(std::move(d0));
    for (auto& values : parameters) {
        section.parameters.push_back(percentiles_of(std::move(values)));
    }
    return section;
}

} // namespace

// Linear between the order statistics.
Percentiles percentiles_of(std::vector<double> values) {
    Percentiles found{.stations = values.size()};
    if (values.empty()) {
        return found;
    }
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double place = share * static_cast<double>(values.size() - 1);
        const auto below = static_cast<std::size_t>(place);
        const std::size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
    };
    found.p15 = at(0.15);
    found.p50 = at(0.5);
    found.p85 = at(0.85);
    return found;
}

std::vector<RoadSection> road_sections(const SurveyResult& result) {
    std::vector<RoadSection> sections;
    for (std::size_t i = 0; i < result.stations.size();) {
        std::vector<std::size_t> stations;
        std::vector<double> d0;
        for (const std::size_t lane_end = result.end_of_lane(i); i < lane_end; ++i) {
            if (result.stations[i].has_bowl() && result.stations[i].station.chainage_m) {
                stations.push_back(i);
                d0.push_back(std::log(result.stations[i].indices->d0_um));
            }
        }
        if (stations.empty()) {
            continue;
        }
        std::vector<std::size_t> ends;
        part(d0, 0, d0.size(), ends);
        std::size_t begin = 0;
        for (const std::size_t end : ends) {
            sections.push_back(section_of(result, {stations.begin() + static_cast<std::ptrdiff_t>(begin),
                                                   stations.begin() + static_cast<std::ptrdiff_t>(end)}));
            begin = end;
        }
    }
    return sections;
}

std::optional<SurveyResult::Floor> floor_of(const SurveyResult& result, const std::vector<StationTask>& tasks) {
    std::vector<const StationTask*> fitted;
    for (const StationTask& task : tasks) {
        if (task.station->is_fitted()) {
            fitted.push_back(&task);
        }
    }
    if (fitted.empty()) {
        return std::nullopt;
    }
    const auto middle = fitted.begin() + static_cast<std::ptrdiff_t>(fitted.size() / 2);
    std::nth_element(fitted.begin(), middle, fitted.end(), [&](const StationTask* a, const StationTask* b) {
        return result.d0_at_common(*a->station) < result.d0_at_common(*b->station);
    });
    const StationTask& task = **middle;
    auto without = fit_without_floor(task.study, task.station->fit->best.unit);
    if (!without) {
        return std::nullopt;
    }
    return SurveyResult::Floor{static_cast<std::size_t>(task.station - result.stations.data()), std::move(*without)};
}

} // namespace explore::analysis

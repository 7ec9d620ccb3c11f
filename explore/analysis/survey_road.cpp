#include "analysis/survey_road.h"

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
        for (std::size_t k = 0; s.is_fitted() && k < parameters.size(); ++k) {
            parameters[k].push_back(s.fit->parameters[k].value);
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

std::optional<SuspectSensor> suspect_sensor(const SurveyResult& result) {
    constexpr std::size_t needed = 8;
    constexpr double worth_saying = 0.03;
    struct Seen {
        std::vector<double> excess;   // over the neighbours
        std::vector<double> residual; // ln(model / measured)
        std::vector<double> place_mm; // where the model has that deflection
    };
    std::map<double, Seen> seen; // by offset
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        const std::size_t last = s.fit->levels.size() - 1;
        const auto& readings = s.bowls->levels[s.fit->levels[last]].readings;
        const auto& model = s.fit->model_um[last];
        if (std::any_of(model.begin(), model.end(), [](double um) { return !(um > 0.0); })) {
            continue;
        }
        const auto residual = [&](std::size_t i) { return std::log(model[i] / readings[i].deflection_um); };
        for (std::size_t i = 1; i + 1 < readings.size(); ++i) {
            const double width = readings[i + 1].offset_mm - readings[i - 1].offset_mm;
            const double t = (readings[i].offset_mm - readings[i - 1].offset_mm) / width;
            const double slope = std::log(model[i + 1] / model[i - 1]) / width; // of ln(model), per mm
            Seen& at = seen[readings[i].offset_mm];
            at.excess.push_back(residual(i) - (1.0 - t) * residual(i - 1) - t * residual(i + 1));
            at.residual.push_back(residual(i));
            if (slope < 0.0) {
                at.place_mm.push_back(readings[i].offset_mm - residual(i) / slope);
            }
        }
    }
    std::optional<SuspectSensor> worst;
    double worst_excess = worth_saying;
    for (const auto& [offset, at] : seen) {
        const std::size_t n = at.excess.size();
        const double middle = data::median(at.excess);
        if (n < needed || std::abs(middle) <= worst_excess) {
            continue;
        }
        const auto same = static_cast<std::size_t>(
            std::count_if(at.excess.begin(), at.excess.end(), [&](double e) { return (e > 0.0) == (middle > 0.0); }));
        const double tail = gsl_cdf_binomial_Q(static_cast<unsigned>(same - 1), 0.5, static_cast<unsigned>(n));
        const double p = std::min(1.0, 2.0 * tail * static_cast<double>(seen.size()));
        if (p >= significant) {
            continue;
        }
        worst_excess = std::abs(middle);
        worst = SuspectSensor{.offset_mm = offset, .stations = n, .same_sign = same, .p = p, .fits_at_mm = {}};
        worst->model_percent = 100.0 * (std::exp(data::median(at.residual)) - 1.0);
        worst->fits_at_mm = at.place_mm.empty() ? std::nullopt : std::optional(data::median(at.place_mm));
    }
    return worst;
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

#include "analysis/survey.h"

#include "analysis/survey_road.h"
#include "analysis/survey_stations.h"
#include "data/csv.h"
#include "data/fwd_values.h"
#include "landscape/batch.h"
#include "run/progress.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <mutex>

namespace explore::analysis {
namespace {

constexpr int searches = 4; // at each station: one bowl tells few parameters, and a road has many stations

StationFit fit_of(const StationTask& task, const landscape::Minimum& best) {
    StationFit fit = fit_at(task, best);
    fit.local = landscape::analyse(best, task.problem);
    // Noise that was stated and is not contradicted is known; otherwise it is estimated from what the fit leaves over.
    const landscape::LocalAnalysis& local = fit.local;
    const bool noise_is_known = local.noise_is_stated && !local.widened;
    const double quantile = noise_is_known || local.degrees_of_freedom < 1
                                ? 1.96
                                : gsl_cdf_tdist_Pinv(0.975, static_cast<double>(local.degrees_of_freedom));
    const auto& axes = task.problem.space.axes;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        fit.parameters.push_back(range_about(axes[k], best.unit[k], quantile * local.standard_error[k]));
        fit.parameters[k].value = best.evaluation.parameters[k];
    }
    return fit;
}

// Back-calculates every station that is not rejected. False: interrupted; what was computed is in the store.
bool fit_stations(Session& session, SurveyResult& result) {
    landscape::MultistartSettings settings;
    settings.starts = searches;
    const auto tasks = station_tasks(result, static_cast<std::size_t>(result.study->space.dimension()),
                                     [](const study::Study& study) { return study::make_problem(study); });
    if (tasks.empty()) {
        return true;
    }
    const auto begin = std::chrono::steady_clock::now();
    std::vector<landscape::BatchItem> items;
    std::vector<std::string> why_none; // should a station end without a result
    Exploration exploration(result, search::sobol(result.study->space, survey_explored_points, session.options().seed),
                            session, "survey");
    for (const StationTask& task : tasks) {
        auto starts = exploration.starts(task, settings);
        if (!starts) {
            return false;
        }
        why_none.push_back(starts->why_none.empty() ? "no start has an answer under the load of this station"
                                                    : std::move(starts->why_none));
        const int run = session.begin(task.study, "survey",
                                      fmt::format("{}; {} at {} kPa; {} starts, distance {}; {}", task.words(),
                                                  exploration.design().name, result.common_pressure_kPa,
                                                  settings.starts, settings.start_distance, settings.method));
        items.push_back({.problem = task.problem, .run = run, .starts = std::move(starts->points)});
    }

    run::Progress progress("survey", session.options().show_progress ? static_cast<std::int64_t>(items.size()) : -1,
                           {"stations/min", 60.0});
    std::mutex mutex;
    std::size_t finished = 0;
    const auto keep = [&](std::size_t i, const std::vector<run::Endpoint>& ends, const run::Tally& tally) {
        progress.add(1, tally.computed > 0);
        const auto minima = landscape::distinct_minima(ends, items[i].problem);
        const std::scoped_lock lock(mutex);
        ++finished;
        result.computed += tally.computed;
        result.stations_computed += tally.computed > 0 ? 1 : 0;
        StationResult& s = *tasks[i].station;
        if (minima.empty()) {
            s.state = StationState::failed;
            s.reason = why_none[i];
            return;
        }
        s.fit = fit_of(tasks[i], minima[0]);
        s.fit->minima = minima.size();
        s.fit->starts = ends.size();
        s.no_fit = no_fit_of(*s.fit);
        s.state = s.no_fit ? StationState::no_fit : s.state;
    };
    landscape::search_batch(items, session.store(), *optimise::find_method(settings.method), settings.search,
                            session.options().threads, keep);
    result.computed += exploration.tally().computed;
    result.floor = floor_of(result, tasks);
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return finished == items.size();
}

} // namespace

double LoadLevel::pressure_on(double radius_mm) const {
    return pressure_kPa ? *pressure_kPa : data::plate_pressure_kPa(*force_kN, radius_mm);
}

std::optional<LoadLevel> load_level_of(const std::string& text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string unit =
        data::lower_case(data::trimmed({end, static_cast<std::size_t>(text.data() + text.size() - end)}));
    if (error != std::errc() || !(value > 0.0 && value < 1e6) || (unit != "kn" && unit != "kpa")) {
        return std::nullopt;
    }
    LoadLevel level;
    (unit == "kn" ? level.force_kN : level.pressure_kPa) = value;
    return level;
}

std::optional<bool> StationResult::passes() const {
    const auto found = ratio();
    return found ? std::optional(*found >= data::deflection_ratio_limit) : std::nullopt;
}

std::vector<std::size_t> StationResult::used_levels() const {
    return fit ? fit->levels : bowls ? std::vector{bowls->main} : std::vector<std::size_t>{};
}

std::size_t SurveyResult::count(const std::function<bool(const StationResult&)>& is) const {
    return static_cast<std::size_t>(std::count_if(stations.begin(), stations.end(), is));
}

SurveyCounts SurveyResult::counts() const {
    SurveyCounts counts;
    for (const StationResult& s : stations) {
        const auto passes = s.passes();
        counts.pass += passes && *passes ? 1 : 0;
        counts.fail += passes && !*passes ? 1 : 0;
        counts.rejected += s.state == StationState::rejected ? 1 : 0;
        counts.fitted += s.is_fitted() ? 1 : 0;
        counts.no_fit += s.state == StationState::no_fit ? 1 : 0;
        counts.failed += s.state == StationState::failed ? 1 : 0;
    }
    return counts;
}

std::size_t SurveyResult::end_of_lane(std::size_t begin) const {
    const data::FwdStation& first = stations[begin].station;
    std::size_t end = begin + 1;
    while (end < stations.size() && stations[end].station.profile == first.profile &&
           stations[end].station.lane == first.lane) {
        ++end;
    }
    return end;
}

std::vector<std::string> SurveyResult::parameter_names() const {
    std::vector<std::string> names;
    if (study) {
        for (const auto& axis : study->space.axes) {
            names.push_back(axis.name);
        }
    }
    return names;
}

std::optional<SurveyResult> survey(Session& session, std::vector<data::FwdFile> files,
                                   std::optional<study::Study> survey_study, const SurveyOptions& options) {
    SurveyResult result = begin_survey(std::move(files), std::move(survey_study), options);
    if (result.study && !fit_stations(session, result)) {
        return std::nullopt;
    }
    finish_survey(result);
    return result;
}

} // namespace explore::analysis

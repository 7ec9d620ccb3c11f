#include "analysis/survey/survey.h"

#include "analysis/survey/survey_lives.h"
#include "analysis/survey/survey_network.h"
#include "analysis/survey/survey_noise.h"
#include "analysis/survey/survey_outputs.h"
#include "analysis/survey/survey_road.h"
#include "analysis/survey/survey_stations.h"
#include "data/csv.h"
#include "data/fwd_values.h"
#include "landscape/batch.h"
#include "landscape/held_ranges.h"
#include "landscape/prediction_error.h"
#include "run/progress.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <fmt/format.h>
#include <mutex>

namespace explore::analysis {
namespace {

constexpr int searches = 4; // at each station: one bowl tells few parameters, and a road has many stations
// Of chi2 / 2, that a step may still gain: moves no parameter by more than a seventh of its standard error.
constexpr double enough = 1e-2;

// With its ranges by noise that is so many times larger than it is taken, or more where this station's own misfit says
// so.
void set_ranges(const StationTask& task, double noise_factor, StationFit& fit) {
    const landscape::Minimum& best = fit.best;
    fit.local = landscape::analyse(best, task.problem, noise_factor);
    const landscape::LocalAnalysis& local = fit.local;
    fit.quantile = local.quantile();
    const landscape::HeldRanges held = landscape::held_ranges(task.problem, best, local);
    fit.held_by = held.limits;
    fit.parameters.clear();
    const auto& axes = task.problem.space.axes;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        fit.parameters.push_back(held.of(k)
                                     ? range_between(axes[k], held.of(k)->low, held.of(k)->high)
                                     : range_about(axes[k], best.unit[k], fit.quantile * local.standard_error[k]));
        fit.parameters[k].value = best.evaluation.parameters[k];
    }
}

// All searches of a road.
class StationFits {
public:
    StationFits(Session& session, SurveyResult& result, const std::vector<StationTask>& tasks)
        : session_(session),
          result_(result),
          tasks_(tasks),
          networks_(session, result) {
        settings_.starts = searches;
    }

    bool run() {
        const auto begin = std::chrono::steady_clock::now();
        if (!networks_.build(tasks_) || !explore() || !networks_.search(searches_, settings_) || !fit() ||
            !predict_outputs(session_, result_, tasks_) || !predict_station_lives()) {
            return false;
        }
        result_.floor = floor_of(result_, tasks_);
        result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        return true;
    }

private:
    bool explore() {
        Exploration exploration(result_,
                                search::sobol(result_.study->space, survey_explored_points, session_.options().seed),
                                session_, "survey", &networks_);
        for (const StationTask& task : tasks_) {
            auto starts = exploration.starts(task, settings_);
            if (!starts) {
                return false;
            }
            why_none_.push_back(starts->why_none.empty() ? "no start has an answer under the load of this station"
                                                         : std::move(starts->why_none));
            searches_.push_back({.task = &task,
                                 .settings = fmt::format("{}; {} at {} kPa; {} starts, distance {}; {}", task.words(),
                                                         exploration.design().name, result_.common_pressure_kPa,
                                                         settings_.starts, settings_.start_distance, settings_.method),
                                 .starts = std::move(starts->points)});
        }
        result_.computed += exploration.tally().computed;
        return true;
    }

    bool fit() {
        std::vector<std::size_t> near;
        std::vector<std::size_t> far;
        for (std::size_t i = 0; i < searches_.size(); ++i) {
            (searches_[i].by_network() ? near : far).push_back(i);
        }
        auto from_near = settings_.search;
        from_near.first_step = optimise::whole_cube;
        if (result_.study->data.misfit == problem::MisfitKind::weighted) {
            from_near.enough = enough;
        } else if (!near.empty()) { // the noise is that of the residuals
            const problem::Problem& problem = tasks_[near[0]].problem;
            const int free = problem.degrees_of_freedom(problem.space.axes.size());
            from_near.misfit_tolerance = 2.0 * enough / std::max(1, free);
        }
        if (!fit(near, from_near) || !fit(far, settings_.search)) {
            return false;
        }
        result_.noise_factor = noise_factor(result_);
        for (const StationTask& task : tasks_) {
            if (result_.noise_factor > 1.0 && task.station->fit) {
                set_ranges(task, result_.noise_factor, *task.station->fit);
            }
        }
        return true;
    }

    bool fit(const std::vector<std::size_t>& numbers, const optimise::SearchSettings& how) {
        std::vector<landscape::BatchItem> items;
        items.reserve(numbers.size());
        for (const std::size_t i : numbers) {
            const StationSearch& search = searches_[i];
            const int run = session_.begin(search.task->study, "survey", search.settings);
            items.push_back({.problem = search.task->problem, .run = run, .starts = search.starts});
        }
        if (items.empty()) {
            return true;
        }
        run::Progress progress("survey",
                               session_.options().show_progress ? static_cast<std::int64_t>(items.size()) : -1,
                               {"stations/min", 60.0});
        std::mutex mutex;
        std::size_t finished = 0;
        const auto keep = [&](std::size_t item, const std::vector<run::Endpoint>& ends, const run::Tally& tally) {
            progress.add(1, tally.computed > 0);
            const std::size_t i = numbers[item];
            const auto minima = landscape::distinct_minima(ends, tasks_[i].problem);
            const std::scoped_lock lock(mutex);
            ++finished;
            result_.computed += tally.computed;
            result_.stations_computed += tally.computed > 0 ? 1 : 0;
            StationResult& s = *tasks_[i].station;
            if (minima.empty()) {
                s.state = StationState::failed;
                s.reason = why_none_[i];
                return;
            }
            s.fit = fit_at(tasks_[i], minima[0]);
            set_ranges(tasks_[i], 1.0, *s.fit);
            s.fit->minima = minima.size();
            s.fit->starts = ends.size();
            if (const StationSearch& search = searches_[i]; search.by_network()) {
                s.fit->best.members = search.members;
                s.fit->minima = search.minima;
                s.fit->starts = search.searched;
            }
            judge_fit(s);
        };
        landscape::search_batch(items, session_.store(), *optimise::find_method(settings_.method), how,
                                session_.options().threads, keep);
        return finished == items.size();
    }

    bool predict_station_lives() {
        std::vector<StationToLast> stations;
        for (const StationTask& task : tasks_) {
            if (task.station->is_fitted()) {
                stations.push_back({task.station, task.words(), [&task](const Eigen::VectorXd& gradient) {
                                        const StationFit& fit = *task.station->fit;
                                        return landscape::prediction_error(gradient, fit.best, task.problem, fit.local);
                                    }});
            }
        }
        return predict_lives(session_, result_, stations);
    }

    Session& session_;
    SurveyResult& result_;
    const std::vector<StationTask>& tasks_;
    Networks networks_;
    landscape::MultistartSettings settings_;
    std::vector<StationSearch> searches_; // of each task
    std::vector<std::string> why_none_;   // should a station end without a result
};

// Back-calculates every station that is not rejected. False: interrupted; what was computed is in the store.
bool fit_stations(Session& session, SurveyResult& result) {
    const auto tasks = station_tasks(result, static_cast<std::size_t>(result.study->space.dimension()),
                                     [](const study::Study& study) { return study::make_problem(study); });
    return tasks.empty() || StationFits(session, result, tasks).run();
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
        counts.no_ratio += s.has_bowl() && !passes ? 1 : 0;
        counts.rejected += s.state == StationState::rejected ? 1 : 0;
        counts.fitted += s.is_fitted() ? 1 : 0;
        counts.doubtful += s.state == StationState::doubtful ? 1 : 0;
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

std::vector<data::Reading> SurveyResult::outputs() const {
    std::vector<data::Reading> found;
    if (study) {
        for (const std::size_t i : study->outputs()) {
            found.push_back(study->readings[i]);
        }
    }
    return found;
}

bool SurveyResult::has_lives() const {
    return count([](const StationResult& s) { return s.is_fitted() && s.fit->lives; }) > 0;
}

std::optional<SurveyResult> survey(Session& session, std::vector<data::FwdFile> files,
                                   std::optional<study::Study> survey_study, const SurveyOptions& options) {
    if (survey_study) {
        check_criteria(*survey_study);
    }
    SurveyResult result = begin_survey(std::move(files), std::move(survey_study), options);
    if (result.study && !fit_stations(session, result)) {
        return std::nullopt;
    }
    finish_survey(result);
    return result;
}

} // namespace explore::analysis

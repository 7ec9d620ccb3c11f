#include "analysis/road/road.h"

#include "analysis/road/road_diagnosis.h"
#include "analysis/road/road_outliers.h"
#include "analysis/road/road_withheld.h"
#include "analysis/survey/survey_lives.h"
#include "analysis/survey/survey_road.h"
#include "base/error.h"
#include "landscape/batch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <mutex>
#include <numeric>

namespace explore::analysis {
namespace {

constexpr int searches = 4; // at each of the first stations
constexpr int most_passes = 6;

void check_study(const study::Study& study) {
    const auto& axes = study.space.axes;
    if (std::all_of(axes.begin(), axes.end(), [](const auto& a) { return a.level == problem::Level::station; })) {
        throw pave::Error({.file = study.file, .key = "[[parameters]] level"},
                          "the stations of this road have no parameter in common", "level = \"station\" everywhere",
                          "level = \"shared\" or \"section\" at what is the same along the road; without: pavescape "
                          "survey");
    }
    if (!study.constraints.empty()) {
        throw pave::Error({.file = study.file, .line = study.constraints[0].line, .key = "constraints"},
                          "constraints are not taken of a road", study.constraints[0].text, "pavescape survey");
    }
    if (study.data.noise_degrees > 0.0) {
        throw pave::Error({.file = study.file, .line = study.data.noise_line, .key = "[data.noise] loss"},
                          "the tests of a road are those of normal noise", "loss = \"student\"",
                          "loss = \"normal\": stations that do not belong are found by themselves");
    }
    if (study.data.noise_scale_is_sought) {
        throw pave::Error({.file = study.file, .line = study.data.noise_line, .key = "[data.noise] scale"},
                          "a road finds the size of the noise from all stations together", "scale = \"sought\"",
                          "scale = \"stated\"");
    }
}

// The problem of a station in units of its noise. What is known of common unknowns is left out: it counts once.
problem::Problem problem_of(study::Study study) {
    for (auto& axis : study.space.axes) {
        if (axis.level != problem::Level::station) {
            axis.prior.reset();
        }
    }
    return study::make_noise_problem(study, study::Scope::everything);
}

// The homogeneous section of every station of the survey.
std::vector<std::optional<std::size_t>> sections_of(const SurveyResult& survey) {
    std::vector<std::optional<std::size_t>> found(survey.stations.size());
    for (std::size_t s = 0; s < survey.sections.size(); ++s) {
        for (std::size_t i = survey.sections[s].first; i <= survey.sections[s].last; ++i) {
            if (survey.stations[i].station.chainage_m) {
                found[i] = s;
            }
        }
    }
    return found;
}

RoadLayout layout_of(const SurveyResult& survey, const std::vector<StationTask>& tasks,
                     const std::vector<std::optional<std::size_t>>& sections) {
    RoadLayout layout;
    layout.blocks.resize(tasks.size());
    const auto& axes = survey.study->space.axes;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        std::map<std::size_t, int> of_section;
        for (std::size_t i = 0; i < tasks.size(); ++i) {
            auto& mine = layout.blocks[i].common;
            const auto next = static_cast<int>(layout.common.size());
            if (axes[k].level == problem::Level::station) {
                mine.push_back(optimise::own_unknown);
                continue;
            }
            const bool whole = axes[k].level == problem::Level::shared;
            const auto section =
                whole ? std::nullopt : sections[static_cast<std::size_t>(tasks[i].station - survey.stations.data())];
            const auto [at, is_new] = of_section.try_emplace(section.value_or(0), next);
            if (is_new) {
                layout.common.push_back({k, section});
            }
            mine.push_back(at->second);
        }
    }
    return layout;
}

// Takes out the tasks without a point to go on from; why: of each task, "" to keep it.
void drop(std::vector<StationTask>& tasks, const std::vector<std::string>& why) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (why[i].empty()) {
            if (next != i) {
                tasks[next] = std::move(tasks[i]);
            }
            ++next;
        } else {
            tasks[i].station->state = StationState::failed;
            tasks[i].station->reason = why[i];
        }
    }
    tasks.erase(tasks.begin() + static_cast<std::ptrdiff_t>(next), tasks.end());
}

class Road {
public:
    Road(Session& session, RoadResult& result) : session_(session), result_(result), survey_(result.survey) {}

    // False: interrupted.
    bool fit(const RoadOptions& options) {
        sections_ = sections_of(survey_);
        diagnoses_ = options.diagnose;
        if (options.withhold) {
            withheld_ = withhold(survey_, *options.withhold);
        }
        tasks_ = station_tasks(survey_, 1, problem_of);
        drop_without_section();
        if (!explore() || tasks_.empty()) {
            return tasks_.empty();
        }
        layout_ = layout_of(survey_, tasks_, sections_);
        RoadStations stations(session_, tasks_, runs_, layout_);
        RoadState state{stations, tasks_, layout_, std::vector<RoadPoint>(tasks_.size()), {}, {}};
        const bool finished = first_common() && hold_common(state) && together(state) && conclude_all(state);
        result_.survey.computed += stations.computed();
        return finished;
    }

private:
    void drop_without_section() {
        const auto& axes = survey_.study->space.axes;
        if (std::none_of(axes.begin(), axes.end(), [](const auto& a) { return a.level == problem::Level::section; })) {
            return;
        }
        std::vector<std::string> why(tasks_.size());
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            if (!sections_[static_cast<std::size_t>(tasks_[i].station - survey_.stations.data())]) {
                why[i] = "without a chainage it belongs to no section";
            }
        }
        drop(tasks_, why);
    }

    // Starts of every station from what is explored once for all.
    bool explore() {
        settings_.starts = searches;
        Exploration exploration(survey_,
                                search::sobol(survey_.study->space, survey_explored_points, session_.options().seed),
                                session_, "road");
        std::vector<std::string> why(tasks_.size());
        std::vector<std::vector<std::vector<double>>> starts;
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            auto found = exploration.starts(tasks_[i], settings_);
            if (!found) {
                return false;
            }
            why[i] = found->why_none;
            if (why[i].empty()) {
                starts.push_back(std::move(found->points));
                runs_.push_back(
                    session_.begin(tasks_[i].study, "road",
                                   fmt::format("{}; {} at {} kPa; {} starts, distance {}; {}", tasks_[i].words(),
                                               exploration.design().name, survey_.common_pressure_kPa, settings_.starts,
                                               settings_.start_distance, settings_.method)));
            }
        }
        drop(tasks_, why);
        starts_ = std::move(starts);
        survey_.computed += exploration.tally().computed;
        return true;
    }

    // A few stations by themselves, evenly along the road.
    bool first_common() {
        const std::size_t count = std::min<std::size_t>(road_first_stations, tasks_.size());
        std::vector<landscape::BatchItem> items;
        std::vector<std::size_t> which;
        for (std::size_t f = 0; f < count; ++f) {
            which.push_back(f * tasks_.size() / count);
            const std::size_t i = which.back();
            items.push_back({.problem = tasks_[i].problem, .run = runs_[i], .starts = starts_[i]});
        }
        std::vector<std::vector<double>> found(count);
        std::mutex mutex;
        std::size_t finished = 0;
        landscape::search_batch(items, session_.store(), *optimise::find_method(settings_.method), settings_.search,
                                session_.options().threads,
                                [&](std::size_t f, const std::vector<run::Endpoint>& ends, const run::Tally& tally) {
                                    const auto minima = landscape::distinct_minima(ends, items[f].problem);
                                    const std::scoped_lock lock(mutex);
                                    ++finished;
                                    survey_.computed += tally.computed;
                                    if (!minima.empty()) {
                                        found[f] = minima[0].unit;
                                    }
                                });
        if (finished < count) {
            return false;
        }
        // Medians: of a section, of its own stations where some were fitted.
        for (std::size_t c = 0; c < layout_.common.size(); ++c) {
            const std::size_t axis = layout_.common[c].axis;
            std::vector<double> everywhere;
            std::vector<double> here;
            for (std::size_t f = 0; f < count; ++f) {
                if (!found[f].empty()) {
                    everywhere.push_back(found[f][axis]);
                    if (layout_.blocks[which[f]].common[axis] == static_cast<int>(c)) {
                        here.push_back(found[f][axis]);
                    }
                }
            }
            if (everywhere.empty()) {
                throw pave::Error({.file = survey_.study->file}, "no station of this road fits the model",
                                  "not one search has an answer", "other bounds of the parameters");
            }
            common_.push_back(data::median(here.empty() ? everywhere : here));
        }
        return true;
    }

    std::vector<double> with_common(std::vector<double> unit, std::size_t i) const {
        for (std::size_t k = 0; k < unit.size(); ++k) {
            if (const int c = layout_.blocks[i].common[k]; c != optimise::own_unknown) {
                unit[k] = common_[static_cast<std::size_t>(c)];
            }
        }
        return unit;
    }

    // Every station's own unknowns for these common ones.
    bool hold_common(RoadState& state) {
        std::vector<std::string> why(tasks_.size());
        const bool finished = state.stations.for_each(tasks_.size(), [&](std::size_t i) {
            for (const auto& start : starts_[i]) {
                auto point = state.stations.search(i, with_common(start, i), layout_.own_axes(i), kept_as::own);
                if (!point) {
                    return;
                }
                why[i] = point->evaluation.converged() ? "" : point->evaluation.reason;
                state.points[i] = std::move(*point);
                if (why[i].empty()) {
                    return;
                }
            }
        });
        if (!finished) {
            return false;
        }
        // The numbers of the common unknowns may change with the stations that are left.
        std::vector<RoadPoint> points;
        std::vector<int> runs;
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            if (why[i].empty()) {
                points.push_back(std::move(state.points[i]));
                runs.push_back(runs_[i]);
            }
        }
        drop(tasks_, why);
        state.points = std::move(points);
        runs_ = std::move(runs);
        layout_ = layout_of(survey_, tasks_, sections_);
        return true;
    }

    // Searches all stations together, without outliers.
    bool together(RoadState& state) {
        common_.assign(layout_.common.size(), 0.5);
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            state.members.push_back(i);
        }
        judged_.resize(tasks_.size());
        std::vector<double> left_by(tasks_.size(), 1.0); // the p by which a station was left out
        for (int pass = 0; pass < most_passes; ++pass) {
            auto end = state.stations.search_together(state.members, state.points, kept_as::together * (1 + pass));
            if (!end) {
                return false;
            }
            state.end = std::move(*end);
            for (const std::size_t i : state.members) {
                for (std::size_t k = 0; k < state.points[i].unit.size(); ++k) {
                    if (const int c = layout_.blocks[i].common[k]; c != optimise::own_unknown) {
                        common_[static_cast<std::size_t>(c)] = state.points[i].unit[k];
                    }
                }
            }
            if (!follow(state, pass)) {
                return false;
            }
            result_.station_noise_factor = judge(state, judged_);
            std::vector<std::size_t> members;
            for (std::size_t i = 0; i < tasks_.size(); ++i) {
                if (judged_[i].p_familywise >= road_familywise) {
                    members.push_back(i);
                }
            }
            // Of two stations nobody can say which does not belong.
            if (members == state.members || 2 * members.size() <= tasks_.size() || pass + 1 == most_passes) {
                break;
            }
            for (const std::size_t i : state.members) {
                if (!std::binary_search(members.begin(), members.end(), i)) {
                    left_by[i] = judged_[i].p_familywise;
                }
            }
            state.members = std::move(members);
        }
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            judged_[i].station = static_cast<std::size_t>(tasks_[i].station - survey_.stations.data());
            judged_[i].section = sections_[judged_[i].station];
            judged_[i].is_outlier = !std::binary_search(state.members.begin(), state.members.end(), i);
            if (judged_[i].is_outlier) {
                judged_[i].p_familywise = std::min(judged_[i].p_familywise, left_by[i]);
            }
        }
        return true;
    }

    // The outliers' own unknowns for the common ones that the others have.
    bool follow(RoadState& state, int pass) {
        std::vector<std::size_t> others;
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            if (!std::binary_search(state.members.begin(), state.members.end(), i)) {
                others.push_back(i);
            }
        }
        return state.stations.for_each(others.size(), [&](std::size_t o) {
            const std::size_t i = others[o];
            auto point = state.stations.search(i, with_common(state.points[i].unit, i), layout_.own_axes(i),
                                               kept_as::own + 1 + pass);
            if (point && point->evaluation.converged()) {
                state.points[i] = std::move(*point);
            }
        });
    }

    bool conclude_all(RoadState& state) {
        std::vector<std::size_t> all(static_cast<std::size_t>(survey_.study->space.dimension()));
        std::iota(all.begin(), all.end(), std::size_t{0});
        std::vector<RoadPoint> alone(tasks_.size());
        const bool finished = state.stations.for_each(tasks_.size(), [&](std::size_t i) {
            if (auto point = state.stations.search(i, state.points[i].unit, all, kept_as::alone)) {
                alone[i] = std::move(*point);
            }
        });
        if (!finished) {
            return false;
        }
        result_.rounds = state.end.search.rounds;
        result_.converged = state.end.search.converged;
        result_.ended = state.end.search.ended;
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            landscape::Minimum best = landscape::minimum_at(state.points[i].evaluation, state.points[i].unit);
            best.converged = result_.converged;
            best.members = {0};
            StationResult& s = *tasks_[i].station;
            s.fit = fit_at(tasks_[i], best);
            s.fit->minima = 1;
            s.fit->starts = 1;
            judge_fit(s);
        }
        conclude(state, judged_, alone, result_);
        if (!predict_station_lives(state)) {
            return false;
        }
        result_.outliers = explain_outliers(state, judged_, alone, result_.station_noise_factor);
        if (diagnoses_) {
            result_.diagnosis = diagnose_road(session_, state, result_.dof, problem_of);
            if (!result_.diagnosis) {
                return false;
            }
        }
        if (!withheld_.empty()) {
            result_.withheld = predict(state, survey_, withheld_, problem_of, result_.noise_factor());
            return result_.withheld.has_value();
        }
        return true;
    }

    // To first order, with the covariance that the road leaves at a station.
    bool predict_station_lives(const RoadState& state) {
        const Eigen::MatrixXd common = common_covariance(state);
        std::vector<StationToLast> stations;
        for (std::size_t i = 0; i < tasks_.size(); ++i) {
            if (tasks_[i].station->is_fitted()) {
                const double noise = result_.noise_factor();
                stations.push_back(
                    {tasks_[i].station, tasks_[i].words(),
                     [covariance = StationInformation(state, i).covariance(common), noise](const Eigen::VectorXd& g) {
                         return noise * std::sqrt(std::max(0.0, g.dot(covariance * g)));
                     }});
            }
        }
        return predict_lives(session_, survey_, stations);
    }

    Session& session_;
    RoadResult& result_;
    SurveyResult& survey_;
    landscape::MultistartSettings settings_;
    std::vector<std::optional<std::size_t>> sections_; // of the survey's stations
    std::vector<StationTask> tasks_;
    std::vector<int> runs_;
    std::vector<std::vector<std::vector<double>>> starts_;
    RoadLayout layout_;
    std::vector<double> common_; // of the common unknowns, unit coordinates
    std::vector<RoadStation> judged_;
    std::vector<WithheldBowls> withheld_;
    bool diagnoses_ = false;
};

} // namespace

double RoadResult::noise_factor() const {
    return widened ? std::sqrt(chi2 / dof) : 1.0;
}

std::optional<RoadResult> road(Session& session, std::vector<data::FwdFile> files, study::Study survey_study,
                               const RoadOptions& options) {
    check_study(survey_study);
    check_criteria(survey_study);
    const auto begin = std::chrono::steady_clock::now();
    RoadResult result;
    result.survey = begin_survey(std::move(files), std::move(survey_study), options.survey);
    const data::DropChoice& drops = options.survey.drops;
    result.survey.fits_all_levels = !drops.target_pressure_kPa && !drops.target_force_kN;
    result.survey.sections = road_sections(result.survey);
    if (!Road(session, result).fit(options)) {
        return std::nullopt;
    }
    finish_survey(result.survey);
    result.survey.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis

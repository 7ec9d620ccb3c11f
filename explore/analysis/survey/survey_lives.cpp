#include "analysis/survey/survey_lives.h"

#include "analysis/design/design_overlay.h"
#include "run/parallel.h"
#include "study/problems.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <limits>
#include <mutex>

namespace explore::analysis {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// A station as its criteria see it.
struct Lasting {
    const StationToLast* task = nullptr;
    CriticalPlaces places;
    problem::Problem problem; // of the critical places
    int run = 0;              // of the store
};

StationLives lives_at(const std::vector<study::Criterion>& criteria, const Lasting& at,
                      const problem::Evaluation& there) {
    const StationFit& fit = *at.task->station->fit;
    std::vector<Life> lives;
    for (std::size_t l = 0; l < criteria.size(); ++l) {
        lives.emplace_back(at.places, criteria[l], at.places.candidates[l]);
    }
    const auto c = lives[0].at(there.parameters);
    StationLives found;
    std::vector<double> errors; // of ln(life)
    for (std::size_t l = 0; l < lives.size(); ++l) {
        const std::size_t place = lives[l].critical(c, there.responses);
        CriterionLife life{.criterion = criteria[l], .place = at.places.study.readings[place]};
        life.strain = {lives[l].strain(place, there.responses), unknown, unknown, unknown, unknown};
        const double log_life = lives[l].log_repetitions(place, c, there.responses);
        errors.push_back(at.task->error(lives[l].gradient(place, fit.best.unit, there)));
        const double half = fit.quantile * errors.back();
        life.allowable = {std::exp(log_life), unknown, unknown, unknown, unknown};
        if (std::isfinite(half)) {
            life.allowable.low = std::exp(log_life - half);
            life.allowable.high = std::exp(log_life + half);
        }
        life.required = criteria[l].passed + criteria[l].design_traffic.value_or(criteria[l].traffic_of(usual_years));
        life.set_remaining();
        found.criteria.push_back(std::move(life));
    }
    // Deviates of the best fit, of the ends of its range and of the reliability.
    const double reliable = gsl_cdf_ugaussian_Pinv(0.01 * usual_reliability_percent);
    std::vector<std::vector<double>> required;
    for (const double deviate : {0.0, -fit.quantile, fit.quantile, fit.quantile / inference::two_sided_95 * reliable}) {
        std::vector<double> demand;
        for (std::size_t l = 0; l < lives.size(); ++l) {
            demand.push_back(deviate == 0.0 ? found.criteria[l].required
                                            : found.criteria[l].required * std::exp(deviate * errors[l]));
        }
        required.push_back(std::move(demand));
    }
    const bool has_range = std::all_of(errors.begin(), errors.end(), [](double e) { return std::isfinite(e); });
    required.resize(has_range ? required.size() : 1);
    const auto needed = overlays_needed(at.places, lives, required, there.parameters);
    found.overlay.best = needed[0];
    found.overlay.most = thickest_overlay;
    found.has_range = has_range;
    if (has_range) {
        found.overlay.low = needed[1];
        found.overlay.high = needed[2];
        found.overlay.reliable = needed[3];
    }
    return found;
}

// The percentile of these values; the largest number there is stands for what is not known.
double share_of(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    const double part = place - static_cast<double>(below);
    return part > 0.0 ? values[below] + part * (values[above] - values[below]) : values[below];
}

} // namespace

void check_criteria(const study::Study& survey) {
    const auto criteria = study::criteria_of(survey);
    if (!criteria.empty()) {
        critical_places(survey, criteria);
    }
}

bool predict_lives(Session& session, SurveyResult& result, const std::vector<StationToLast>& stations) {
    const std::vector<study::Criterion> criteria = study::criteria_of(*result.study);
    if (criteria.empty()) {
        return true;
    }
    std::vector<bool> loads(result.study->model.loads.size(), false);
    for (const study::Criterion& criterion : criteria) {
        loads[criterion.load] = true;
    }
    std::vector<Lasting> all;
    all.reserve(stations.size()); // their places do not move
    for (const StationToLast& task : stations) {
        CriticalPlaces places = critical_places(
            study::station_outputs(*result.study, task.station->station, task.station->bowl()), criteria);
        problem::Problem problem = study::make_prediction_problem(places.study, loads);
        const int run = session.begin(
            places.study, "survey-lives",
            fmt::format("{} at {}", task.words, fmt::join(task.station->fit->best.evaluation.parameters, " ")));
        all.push_back({.task = &task, .places = std::move(places), .problem = std::move(problem), .run = run});
        all.back().problem = seasonal(all.back().problem, all.back().places);
    }
    const int at_once = run::concurrency(session.options().threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, at_once);
    tbb::task_arena arena(at_once);
    std::mutex mutex;
    std::size_t finished = 0;
    run::for_each_index(arena, all.size(), [&](std::size_t i) {
        run::Engine engine(all[i].problem, session.store(), all[i].run,
                           {.threads = session.options().threads, .show_progress = false});
        StationFit& fit = *all[i].task->station->fit;
        const auto there = engine.evaluate({.name = "best fit", .points = {fit.best.unit}}, true);
        if (!there) {
            return;
        }
        const problem::Evaluation& e = (*there)[0];
        std::optional<StationLives> lives;
        if (e.converged()) {
            lives = lives_at(criteria, all[i], e);
        }
        const std::scoped_lock lock(mutex);
        fit.lives = std::move(lives);
        result.computed += engine.tally().computed;
        ++finished;
    });
    return finished == all.size();
}

std::optional<SectionLife> life_of_section(const SurveyResult& result, const RoadSection& section) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::vector<double> years, low, high, overlay, reliable;
    for (std::size_t i = section.first; i <= section.last; ++i) {
        const StationResult& s = result.stations[i];
        if (!s.is_fitted() || !s.fit->lives) {
            continue;
        }
        const StationLives& lives = *s.fit->lives;
        const LifeRange& first = lives.first().years;
        const bool known = !std::isnan(first.low);
        years.push_back(first.best);
        low.push_back(known ? first.low : 0.0);
        high.push_back(known ? first.high : infinity);
        overlay.push_back(lives.overlay.best.value_or(infinity));
        reliable.push_back(lives.has_range ? lives.overlay.reliable.value_or(infinity) : infinity);
    }
    if (years.empty()) {
        return std::nullopt;
    }
    constexpr double few = 0.15;
    constexpr double most = 0.85;
    SectionLife life{.stations = years.size(),
                     .years = share_of(years, few),
                     .years_low = share_of(low, few),
                     .years_high = share_of(high, few)};
    const auto thickness = [](double mm) { return std::isfinite(mm) ? std::optional(mm) : std::nullopt; };
    life.overlay_mm = thickness(share_of(overlay, most));
    life.overlay_reliable_mm = thickness(share_of(reliable, most));
    return life;
}

} // namespace explore::analysis

#include "analysis/survey.h"

#include "analysis/survey_road.h"
#include "base/units.h"
#include "data/asphalt_temperature.h"
#include "data/fwd_values.h"
#include "landscape/batch.h"
#include "landscape/multistart.h"
#include "run/progress.h"
#include "study/laws.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <map>
#include <mutex>
#include <span>
#include <tuple>

namespace explore::analysis {
namespace {

constexpr int searches = 4; // at each station: one bowl tells few parameters, and a road has many stations
constexpr double no_place = std::numeric_limits<double>::infinity(); // a station without chainage goes to the end

// Whether at most of the stations where it can be told the first drop seats the plate.
bool first_drops_seat(const std::vector<StationResult>& stations) {
    std::size_t told = 0;
    std::size_t seating = 0;
    for (const StationResult& s : stations) {
        if (s.bowls && s.station.drops.size() >= 3) {
            ++told;
            seating += std::any_of(s.bowls->left_out.begin(), s.bowls->left_out.end(),
                                   [](const auto& drop) { return drop.why == data::LeftOut::seating; })
                           ? 1
                           : 0;
        }
    }
    return 2 * seating > told;
}

// Temperatures that no road has are not there; Fahrenheit under Celsius is the likely slip.
void check_temperatures(data::FwdStation& station) {
    constexpr double coldest = -50.0;
    constexpr double hottest = 75.0;
    for (auto [name, celsius] : {std::pair{"air", &station.air_C}, std::pair{"surface", &station.surface_C},
                                 std::pair{"asphalt", &station.asphalt_C}}) {
        if (*celsius && !(**celsius >= coldest && **celsius <= hottest)) {
            station.remarks.push_back(fmt::format("the {} temperature of {:g} C is not used{}", name, **celsius,
                                                  **celsius > hottest ? ": Fahrenheit in a Celsius column?" : ""));
            celsius->reset();
        }
    }
}

void make_bowls(StationResult& s, const data::DropChoice& choice) {
    auto bowls = data::bowls_of(s.station, choice);
    if (bowls) {
        s.bowls = *bowls;
    } else {
        s.state = StationState::rejected;
        s.reason = bowls.failure().reason;
    }
}

SurveyResult read_stations(std::vector<data::FwdFile> files, data::DropChoice choice) {
    SurveyResult result;
    for (data::FwdFile& file : files) {
        for (std::string& remark : file.remarks) {
            result.remarks.push_back(std::move(remark));
        }
        for (data::FwdStation& station : file.stations) {
            check_temperatures(station);
            result.stations.push_back({.station = std::move(station)});
            make_bowls(result.stations.back(), choice);
        }
    }
    if (first_drops_seat(result.stations)) {
        choice.first_of_two_seats = true;
        for (StationResult& s : result.stations) {
            if (s.bowls && s.station.drops.size() == 2) {
                make_bowls(s, choice);
            }
        }
    }
    const auto order = [](const StationResult& s) {
        return std::tuple<const std::string&, const std::string&, double>(s.station.profile, s.station.lane,
                                                                          s.station.chainage_m.value_or(no_place));
    };
    std::stable_sort(result.stations.begin(), result.stations.end(),
                     [&](const StationResult& a, const StationResult& b) { return order(a) < order(b); });
    return result;
}

double rms_percent(const problem::Problem& problem, const std::vector<double>& responses) {
    double sum = 0.0;
    for (std::size_t i = 0; i < problem.readings(); ++i) {
        sum += std::pow(responses[problem.response_of(i)] / problem.measured(i) - 1.0, 2);
    }
    return 100.0 * std::sqrt(sum / static_cast<double>(problem.readings()));
}

// The 95 % range of each parameter from its standard error in unit coordinates.
std::vector<ParameterRange> ranges_of(const landscape::Minimum& best, const landscape::LocalAnalysis& local,
                                      const problem::ParameterSpace& space) {
    // Noise that was stated and is not contradicted is known; otherwise it is estimated from what the fit leaves over.
    const bool noise_is_known = local.noise_is_stated && !local.widened;
    const double quantile = noise_is_known || local.degrees_of_freedom < 1
                                ? 1.96
                                : gsl_cdf_tdist_Pinv(0.975, static_cast<double>(local.degrees_of_freedom));
    constexpr double half_box = 0.5;
    std::vector<ParameterRange> ranges;
    for (std::size_t k = 0; k < space.axes.size(); ++k) {
        const double half = quantile * local.standard_error[k];
        const double low = std::max(0.0, best.unit[k] - half);
        const double high = std::min(1.0, best.unit[k] + half);
        ranges.push_back({.value = best.evaluation.parameters[k],
                          .low = space.axes[k].physical(low),
                          .high = space.axes[k].physical(high),
                          .determined = low > 0.0 && high < 1.0 && high - low < half_box});
    }
    return ranges;
}

std::vector<const data::DeflectionBowl*> fitted_bowls(const StationResult& s, const std::vector<std::size_t>& levels) {
    std::vector<const data::DeflectionBowl*> bowls;
    bowls.reserve(levels.size());
    for (const std::size_t level : levels) {
        bowls.push_back(&s.bowls->levels[level]);
    }
    return bowls;
}

// What is explored once for all stations with one plate and one set of sensors: the responses at the points of a
// design, under the common pressure. Nothing: interrupted.
class Exploration {
public:
    Exploration(const SurveyResult& result, search::Design design, Session& session)
        : result_(result),
          design_(std::move(design)),
          session_(session) {}

    struct Starts {
        std::vector<std::vector<double>> points;
        std::string why_none; // when there is no point
    };

    // Points from which to search at a station: the best by the explored responses, in proportion to its pressures.
    // That is exact for a linear pavement and near enough to choose starts for another.
    std::optional<Starts> starts(const StationResult& s, const std::vector<const data::DeflectionBowl*>& bowls,
                                 const problem::Problem& problem, const landscape::MultistartSettings& settings) {
        const data::DeflectionBowl layout = all_sensors(bowls);
        auto* explored = at(s, layout);
        if (explored == nullptr) {
            return std::nullopt;
        }
        // Where each response of the problem stands among those explored, and by what it is scaled.
        std::vector<std::pair<std::size_t, double>> from;
        for (const data::DeflectionBowl* bowl : bowls) {
            for (const auto& reading : bowl->readings) {
                const auto same = std::find_if(layout.readings.begin(), layout.readings.end(),
                                               [&](const auto& r) { return r.offset_mm == reading.offset_mm; });
                from.emplace_back(static_cast<std::size_t>(same - layout.readings.begin()),
                                  bowl->pressure_kPa / result_.common_pressure_kPa);
            }
        }
        std::vector<problem::Evaluation> scaled = *explored;
        for (auto& e : scaled) {
            if (!e.converged()) {
                continue;
            }
            std::vector<double> responses;
            responses.reserve(from.size());
            for (const auto& [index, factor] : from) {
                responses.push_back(factor * e.responses[index]);
            }
            e.responses = std::move(responses);
            e.misfit = problem.misfit(e);
        }
        Starts starts;
        for (const std::size_t i : run::distinct_starts(design_, scaled, settings.starts, settings.start_distance)) {
            starts.points.push_back(design_.points[i]);
        }
        if (starts.points.empty()) {
            starts.why_none = run::why_no_start(*explored);
        }
        return starts;
    }

    const run::Tally& tally() const { return tally_; }

private:
    // A bowl with the sensors of all these.
    static data::DeflectionBowl all_sensors(const std::vector<const data::DeflectionBowl*>& bowls) {
        data::DeflectionBowl all = *bowls[0];
        for (const data::DeflectionBowl* bowl : bowls) {
            for (const auto& reading : bowl->readings) {
                if (!all.has_sensor_at(reading.offset_mm)) {
                    all.readings.push_back(reading);
                }
            }
        }
        std::sort(all.readings.begin(), all.readings.end(),
                  [](const auto& a, const auto& b) { return a.offset_mm < b.offset_mm; });
        return all;
    }

    const std::vector<problem::Evaluation>* at(const StationResult& s, data::DeflectionBowl bowl) {
        std::vector<double> layout{bowl.radius_mm};
        for (const auto& reading : bowl.readings) {
            layout.push_back(reading.offset_mm);
        }
        if (const auto known = explored_.find(layout); known != explored_.end()) {
            return &known->second;
        }
        bowl.pressure_kPa = result_.common_pressure_kPa;
        const study::Study study = study::station_study(*result_.study, s.station, {&bowl}, std::nullopt);
        const problem::Problem problem = study::make_problem(study);
        auto engine = session_.engine(problem, session_.begin(study, "survey", "explored: " + design_.run_name()));
        auto evaluations = engine.evaluate(design_);
        tally_.computed += engine.tally().computed;
        if (!evaluations) {
            return nullptr;
        }
        return &explored_.emplace(std::move(layout), std::move(*evaluations)).first->second;
    }

    const SurveyResult& result_;
    search::Design design_;
    Session& session_;
    std::map<std::vector<double>, std::vector<problem::Evaluation>> explored_; // by plate radius and offsets
    run::Tally tally_;
};

// Levels that are fitted at a station: all of them tell how a stress-dependent section changes with the load.
std::vector<std::size_t> levels_to_fit(const StationResult& s, bool all) {
    if (!all) {
        return {s.bowls->main};
    }
    std::vector<std::size_t> levels(s.bowls->levels.size());
    for (std::size_t i = 0; i < levels.size(); ++i) {
        levels[i] = i;
    }
    return levels;
}

std::optional<double> repeatability_of(std::span<const StationResult> stations) {
    std::vector<const data::DeflectionBowl*> bowls;
    for (const StationResult& s : stations) {
        for (std::size_t i = 0; s.has_bowl() && i < s.bowls->levels.size(); ++i) {
            bowls.push_back(&s.bowls->levels[i]);
        }
    }
    return data::repeatability(bowls);
}

StationFit fit_of(const problem::Problem& problem, const landscape::Minimum& best, const StationResult& s,
                  std::vector<std::size_t> levels) {
    StationFit fit;
    fit.best = best;
    fit.rms_percent = rms_percent(problem, best.evaluation.responses);
    fit.local = landscape::analyse(best, problem);
    fit.parameters = ranges_of(best, fit.local, problem.space);
    std::size_t next = 0;
    for (const std::size_t level : levels) {
        auto& um = fit.model_um.emplace_back();
        for (std::size_t i = 0; i < s.bowls->levels[level].readings.size(); ++i) {
            um.push_back(best.evaluation.responses[next++] / pave::unit::um);
        }
    }
    fit.levels = std::move(levels);
    return fit;
}

// Back-calculates every station that is not rejected. False: interrupted; what was computed is in the store.
bool fit_stations(Session& session, SurveyResult& result) {
    landscape::MultistartSettings settings;
    settings.starts = searches;
    const auto design = search::sobol(result.study->space, survey_explored_points, session.options().seed);
    const auto parameters = static_cast<std::size_t>(result.study->space.dimension());
    std::vector<study::Study> studies;
    std::vector<landscape::BatchItem> items;
    std::vector<StationResult*> stations; // of the items
    std::vector<std::vector<std::size_t>> levels;
    std::optional<pave::Error> complaint;
    for (StationResult& s : result.stations) {
        if (!s.has_bowl()) {
            continue;
        }
        auto own_levels = levels_to_fit(s, result.fits_all_levels);
        const auto bowls = fitted_bowls(s, own_levels);
        std::size_t readings = 0;
        for (const auto* bowl : bowls) {
            readings += bowl->readings.size();
        }
        if (readings < parameters) {
            s.state = StationState::failed;
            s.reason = fmt::format("{} readings cannot tell {} parameters", readings, parameters);
            continue;
        }
        try {
            const auto own = repeatability_of({&s, 1});
            auto study = study::station_study(*result.study, s.station, bowls, own ? own : result.repeatability);
            items.push_back({.problem = study::make_problem(study), .run = 0, .starts = {}});
            studies.push_back(std::move(study));
            stations.push_back(&s);
            levels.push_back(std::move(own_levels));
        } catch (const pave::Error& error) {
            s.state = StationState::failed;
            s.reason = error.what();
            complaint = complaint ? complaint : error;
        }
    }
    if (items.empty()) {
        if (complaint) {
            throw *complaint;
        }
        return true;
    }
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::string> why_none; // should a station end without a result
    Exploration exploration(result, design, session);
    for (std::size_t i = 0; i < items.size(); ++i) {
        auto starts =
            exploration.starts(*stations[i], fitted_bowls(*stations[i], levels[i]), items[i].problem, settings);
        if (!starts) {
            return false;
        }
        items[i].starts = std::move(starts->points);
        why_none.push_back(starts->why_none.empty() ? "no start has an answer under the load of this station"
                                                    : std::move(starts->why_none));
        const auto& station = stations[i]->station;
        items[i].run =
            session.begin(studies[i], "survey",
                          fmt::format("station {} at {} m; {} at {} kPa; {} starts, distance {}; {}",
                                      pave::join(station.lane.empty() ? std::vector{station.name}
                                                                      : std::vector{station.name, station.lane}),
                                      station.chainage_m.value_or(NAN), design.name, result.common_pressure_kPa,
                                      settings.starts, settings.start_distance, settings.method));
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
        StationResult& s = *stations[i];
        if (minima.empty()) {
            s.state = StationState::failed;
            s.reason = why_none[i];
            return;
        }
        s.fit = fit_of(items[i].problem, minima[0], s, levels[i]);
        s.fit->minima = minima.size();
        s.fit->starts = ends.size();
        if (!(s.fit->rms_percent <= no_fit_percent)) {
            s.no_fit = NoFit::far_off;
        } else if (minima[0].on_bound.size() == parameters) {
            s.no_fit = NoFit::all_on_bounds;
        }
        s.state = s.no_fit ? StationState::no_fit : s.state;
    };
    landscape::search_batch(items, session.store(), *optimise::find_method(settings.method), settings.search,
                            session.options().threads, keep);
    result.computed += exploration.tally().computed;
    result.floor = floor_of(result, stations, studies);
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return finished == items.size();
}

void add_temperature(StationResult& s, const SurveyOptions& options, std::optional<double> thickness_mm) {
    const data::FwdStation& station = s.station;
    // Writers without a reading put 0 there.
    const bool is_measured =
        station.asphalt_C && (*station.asphalt_C != 0.0 || (station.surface_C && std::abs(*station.surface_C) < 2.0));
    if (is_measured) {
        s.asphalt = {*station.asphalt_C, TemperatureSource::measured};
        return;
    }
    const auto hour = data::hour_of_day(station.time);
    const auto air = options.air_of_day_before_C ? options.air_of_day_before_C : station.air_C;
    if (station.surface_C && hour && air && thickness_mm) {
        s.asphalt = {data::bells3(*station.surface_C, *air, *hour, *thickness_mm / 2.0),
                     options.air_of_day_before_C ? TemperatureSource::bells3 : TemperatureSource::bells3_of_the_hour};
    }
}

} // namespace

double LoadLevel::pressure_on(double radius_mm) const {
    return pressure_kPa ? *pressure_kPa : data::plate_pressure_kPa(*force_kN, radius_mm);
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
    SurveyResult result = read_stations(std::move(files), options.drops);
    result.study = std::move(survey_study);
    result.normalise = options.normalise;
    result.reference_C = options.reference_C;
    std::vector<double> pressures;
    for (const StationResult& s : result.stations) {
        if (s.has_bowl()) {
            pressures.push_back(s.bowl().pressure_kPa);
        }
    }
    result.common_pressure_kPa = pressures.empty() ? 0.0 : data::median(pressures);
    result.repeatability = repeatability_of(result.stations);
    const bool is_targeted = options.drops.target_pressure_kPa || options.drops.target_force_kN;
    result.fits_all_levels = result.study && !is_targeted && !study::stress_dependent_layers(*result.study).empty();
    if (result.study && !fit_stations(session, result)) {
        return std::nullopt;
    }
    auto thickness_mm = options.asphalt_thickness_mm;
    std::optional<std::size_t> asphalt; // the parameter that is the modulus of the top layer
    if (result.study) {
        const auto& top = result.study->model.layers[0];
        thickness_mm = thickness_mm ? thickness_mm : std::optional(top.thickness / pave::unit::mm);
        const auto names = result.parameter_names();
        const auto at = std::find(names.begin(), names.end(), top.name + ".modulus_MPa");
        asphalt = at == names.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - names.begin()));
    }
    for (StationResult& s : result.stations) {
        if (!s.has_bowl()) {
            continue;
        }
        s.normalised_kPa =
            options.normalise ? options.normalise->pressure_on(s.bowl().radius_mm) : result.common_pressure_kPa;
        s.indices = data::indices_of(s.bowl(), s.normalised_kPa);
        add_temperature(s, options, thickness_mm);
        if (options.reference_C && s.asphalt && asphalt && s.is_fitted()) {
            s.asphalt_at_reference_MPa =
                s.fit->parameters[*asphalt].value * data::modulus_factor(s.asphalt->celsius, *options.reference_C);
        }
    }
    result.sections = road_sections(result);
    result.suspect = suspect_sensor(result);
    return result;
}

} // namespace explore::analysis

#include "analysis/survey/survey_stations.h"

#include "analysis/survey/survey_layers.h"
#include "analysis/survey/survey_layout.h"
#include "analysis/survey/survey_network.h"
#include "analysis/survey/survey_road.h"
#include "analysis/survey/survey_sensors.h"
#include "analysis/survey/survey_temperature.h"
#include "analysis/survey/survey_trials.h"
#include "base/text.h"
#include "base/units.h"
#include "data/road_bowls.h"
#include "study/laws.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <tuple>

namespace explore::analysis {
namespace {

constexpr double no_place = std::numeric_limits<double>::infinity(); // a station without chainage goes to the end

// Temperatures that no road has are not there. One that is too hot for Celsius, and a road's in Fahrenheit, casts doubt
// on what else the line states.
void check_temperatures(data::FwdStation& station) {
    constexpr double coldest = -50.0;
    constexpr double hottest_air = 58.0;
    constexpr double hottest_road = 75.0;
    constexpr double hottest_in_fahrenheit = 170.0;
    constexpr double freezing_in_fahrenheit = 32.0;
    const std::tuple<const char*, std::optional<double>&, double> stated[] = {
        {"air", station.air_C, hottest_air},
        {"surface", station.surface_C, hottest_road},
        {"asphalt", station.asphalt_C, hottest_road}};
    const bool is_fahrenheit = std::ranges::any_of(stated, [&](const auto& t) {
        return std::get<1>(t) > std::get<2>(t) && std::get<1>(t) <= hottest_in_fahrenheit;
    });
    for (const auto& [name, celsius, hottest] : stated) {
        const bool is_doubtful = is_fahrenheit && celsius >= freezing_in_fahrenheit;
        if (celsius && (is_doubtful || !(*celsius >= coldest && *celsius <= hottest))) {
            station.remarks.push_back(
                fmt::format("the {} temperature of {:g} C is not used{}", name, *celsius,
                            is_doubtful || *celsius > hottest ? ": Fahrenheit in a Celsius column?" : ""));
            celsius.reset();
        }
    }
}

void make_bowls(std::vector<StationResult>& stations, const data::DropChoice& choice) {
    std::vector<const data::FwdStation*> road;
    road.reserve(stations.size());
    for (const StationResult& s : stations) {
        road.push_back(&s.station);
    }
    auto bowls = data::bowls_of_road(road, choice);
    for (std::size_t i = 0; i < stations.size(); ++i) {
        if (bowls[i]) {
            stations[i].bowls = std::move(bowls[i]).value();
        } else {
            stations[i].state = StationState::rejected;
            stations[i].reason = bowls[i].failure().reason;
        }
    }
}

// One lane on different dates, or in different files: runs of their own where their stretches lie over each
// other, one road where one follows the other.
using Stretches = std::map<std::string, std::pair<double, double>>; // by date or file: the first and the last chainage
bool are_runs(const Stretches& stretches) {
    for (auto a = stretches.begin(); a != stretches.end(); ++a) {
        for (auto b = std::next(a); b != stretches.end(); ++b) {
            const double shared =
                std::min(a->second.second, b->second.second) - std::max(a->second.first, b->second.first);
            const bool is_point = a->second.first == a->second.second || b->second.first == b->second.second;
            if (is_point ? shared >= 0.0 : shared > 0.0) {
                return true;
            }
        }
    }
    return false;
}

void part_runs(std::vector<StationResult>& stations,
               const std::function<std::string(const data::FwdStation&)>& name_of) {
    std::map<std::pair<std::string, std::string>, Stretches> lanes; // by profile and lane
    for (const StationResult& s : stations) {
        if (const auto at = s.station.chainage_m) {
            const auto [known, is_new] =
                lanes[{s.station.profile, s.station.lane}].try_emplace(name_of(s.station), *at, *at);
            auto& [first, last] = known->second;
            first = std::min(first, *at);
            last = std::max(last, *at);
        }
    }
    std::set<std::string> profiles; // with a lane of several runs
    for (const auto& [lane, stretches] : lanes) {
        if (are_runs(stretches)) {
            profiles.insert(lane.first);
        }
    }
    for (StationResult& s : stations) {
        if (profiles.contains(s.station.profile)) {
            const std::string name = name_of(s.station);
            if (s.station.profile.find(name) == std::string::npos) {
                s.station.profile += (s.station.profile.empty() || name.empty() ? "" : ", ") + name;
            }
        }
    }
}

// Names that differ in upper and lower case only are one lane, or one road: as it is written most often (then first).
void unite_spellings(SurveyResult& result, std::string data::FwdStation::*name, std::string_view what) {
    std::map<std::string, std::map<std::string, std::size_t>> spellings; // by the name in lower case
    for (const StationResult& s : result.stations) {
        ++spellings[data::lower_case(s.station.*name)][s.station.*name];
    }
    for (const auto& [plain, written] : spellings) {
        if (written.size() < 2) {
            continue;
        }
        const auto most = std::max_element(written.begin(), written.end(),
                                           [](const auto& a, const auto& b) { return a.second < b.second; });
        std::vector<std::string> others;
        std::size_t stations = 0;
        for (const auto& [spelling, count] : written) {
            if (spelling != most->first) {
                others.push_back("\"" + spelling + "\"");
                stations += count;
            }
        }
        for (StationResult& s : result.stations) {
            if (data::lower_case(s.station.*name) == plain) {
                s.station.*name = most->first;
            }
        }
        result.remarks.push_back(fmt::format(
            "{} is taken for {} \"{}\": {}, which {} in upper and lower case only.", pave::join(others, " and "), what,
            most->first, pave::counted(stations, "station", "stations"), stations == 1 ? "differs" : "differ"));
    }
}

void unite_spellings(SurveyResult& result) {
    unite_spellings(result, &data::FwdStation::lane, "lane");
    unite_spellings(result, &data::FwdStation::profile, "road");
}

SurveyResult read_stations(std::vector<data::FwdFile> files, const data::DropChoice& choice) {
    SurveyResult result;
    for (data::FwdFile& file : files) {
        for (std::string& remark : file.remarks) {
            result.remarks.push_back(std::move(remark));
        }
        for (data::FwdStation& station : file.stations) {
            check_temperatures(station);
            result.stations.push_back({.station = std::move(station)});
        }
    }
    make_bowls(result.stations, choice);
    unite_spellings(result);
    part_runs(result.stations, [](const data::FwdStation& s) { return s.date.substr(0, s.date.find_first_of(" T")); });
    part_runs(result.stations, [](const data::FwdStation& s) { return std::filesystem::path(s.file).stem().string(); });
    const auto order = [](const StationResult& s) {
        return std::tuple<const std::string&, const std::string&, double>(s.station.profile, s.station.lane,
                                                                          s.station.chainage_m.value_or(no_place));
    };
    std::stable_sort(result.stations.begin(), result.stations.end(),
                     [&](const StationResult& a, const StationResult& b) { return order(a) < order(b); });
    return result;
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

double rms_percent(const problem::Problem& problem, const std::vector<double>& responses) {
    double sum = 0.0;
    for (std::size_t i = 0; i < problem.readings(); ++i) {
        sum += std::pow(responses[problem.response_of(i)] / problem.measured(i) - 1.0, 2);
    }
    return 100.0 * std::sqrt(sum / static_cast<double>(problem.readings()));
}

} // namespace

std::vector<const data::DeflectionBowl*> StationTask::bowls() const {
    std::vector<const data::DeflectionBowl*> found;
    found.reserve(levels.size());
    for (const std::size_t level : levels) {
        found.push_back(&station->bowls->levels[level]);
    }
    return found;
}

data::DeflectionBowl StationTask::layout() const {
    const auto list = bowls();
    data::DeflectionBowl all = *list[0];
    for (const data::DeflectionBowl* bowl : list) {
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

std::string StationTask::words() const {
    const data::FwdStation& s = station->station;
    return fmt::format("station {} at {} m",
                       pave::join(s.lane.empty() ? std::vector{s.name} : std::vector{s.name, s.lane}),
                       s.chainage_m.value_or(NAN));
}

std::vector<double> layout_key(const data::DeflectionBowl& layout) {
    std::vector<double> key{layout.radius_mm};
    for (const auto& reading : layout.readings) {
        key.push_back(reading.offset_mm);
    }
    return key;
}

std::vector<std::size_t> sensors_of(const data::DeflectionBowl& bowl, const data::DeflectionBowl& layout) {
    std::vector<std::size_t> numbers;
    for (const auto& reading : bowl.readings) {
        const auto same = std::find_if(layout.readings.begin(), layout.readings.end(),
                                       [&](const auto& r) { return r.offset_mm == reading.offset_mm; });
        numbers.push_back(static_cast<std::size_t>(same - layout.readings.begin()));
    }
    return numbers;
}

std::vector<StationTask> station_tasks(SurveyResult& result, std::size_t unknowns,
                                       const std::function<problem::Problem(const study::Study&)>& make_problem) {
    std::vector<StationTask> tasks;
    std::optional<pave::Error> complaint;
    for (StationResult& s : result.stations) {
        if (!s.has_bowl()) {
            continue;
        }
        auto levels = levels_to_fit(s, result.fits_all_levels);
        std::vector<const data::DeflectionBowl*> bowls;
        std::size_t readings = 0;
        for (const std::size_t level : levels) {
            bowls.push_back(&s.bowls->levels[level]);
            readings += bowls.back()->readings.size();
        }
        if (readings < unknowns) {
            s.state = StationState::failed;
            s.reason = fmt::format("{} readings cannot tell {} parameters", readings, unknowns);
            continue;
        }
        try {
            const auto own = repeatability_of({&s, 1});
            auto study = study::station_study(*result.study, s.station, bowls, own ? own : result.repeatability);
            problem::Problem problem = make_problem(study);
            tasks.push_back({&s, std::move(levels), std::move(study), std::move(problem)});
        } catch (const pave::Error& error) {
            s.state = StationState::failed;
            s.reason = error.what();
            complaint = complaint ? complaint : error;
        }
    }
    if (tasks.empty() && complaint) {
        throw *complaint;
    }
    return tasks;
}

StationFit fit_at(const StationTask& task, const landscape::Minimum& best) {
    StationFit fit;
    fit.best = best;
    fit.rms_percent = rms_percent(task.problem, best.evaluation.responses);
    std::size_t next = 0;
    for (const data::DeflectionBowl* bowl : task.bowls()) {
        auto& um = fit.model_um.emplace_back();
        for (std::size_t i = 0; i < bowl->readings.size(); ++i) {
            um.push_back(best.evaluation.responses[next++] / pave::unit::um);
        }
    }
    fit.levels = task.levels;
    return fit;
}

void judge_fit(StationResult& s) {
    const StationFit& fit = *s.fit;
    if (!(fit.rms_percent <= no_fit_percent)) {
        s.no_fit = NoFit::far_off;
    } else if (fit.best.on_bound.size() == fit.best.unit.size()) {
        s.no_fit = NoFit::all_on_bounds;
    }
    if (s.no_fit) {
        s.state = StationState::no_fit;
    } else if (fit.rms_percent > doubtful_percent) {
        s.state = StationState::doubtful;
    }
}

ParameterRange range_about(const problem::Axis& axis, double unit, double half) {
    ParameterRange range = range_between(axis, std::max(0.0, unit - half), std::min(1.0, unit + half));
    range.value = axis.physical(unit);
    return range;
}

ParameterRange range_between(const problem::Axis& axis, double low, double high) {
    constexpr double half_box = 0.5;
    return {.low = axis.physical(low),
            .high = axis.physical(high),
            .determined = low > 0.0 && high < 1.0 && high - low < half_box};
}

Exploration::Exploration(const SurveyResult& result, search::Design design, Session& session, std::string command,
                         const Networks* networks)
    : result_(result),
      design_(std::move(design)),
      session_(session),
      command_(std::move(command)),
      networks_(networks) {}

std::optional<Exploration::Starts> Exploration::starts(const StationTask& task,
                                                       const landscape::MultistartSettings& settings) {
    const auto bowls = task.bowls();
    const data::DeflectionBowl layout = task.layout();
    auto* explored = at(*task.station, layout);
    if (explored == nullptr) {
        return std::nullopt;
    }
    // Where each response of the problem stands among those explored, and by what it is scaled.
    std::vector<std::pair<std::size_t, double>> from;
    for (const data::DeflectionBowl* bowl : bowls) {
        for (const std::size_t sensor : sensors_of(*bowl, layout)) {
            from.emplace_back(sensor, bowl->pressure_kPa / result_.common_pressure_kPa);
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
        e.misfit = task.problem.misfit(e);
    }
    Starts starts;
    for (const std::size_t i : run::distinct_starts(design_, scaled, settings.starts, settings.start_distance)) {
        starts.points.push_back(design_.points[i]);
    }
    if (starts.points.empty()) {
        starts.why_none = run::why_no_minimum(task.problem, *explored);
    }
    return starts;
}

const std::vector<problem::Evaluation>* Exploration::at(const StationResult& s, data::DeflectionBowl bowl) {
    std::vector<double> layout = layout_key(bowl);
    if (const auto known = explored_.find(layout); known != explored_.end()) {
        return &known->second;
    }
    bowl.pressure_kPa = result_.common_pressure_kPa;
    data::FwdStation of_study = s.station; // its layers are those of all stations
    of_study.layers.clear();
    const study::Study study = study::station_study(*result_.study, of_study, {&bowl}, std::nullopt);
    problem::Problem problem = study::make_problem(study);
    std::string settings = "explored: " + design_.run_name();
    const ReducedProblem* network = networks_ == nullptr ? nullptr : networks_->of(bowl);
    if (network != nullptr) {
        problem = on_network(std::move(problem), *network, {&bowl}, bowl);
        settings += network->settings;
    }
    auto engine = session_.engine(problem, session_.begin(study, command_, settings));
    auto evaluations = engine.evaluate(design_);
    tally_.computed += network == nullptr ? engine.tally().computed : 0;
    if (!evaluations) {
        return nullptr;
    }
    return &explored_.emplace(std::move(layout), std::move(*evaluations)).first->second;
}

SurveyResult begin_survey(std::vector<data::FwdFile> files, std::optional<study::Study> survey_study,
                          const SurveyOptions& options) {
    SurveyResult result = read_stations(std::move(files), options.drops);
    result.study = std::move(survey_study);
    set_layers(result, options.layers);
    result.normalise = options.normalise;
    if (options.drops.target_pressure_kPa || options.drops.target_force_kN) {
        result.target =
            LoadLevel{.pressure_kPa = options.drops.target_pressure_kPa, .force_kN = options.drops.target_force_kN};
    }
    result.reference_C = options.reference_C;
    result.curve = options.curve;
    std::vector<double> pressures;
    for (const StationResult& s : result.stations) {
        if (s.has_bowl()) {
            pressures.push_back(s.bowl().pressure_kPa);
        }
    }
    result.common_pressure_kPa = pressures.empty() ? 0.0 : data::median(pressures);
    result.repeatability = repeatability_of(result.stations);
    result.fits_all_levels = result.study && !result.target && !study::stress_dependent_layers(*result.study).empty();
    const auto asphalt_mm = [&](const StationResult& s) {
        if (options.asphalt_thickness_mm || !result.study) {
            return options.asphalt_thickness_mm;
        }
        const auto& top = result.study->model.layers[0];
        const auto stated = s.station.layers.find(top.name);
        return std::optional(stated == s.station.layers.end() ? top.thickness / pave::unit::mm : stated->second.mm);
    };
    for (StationResult& s : result.stations) {
        if (s.has_bowl()) {
            s.normalised_kPa =
                options.normalise ? options.normalise->pressure_on(s.bowl().radius_mm) : result.common_pressure_kPa;
            s.indices = data::indices_of(s.bowl(), s.normalised_kPa);
            take_to_reference(s, options, asphalt_mm(s));
        }
    }
    return result;
}

void finish_survey(SurveyResult& result) {
    take_moduli_to_reference(result);
    result.sections = road_sections(result);
    judge_sensors(result);
    result.trials = section_trials(result);
    result.layout = better_layout(result);
    if (result.layout) {
        result.suspect.reset();
    }
}

} // namespace explore::analysis

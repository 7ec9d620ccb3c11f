#include "analysis/survey/survey_findings.h"

#include "analysis/common/say.h"
#include "analysis/survey/survey_copies.h"
#include "analysis/survey/survey_noise.h"
#include "analysis/survey/survey_places.h"
#include "analysis/survey/survey_rejected.h"
#include "analysis/survey/survey_temperature.h"
#include "analysis/survey/survey_trials.h"
#include "analysis/survey/weak_stations.h"

#include "base/text.h"
#include "data/resolution.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>

namespace explore::analysis {
namespace {

constexpr double poor_percent = 5.0;    // beyond this a fit is remarked
constexpr double noisy_share = 0.03;    // repeatability that is remarked; sensors repeat within 1 to 2 %
constexpr double bells_coldest_C = 0.0; // surface temperatures that BELLS3 was made with (AASHTO T 317)
constexpr double bells_hottest_C = 40.0;
constexpr double often = 1.0 / 3.0; // of the stations, that end on one bound
constexpr std::size_t least_often = 3;

std::string numbers_in_words(const std::vector<int>& numbers) {
    std::vector<std::string> words;
    words.reserve(numbers.size());
    for (const int number : numbers) {
        words.push_back(std::to_string(number));
    }
    return (numbers.size() == 1 ? "drop " : "drops ") + pave::join(words);
}

// "drops 1, 2 left out: ..." for every reason.
void add_drops_left_out(const StationResult& s, bool is_targeted, std::vector<std::string>& words) {
    const auto with = [&](data::LeftOut why) {
        std::vector<int> numbers;
        for (const data::DropLeftOut& drop : s.bowls->left_out) {
            if (drop.why == why) {
                numbers.push_back(drop.number);
            }
        }
        return numbers;
    };
    for (const data::DropLeftOut& drop : s.bowls->left_out) {
        if (!drop.words.empty()) {
            words.push_back(fmt::format("drop {} is left out: {}", drop.number, drop.words));
        }
    }
    if (const auto seating = with(data::LeftOut::seating); !seating.empty()) {
        words.push_back(numbers_in_words(seating) + " is left out: it seats the plate");
    }
    if (const auto others = with(data::LeftOut::not_chosen); !others.empty()) {
        words.push_back(numbers_in_words(others) + " left out by --drops");
    }
    std::vector<int> other_levels;
    const auto used = s.used_levels();
    for (std::size_t i = 0; i < s.bowls->levels.size(); ++i) {
        if (std::find(used.begin(), used.end(), i) == used.end()) {
            const auto& drops = s.bowls->levels[i].drops;
            other_levels.insert(other_levels.end(), drops.begin(), drops.end());
        }
    }
    if (!other_levels.empty()) {
        std::sort(other_levels.begin(), other_levels.end());
        words.push_back(fmt::format("{} left out: at other loads than {:.0f} kPa{}", numbers_in_words(other_levels),
                                    s.bowl().pressure_kPa,
                                    is_targeted ? ""
                                                : " (--target-load chooses another; a stress-dependent section is "
                                                  "fitted to all)"));
    }
}

// Whether so many stations end on this bound that it is a matter of the study and not of one of them.
std::size_t stations_on(const SurveyResult& result, const landscape::BoundMet& bound) {
    return result.count([&](const StationResult& s) {
        return s.fit &&
               std::find(s.fit->best.on_bound.begin(), s.fit->best.on_bound.end(), bound) != s.fit->best.on_bound.end();
    });
}
bool is_often_met(const SurveyResult& result, const landscape::BoundMet& bound) {
    const std::size_t on = stations_on(result, bound);
    const std::size_t all = result.count([](const StationResult& s) { return s.fit.has_value(); });
    return on >= least_often && static_cast<double>(on) >= often * static_cast<double>(all);
}

void add_fit(const SurveyResult& result, const StationResult& s, std::vector<std::string>& words) {
    const StationFit& fit = *s.fit;
    for (const landscape::BoundMet& bound : fit.best.on_bound) {
        if (!is_often_met(result, bound)) {
            words.push_back(bound_words(result.study->space, bound));
        }
    }
    if (!fit.best.converged) {
        words.emplace_back("search not converged");
    }
    for (const std::size_t i : fit.held_by) {
        words.push_back("ranges end, on one side, at the constraint " + result.study->constraints[i].text);
    }
    if (s.state == StationState::ok && fit.rms_percent > poor_percent) {
        words.push_back(
            fmt::format("RMS {:.1f} %: the model misses this bowl by more than sensors err", fit.rms_percent));
    }
    std::vector<std::string> unknown;
    const auto names = result.parameter_names();
    for (std::size_t k = 0; k < names.size(); ++k) {
        if (!fit.parameters[k].determined) {
            unknown.push_back(names[k]);
        }
    }
    if (s.is_fitted() && !unknown.empty()) {
        words.push_back("not determined by these readings: " + pave::join(unknown));
    }
    if (s.is_fitted() && fit.local.widened && fit.local.p_value < landscape::contradicted) {
        words.push_back(fmt::format(
            "chi2 {:.0f} of {} degrees of freedom: {} does not explain the residuals of the fit, and the ranges are "
            "{:.1f} times as wide for it",
            fit.local.chi2, fit.local.degrees_of_freedom, noise_words(result), fit.local.widening));
    }
    if (fit.minima > 1) {
        words.push_back(
            fmt::format("{} minima: another set of parameters fits nearly as well or was met on the way", fit.minima));
    }
}

} // namespace

std::string_view verdict(const StationResult& s) {
    const auto passes = s.passes();
    return !passes ? "" : *passes ? "pass" : "fail";
}

std::string why_no_ratio(const StationResult& s) {
    if (!s.has_bowl() || s.ratio()) {
        return "";
    }
    const auto& readings = s.bowl().readings;
    if (readings.back().offset_mm < data::ratio_offset_mm) {
        return fmt::format("no sensor at {:g} mm or beyond", data::ratio_offset_mm);
    }
    return fmt::format("no sensor between the edge of the plate ({:g} mm) and {:g} mm", s.bowl().radius_mm,
                       data::ratio_offset_mm);
}

std::string reason_of(const StationResult& s) {
    if (s.state == StationState::doubtful) {
        return fmt::format("RMS {:.0f} %: the model misses this bowl by far more than sensors err", s.fit->rms_percent);
    }
    if (!s.no_fit) {
        return s.reason;
    }
    return *s.no_fit == NoFit::all_on_bounds
               ? "every parameter ends on a bound: the section of the study cannot be that of this station"
               : fmt::format("RMS {:.0f} %: the model does not describe this bowl", s.fit->rms_percent);
}

std::vector<std::string> remarks_of(const SurveyResult& result, const StationResult& s) {
    std::vector<std::string> words = s.station.remarks;
    if (s.bowls) {
        words.insert(words.end(), s.bowls->remarks.begin(), s.bowls->remarks.end());
        add_drops_left_out(s, result.target.has_value(), words);
    }
    if (s.asphalt && s.asphalt->source != TemperatureSource::measured &&
        !(*s.station.surface_C >= bells_coldest_C && *s.station.surface_C <= bells_hottest_C)) {
        words.push_back(fmt::format("a surface of {:g} C: BELLS3 was made with {:g} to {:g} C, and its {:.0f} C in the "
                                    "asphalt are not to be relied on",
                                    *s.station.surface_C, bells_coldest_C, bells_hottest_C, s.asphalt->celsius));
    }
    std::ranges::copy(reference_remarks(result, s), std::back_inserter(words));
    if (const double stiffest = stiffest_asphalt_MPa(result.curve, result.reference_C.value_or(20.0));
        s.asphalt_at_reference_MPa && *s.asphalt_at_reference_MPa > stiffest) {
        words.push_back(
            fmt::format("{:.0f} MPa at {:g} C are more than any asphalt has (some {:.0f} MPa): a thickness, "
                        "the temperature or the model is wrong",
                        *s.asphalt_at_reference_MPa, result.reference_C.value_or(0.0), stiffest));
    }
    if (s.fit) {
        add_fit(result, s, words);
    }
    return words;
}

namespace {

std::string level_words(const LoadLevel& level) {
    return level.force_kN ? fmt::format("{:g} kN", *level.force_kN) : fmt::format("{:g} kPa", *level.pressure_kPa);
}

// Drops and readings that contradict each other.
void add_drops(const SurveyResult& result, std::vector<std::string>& words) {
    std::size_t left_out = 0;
    std::string first;
    std::size_t disagreeing = 0;
    const StationResult* worst = nullptr;
    data::Disagreement most;
    for (const StationResult& s : result.stations) {
        if (!s.bowls) {
            continue;
        }
        left_out += s.bowls->readings_left_out.size();
        if (first.empty() && !s.bowls->readings_left_out.empty()) {
            const auto& r = s.bowls->readings_left_out[0];
            first = fmt::format("at {} the sensor at {:g} mm in drop {} reads {:.1f} um, {} {:.1f} um", s.station.name,
                                r.offset_mm, r.drop, r.read_um,
                                r.by_levels ? "where its readings under the other loads call for" : "its repeats",
                                r.repeats_um);
        }
        for (const auto& drop : s.bowls->left_out) {
            if (drop.why == data::LeftOut::contradicted) {
                ++left_out;
                first =
                    first.empty() ? fmt::format("at {} drop {}, {}", s.station.name, drop.number, drop.words) : first;
            }
        }
        disagreeing += s.bowls->disagreements.empty() ? 0 : 1;
        for (const data::Disagreement& d : s.bowls->disagreements) {
            if (d.share > most.share) {
                most = d;
                worst = &s;
            }
        }
    }
    if (left_out > 0) {
        words.push_back(fmt::format("{} that other drops contradict {} left out: {}{}.",
                                    pave::counted(left_out, "reading or drop", "readings or drops"),
                                    left_out == 1 ? "is" : "are", first, left_out > 1 ? ", and others" : ""));
    }
    if (worst != nullptr) {
        words.push_back(
            fmt::format("At {} the drops disagree, and nothing tells which is right: most at {}, by {:.0f} % at "
                        "{:g} mm ({:.1f} to {:.1f} um).",
                        pave::counted(disagreeing, "station", "stations"), worst->station.name, 100.0 * most.share,
                        most.offset_mm, most.low_um, most.high_um));
    }
}

// Light deflectometers, whose number is Evd.
void add_light(const SurveyResult& result, std::vector<std::string>& words) {
    std::vector<double> moduli;
    for (const StationResult& s : result.stations) {
        if (s.indices && s.indices->evd_MPa) {
            moduli.push_back(*s.indices->evd_MPa);
        }
    }
    if (!moduli.empty()) {
        const auto [low, high] = std::minmax_element(moduli.begin(), moduli.end());
        words.push_back(
            fmt::format("At {} of {} stations no sensor but the centre is read, as of a light deflectometer: Evd = "
                        "1.5 pressure radius / D0 is {} to {} MPa.",
                        moduli.size(), result.stations.size(), pave::figure(*low), pave::figure(*high)));
    }
}

// The effect of rounding, where it is more than a sensor errs by anyway.
void add_resolution(const SurveyResult& result, std::vector<std::string>& words) {
    std::map<double, std::size_t> steps;
    for (const StationResult& s : result.stations) {
        if (s.bowls) {
            ++steps[s.bowl().readings[0].resolution_um];
        }
    }
    for (const auto& [um, count] : steps) {
        if (um > data::fine_um) {
            const bool is_stated = result.study && result.study->data.states_noise();
            words.push_back(fmt::format(
                "Readings are {}{}: rounding alone is an error of {:.2g} um (one standard deviation), {}.",
                data::resolution_words(um), count < result.stations.size() ? fmt::format(" at {} stations", count) : "",
                um / std::sqrt(12.0),
                is_stated ? "which the noise that the study states has to contain"
                          : "which the ranges take into account"));
        }
    }
}

void add_sensors(const SurveyResult& result, std::vector<std::string>& words) {
    if (result.layout) {
        const BetterLayout& l = *result.layout;
        std::vector<std::string> offsets;
        std::transform(l.offsets_mm.begin(), l.offsets_mm.end(), std::back_inserter(offsets),
                       [](double mm) { return fmt::format("{:g}", mm); });
        words.push_back(fmt::format(
            "With the sensors at {} mm, a usual layout, the model misses these bowls by {:.1f} % instead "
            "of {:.1f} % (median RMS of {} stations, squared misfit {:.2g} times): do the sensors stand where "
            "the file says?",
            pave::join(offsets), l.rms_percent, l.rms_percent_of_file, l.stations, l.misfit_ratio));
    }
    std::vector<std::string> wave;
    for (const SensorResidual& r : result.residuals) {
        if (r.one_sign) {
            wave.push_back(fmt::format("{:+.1f} % at {:g} mm", r.percent, r.offset_mm));
        }
    }
    if (result.section_is_suspect) {
        words.push_back(fmt::format(
            "The model is off with one sign along the road at {} of {} sensors (medians: {}), and no single sensor "
            "explains that: {}.",
            wave.size(), result.residuals.size(), pave::join(wave), suspected_instead(result)));
    }
    if (result.load_residuals.size() > 1) {
        const LoadResidual& low = result.load_residuals.front();
        const LoadResidual& high = result.load_residuals.back();
        if (low.one_sign && high.one_sign && (low.percent > 0.0) != (high.percent > 0.0)) {
            words.push_back(fmt::format(
                "The deflections do not grow with load as the model's do: along the road it is {:+.1f} % off at {:.0f} "
                "kPa and {:+.1f} % at {:.0f} kPa (medians). A layer that {} with load does that: try law = \"{}\".",
                low.percent, low.pressure_kPa, high.percent, high.pressure_kPa,
                low.percent > 0.0 ? "softens" : "stiffens", low.percent > 0.0 ? "bilinear" : "uzan"));
        }
    }
    say(words, trial_words(result));
}

// Bounds that are met so often that the study is in question.
void add_bounds(const SurveyResult& result, std::vector<std::string>& words) {
    if (!result.study) {
        return;
    }
    const std::size_t all = result.count([](const StationResult& s) { return s.fit.has_value(); });
    const auto& axes = result.study->space.axes;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        for (const bool upper : {false, true}) {
            const landscape::BoundMet bound{k, upper};
            if (is_often_met(result, bound)) {
                words.push_back(fmt::format("{} ({}) at {} of {} stations: {} it, or the section is wrong.",
                                            bound_words(result.study->space, bound),
                                            pave::figure(axes[k].physical(upper ? 1.0 : 0.0)),
                                            stations_on(result, bound), all, upper ? "raise" : "lower"));
            }
        }
    }
}

void add_lives(const SurveyResult& result, std::vector<std::string>& words) {
    const StationResult* shortest = nullptr;
    std::size_t needing = 0;
    std::size_t with = 0;
    const auto years = [](const StationResult& s) { return s.fit->lives->first().years.best; };
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted() || !s.fit->lives) {
            continue;
        }
        ++with;
        const Overlay& overlay = s.fit->lives->overlay;
        const auto built = s.fit->lives->has_range ? overlay.reliable : overlay.best;
        needing += !built || *built > 0.0 ? 1 : 0;
        shortest = shortest == nullptr || years(s) < years(*shortest) ? &s : shortest;
    }
    if (shortest == nullptr) {
        return;
    }
    const CriterionLife& c = shortest->fit->lives->first();
    words.push_back(fmt::format(
        "The life ends first at {}: {} years are left{} (\"{}\"). {} of {} stations need an overlay for the design "
        "traffic with {:g} % reliability.",
        shortest->station.name, years_words(c, c.allowable.best),
        std::isnan(c.allowable.low)
            ? ""
            : fmt::format(", {} to {} (95 %)", years_words(c, c.allowable.low), years_words(c, c.allowable.high)),
        c.criterion.name, needing, with, usual_reliability_percent));
}

} // namespace

std::vector<std::string> findings_of(const SurveyResult& result) {
    std::vector<std::string> words;
    say(words, weak_words(result));
    for (std::string doubt : {doubtful_places(result), copied_stations(result)}) {
        if (!doubt.empty()) {
            words.push_back(std::move(doubt));
        }
    }
    add_lives(result, words);
    say(words, rejected_words(result));
    words.insert(words.end(), result.remarks.begin(), result.remarks.end());
    const auto stations = result.stations.size();
    const auto without_place = result.count([](const StationResult& s) { return !s.station.chainage_m; });
    if (without_place > 0) {
        words.push_back(fmt::format("{} of {} stations {} no chainage, and {} at the end.", without_place, stations,
                                    without_place == 1 ? "has" : "have", without_place == 1 ? "stands" : "stand"));
    }
    const auto doubted = [](const StationResult& s) { return s.bowls && !s.bowls->doubt.empty(); };
    if (const auto doubts = result.count(doubted); doubts > 0) {
        const auto& first = *std::find_if(result.stations.begin(), result.stations.end(), doubted);
        words.push_back(fmt::format("At {} of {} stations what is stated is not common, and a slip would explain it; "
                                    "nothing was changed. At {}: {}",
                                    doubts, stations, first.station.name, first.bowls->doubt));
    }
    const auto seated = result.count([](const StationResult& s) {
        return s.bowls && std::any_of(s.bowls->left_out.begin(), s.bowls->left_out.end(),
                                      [](const auto& drop) { return drop.why == data::LeftOut::seating; });
    });
    if (seated > 0) {
        words.push_back(
            fmt::format("At {} of {} stations the first drop seats the plate and is left out.", seated, stations));
    }
    const auto other_levels =
        result.count([](const StationResult& s) { return s.bowls && s.used_levels().size() < s.bowls->levels.size(); });
    const auto together = result.count([](const StationResult& s) { return s.fit && s.fit->levels.size() > 1; });
    if (other_levels > 0) {
        words.push_back(
            result.target
                ? fmt::format(
                      "At {} of {} stations the level nearest to {} is used and drops at other loads are left out.",
                      other_levels, stations, level_words(*result.target))
                : fmt::format("At {} of {} stations the highest load is used and drops at other loads are left out.",
                              other_levels, stations));
    }
    if (together > 0) {
        words.push_back(fmt::format("At {} of {} stations all load levels are fitted together.", together, stations));
    }
    for (const NetworkModel& network : result.networks) {
        words.push_back(
            fmt::format("{} stations were searched by one reduced model of {} full runs (95 % of its errors "
                        "below {:.2g} %); every answer was then fitted by the full model.",
                        network.stations, network.report.full_runs, 100.0 * network.report.error_95));
    }
    if (result.repeatability) {
        words.push_back(fmt::format(
            "Repeated drops repeat a reading within {:.1f} % (one standard deviation){}", 100.0 * *result.repeatability,
            *result.repeatability > noisy_share ? ", which is poor: sensors repeat within 1 to 2 %." : "."));
    }
    say(words, noise_factor_words(result));
    add_light(result, words);
    add_drops(result, words);
    add_resolution(result, words);
    add_sensors(result, words);
    if (result.suspect) {
        const SuspectSensor& s = *result.suspect;
        words.push_back(fmt::format(
            "The sensor at {:g} mm: the model is {:+.0f} % off there{} has one sign at {} of {} stations (chance: "
            "{:.2g}). It may stand elsewhere{}, be out of calibration, or the section be wrong.",
            s.offset_mm, s.model_percent,
            s.is_beside_others ? ". What it is off beyond the sensors on its two sides" : ", which", s.same_sign,
            s.stations, s.p, s.fits_at_mm ? fmt::format(" (at about {:.0f} mm)", *s.fits_at_mm) : ""));
    }
    const auto fitted = result.count([](const StationResult& s) { return s.is_fitted(); });
    const auto names = result.parameter_names();
    for (std::size_t k = 0; k < names.size(); ++k) {
        const auto unknown =
            result.count([&](const StationResult& s) { return s.is_fitted() && !s.fit->parameters[k].determined; });
        if (unknown > 0) {
            words.push_back(
                fmt::format("{} is not determined at {} of {} stations: its value there is not to be used. Hold it at "
                            "a known value; `road` fits the stations together.",
                            names[k], unknown, fitted));
        }
    }
    add_bounds(result, words);
    if (result.floor) {
        const StationResult& s = result.stations[result.floor->station];
        if (const auto said = floor_words(*result.study, s.fit->best, s.fit->local, result.floor->without);
            !said.empty()) {
            words.push_back(fmt::format("At {}: {}", s.station.name, said));
        }
    }
    const auto of_the_hour = result.count(
        [](const StationResult& s) { return s.asphalt && s.asphalt->source == TemperatureSource::bells3_of_the_hour; });
    if (of_the_hour > 0) {
        words.push_back(
            fmt::format("BELLS3 wants the mean air temperature of the day before; at {} stations that of the "
                        "hour stands in (--air-before states it).",
                        of_the_hour));
    }
    const auto beyond_bells = result.count([](const StationResult& s) {
        return s.asphalt && s.asphalt->source != TemperatureSource::measured &&
               !(*s.station.surface_C >= bells_coldest_C && *s.station.surface_C <= bells_hottest_C);
    });
    if (beyond_bells > 0) {
        words.push_back(
            fmt::format("At {} of {} stations the surface is colder than {:g} or hotter than {:g} C, the range "
                        "that BELLS3 was made with: it is not recommended there (AASHTO T 317), and nor is "
                        "what is made of its temperatures.",
                        beyond_bells, stations, bells_coldest_C, bells_hottest_C));
    }
    const auto reference = reference_findings(result);
    words.insert(words.end(), reference.begin(), reference.end());
    return words;
}

} // namespace explore::analysis

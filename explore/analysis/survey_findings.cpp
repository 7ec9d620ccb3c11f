#include "analysis/survey_findings.h"

#include "data/asphalt_temperature.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::analysis {
namespace {

constexpr double poor_percent = 5.0; // beyond this a fit is remarked
constexpr double noisy_share = 0.03; // repeatability that is remarked; sensors repeat within 1 to 2 %

std::string numbers_in_words(const std::vector<int>& numbers) {
    std::vector<std::string> words;
    words.reserve(numbers.size());
    for (const int number : numbers) {
        words.push_back(std::to_string(number));
    }
    return (numbers.size() == 1 ? "drop " : "drops ") + pave::join(words);
}

// "drops 1, 2 left out: ..." for every reason.
void add_drops_left_out(const StationResult& s, std::vector<std::string>& words) {
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
        words.push_back(fmt::format("{} left out: at other loads than {:.0f} kPa (--target-load chooses another; a "
                                    "stress-dependent section is fitted to all)",
                                    numbers_in_words(other_levels), s.bowl().pressure_kPa));
    }
}

void add_fit(const SurveyResult& result, const StationResult& s, std::vector<std::string>& words) {
    const StationFit& fit = *s.fit;
    for (const std::string& bound : bound_words(result.study->space, fit.best.on_bound)) {
        words.push_back(bound);
    }
    if (!fit.best.converged) {
        words.emplace_back("search not converged");
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
    if (s.is_fitted() && fit.local.widened) {
        words.push_back(fmt::format(
            "chi2 {:.0f} of {} degrees of freedom: the stated noise does not explain what the fit "
            "leaves over, and the ranges are {:.1f} times as wide for it",
            fit.local.chi2, fit.local.degrees_of_freedom, std::sqrt(fit.local.chi2 / fit.local.expected_chi2)));
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
        add_drops_left_out(s, words);
    }
    if (s.fit) {
        add_fit(result, s, words);
    }
    return words;
}

std::vector<std::string> findings_of(const SurveyResult& result) {
    std::vector<std::string> words = result.remarks;
    const auto stations = result.stations.size();
    const auto without_place = result.count([](const StationResult& s) { return !s.station.chainage_m; });
    if (without_place > 0) {
        words.push_back(
            fmt::format("{} of {} stations have no chainage: they stand at the end.", without_place, stations));
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
            fmt::format("At {} of {} stations the first drop seats the plate and is left out (--drops chooses "
                        "otherwise).",
                        seated, stations));
    }
    const auto other_levels =
        result.count([](const StationResult& s) { return s.bowls && s.used_levels().size() < s.bowls->levels.size(); });
    const auto together = result.count([](const StationResult& s) { return s.fit && s.fit->levels.size() > 1; });
    if (other_levels > 0) {
        words.push_back(
            fmt::format("At {} of {} stations the highest load is used and drops at other loads are left out "
                        "(--target-load, --drops).",
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
    if (result.suspect) {
        const SuspectSensor& s = *result.suspect;
        words.push_back(fmt::format(
            "The sensor at {:g} mm: the model is {:+.0f} % off there, with one sign at {} of {} stations (chance: "
            "{:.2g}), "
            "unlike its neighbours. It may stand elsewhere{}, be out of calibration, or the section be wrong.",
            s.offset_mm, s.model_percent, s.same_sign, s.stations, s.p,
            s.fits_at_mm ? fmt::format(" (at about {:.0f} mm)", *s.fits_at_mm) : ""));
    }
    const auto fitted = result.count([](const StationResult& s) { return s.is_fitted(); });
    const auto names = result.parameter_names();
    for (std::size_t k = 0; k < names.size(); ++k) {
        const auto unknown =
            result.count([&](const StationResult& s) { return s.is_fitted() && !s.fit->parameters[k].determined; });
        if (unknown > 0) {
            words.push_back(fmt::format("{} is not determined at {} of {} stations: its value there is not to be used.",
                                        names[k], unknown, fitted));
        }
    }
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
    if (result.reference_C) {
        const auto without =
            result.count([](const StationResult& s) { return s.is_fitted() && !s.asphalt_at_reference_MPa; });
        words.push_back(fmt::format("Asphalt moduli at {:g} C by 10^({:g} (T - T_asphalt)), the default slope of "
                                    "FHWA-RD-98-085; mixes have -0.015 to -0.030.{}",
                                    *result.reference_C, data::modulus_slope,
                                    without > 0
                                        ? fmt::format(" Not at {} of {} stations: no asphalt temperature, or the "
                                                      "modulus of the top layer is no parameter.",
                                                      without, fitted)
                                        : ""));
    }
    return words;
}

} // namespace explore::analysis

#include "analysis/survey/survey_temperature.h"

#include "base/text.h"
#include "data/asphalt_temperature.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

void add_temperature(StationResult& s, const SurveyOptions& options, std::optional<double> thickness_mm) {
    const data::FwdStation& station = s.station;
    if (const auto measured = data::measured_asphalt_C(station.asphalt_C, station.surface_C)) {
        s.asphalt = {*measured, TemperatureSource::measured};
        return;
    }
    const bool is_in_date = station.time.empty() && station.date.find(':') != std::string::npos;
    const std::string& clock = is_in_date ? station.date : station.time;
    const auto hour = data::hour_of_day(clock);
    if (station.surface_C && !hour && !data::is_nil(clock)) {
        s.station.remarks.push_back(
            fmt::format("\"{}\" is no time of day: no asphalt temperature is made of the surface's", clock));
    }
    const auto air = options.air_of_day_before_C ? options.air_of_day_before_C : station.air_C;
    if (station.surface_C && hour && air && thickness_mm) {
        s.asphalt = {data::bells3(*station.surface_C, *air, *hour, *thickness_mm / 2.0),
                     options.air_of_day_before_C ? TemperatureSource::bells3 : TemperatureSource::bells3_of_the_hour};
    }
}

std::string modulus_words(data::TemperatureCurve curve) {
    if (curve == data::TemperatureCurve::irc) {
        return "(1 - 0.238 ln T) / (1 - 0.238 ln T_asphalt) of IRC:115-2014";
    }
    return fmt::format("10^({:g} (T - T_asphalt)), the default slope of FHWA-RD-98-085; mixes have -0.015 to -0.030",
                       data::modulus_slope);
}

} // namespace

void take_to_reference(StationResult& s, const SurveyOptions& options, std::optional<double> asphalt_mm) {
    add_temperature(s, options, asphalt_mm);
    if (!options.reference_C || !s.asphalt) {
        return;
    }
    data::WhereMeasured where{.asphalt_C = s.asphalt->celsius,
                              .asphalt_mm = asphalt_mm,
                              .latitude_deg = s.station.latitude ? s.station.latitude : options.latitude_deg};
    if (const auto d900 = s.bowl().at(900.0)) {
        constexpr double force_of_curves_kN = 40.0;
        where.d900_um = *d900 * force_of_curves_kN / s.bowl().force_kN();
    }
    s.at_reference = data::indices_at(options.curve, *options.reference_C, where, *s.indices);
}

void take_moduli_to_reference(SurveyResult& result) {
    if (!result.study || !result.reference_C) {
        return;
    }
    const auto names = result.parameter_names();
    const auto at = std::find(names.begin(), names.end(), result.study->model.layers[0].name + ".modulus_MPa");
    const auto asphalt = static_cast<std::size_t>(at - names.begin());
    for (StationResult& s : result.stations) {
        if (asphalt < names.size() && s.asphalt && s.is_fitted() && s.fit->parameters[asphalt].determined) {
            if (const auto factor = data::modulus_factor_by(result.curve, s.asphalt->celsius, *result.reference_C)) {
                s.asphalt_at_reference_MPa = s.fit->parameters[asphalt].value * *factor;
            }
        }
    }
}

double stiffest_asphalt_MPa(data::TemperatureCurve curve, double celsius) {
    constexpr double usual_C = 20.0;
    constexpr double there_MPa = 25000.0;
    return there_MPa * std::min(1.0, data::modulus_factor_by(curve, usual_C, celsius).value_or(1.0));
}

std::vector<std::string> reference_remarks(const SurveyResult& result, const StationResult& s) {
    if (!s.at_reference || s.at_reference->out_of_range.empty()) {
        return {};
    }
    return {fmt::format("beyond what {} was made for: {}", data::words_of(result.curve).source,
                        pave::join(s.at_reference->out_of_range))};
}

std::vector<std::string> reference_findings(const SurveyResult& result) {
    if (!result.reference_C) {
        return {};
    }
    std::vector<std::string> found;
    if (result.study) {
        const auto without =
            result.count([](const StationResult& s) { return s.is_fitted() && !s.asphalt_at_reference_MPa; });
        found.push_back(
            fmt::format("Asphalt moduli at {:g} C by {}.{}", *result.reference_C, modulus_words(result.curve),
                        without > 0 ? fmt::format(" Not at {} of {} stations: no asphalt temperature, or the "
                                                  "modulus of the top layer is no parameter or not determined.",
                                                  without, result.counts().fitted)
                                    : ""));
    }
    if (result.curve == data::TemperatureCurve::irc) {
        return found;
    }
    const auto bowls = result.count([](const StationResult& s) { return s.has_bowl(); });
    const auto taken = result.count([](const StationResult& s) { return s.at_reference && s.at_reference->d0_um; });
    std::string why;
    for (const StationResult& s : result.stations) {
        if (s.has_bowl() && !(s.at_reference && s.at_reference->d0_um)) {
            why = s.at_reference ? s.at_reference->why_not : "the temperature of the asphalt is not known";
            break;
        }
    }
    found.push_back(fmt::format("Deflections and indices at {:g} C by {} at {} of {} stations with a bowl.{}",
                                *result.reference_C, data::words_of(result.curve).source, taken, bowls,
                                why.empty() ? "" : " Not at the others: " + why + "."));
    const auto beyond =
        result.count([](const StationResult& s) { return s.at_reference && !s.at_reference->out_of_range.empty(); });
    if (beyond > 0) {
        found.push_back(fmt::format("At {} of {} stations {} goes beyond what it was made for; their remarks say how.",
                                    beyond, bowls, data::words_of(result.curve).source));
    }
    return found;
}

} // namespace explore::analysis

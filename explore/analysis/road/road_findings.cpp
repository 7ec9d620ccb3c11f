#include "analysis/road/road_findings.h"

#include "analysis/common/floor.h"
#include "analysis/common/say.h"
#include "analysis/survey/weak_stations.h"

#include "base/text.h"
#include "inference/quantiles.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using pave::counted;
using pave::figure;
using pave::p_words;

constexpr double poorly_conditioned = 1e4;

std::string percent(double share) {
    return fmt::format("{:.{}f} %", 100.0 * share, share < 0.0995 ? 1 : 0);
}

std::string common_words(const RoadResult& result, const CommonParameter& p) {
    std::string text =
        p.range.determined
            ? fmt::format("{} = {}, 95 % range {} to {}, from {}", common_name(result, p), figure(p.range.value),
                          figure(p.range.low), figure(p.range.high), counted(p.stations, "station", "stations"))
            : fmt::format("{} is not determined even by {} together ({}, range {} to {})", common_name(result, p),
                          counted(p.stations, "station", "stations"), figure(p.range.value), figure(p.range.low),
                          figure(p.range.high));
    text += fmt::format(
        ": {} of its box, where the median station by itself leaves {} (its standard error is {:.1f} times as "
        "large)",
        percent(p.width), percent(p.alone_width), p.narrower);
    if (p.range.determined && 2 * p.alone_determined < p.stations) {
        text += fmt::format("; unique together, and alone at {} of {}", p.alone_determined,
                            counted(p.stations, "station", "stations"));
    }
    return text + ".";
}

// The combination of the road's common parameters that is known least.
std::string weakest_words(const RoadResult& result) {
    std::string text;
    std::size_t next = 0;
    for (const CommonParameter& p : result.common) {
        if (p.section) {
            continue;
        }
        const double part = result.weakest[next++];
        if (std::abs(part) >= 0.1) {
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", result.survey.study->space.axes[p.axis].name,
                                part > 0.0 ? "up" : "down");
        }
    }
    return text;
}

// Of sensors that the prediction misses: the residuals of the fit at them anyway, and what the load adds. Near ones
// tell of the top, far ones of what lies deep.
std::string missed_words(const WithheldLevel& level) {
    std::string missed;
    std::string fitted;
    std::string by_load;
    std::string anyway;
    for (const auto& s : level.sensors) {
        const auto add = [&](std::string& text, const std::string& words) {
            text += fmt::format("{}{:g} mm {}", text.empty() ? "" : ", ", s.offset_mm, words);
        };
        if (s.p_familywise < road_familywise) {
            add(missed, fmt::format("{:+.1f} % +- {:.1f}", s.mean_percent, inference::two_sided_95 * s.error_percent));
            add(fitted, fmt::format("{:+.1f} %", s.fitted_percent));
            if (s.is_off_at_all_levels) {
                anyway += fmt::format("{}{:g}", anyway.empty() ? "" : ", ", s.offset_mm);
            }
        }
        if (s.load_p_familywise < road_familywise) {
            add(by_load,
                fmt::format("{:+.1f} % +- {:.1f}", s.load_percent, inference::two_sided_95 * s.load_error_percent));
        }
    }
    std::string text =
        missed.empty()
            ? " No sensor stands out."
            : fmt::format(" Measured over predicted at {}; at the nearest level that was fitted the same sensors are "
                          "off by {}{}.",
                          missed, fitted,
                          anyway.empty() ? ""
                                         : ", and at " + anyway +
                                               " mm in the same direction at every level, which is no effect of the "
                                               "load");
    if (by_load.empty()) {
        return text + " From that level to this one no sensor changes otherwise than predicted.";
    }
    return text + fmt::format(" From that level {} to this one the readings change against the model at {}. Where they "
                              "rise, the pavement {}: near the plate the upper layers, far from it the subgrade.",
                              level.step < 0.0 ? "down" : "up", by_load,
                              level.step < 0.0 ? "hardens with load more, or softens less, than the model"
                                               : "softens with load more, or hardens less, than the model");
}

std::string withheld_words(const WithheldLevel& level) {
    return fmt::format(
        "The level that was withheld is predicted within {:.1f} % (root mean square of {} readings at {} "
        "stations), where noise and the ranges make {:.1f} %: chi2 = {}, {}.{}",
        level.rms_percent, level.readings, level.stations, level.noise_percent, figure(level.chi2),
        p_words(level.p_value), missed_words(level));
}

// The effect that the model lacks at all stations.
std::string diagnosis_words(const RoadDiagnosis& d) {
    const auto words = [](const RoadEffect& e) {
        return fmt::format("{} ({}; size {} to {}, chi2 = {}, {})", e.name, e.words, figure(e.low), figure(e.high),
                           figure(*e.chi2), p_words(e.p_value));
    };
    const std::string before = fmt::format("chi2 = {} with {:.0f} degrees of freedom", figure(d.chi2), d.dof);
    std::vector<std::string> causes;
    for (const std::size_t cause : d.causes) {
        causes.push_back(words(d.effects[cause]));
    }
    const std::string noise =
        d.decision.is_noise_possible()
            ? fmt::format(" Noise larger than stated is possible too (probability {}).", percent(d.decision.of_noise))
            : "";
    switch (d.decision.verdict) {
    case diagnose::Verdict::adequate:
        return d.decision.as_stated || d.decision.noise_factor <= 1.0
                   ? "ADEQUATE: nothing that all stations could lack alike is seen in these readings."
                   : fmt::format("ADEQUATE, but for the noise, which is some {} times as large as stated: nothing else "
                                 "that all stations could lack alike is seen ({}).",
                                 figure(d.decision.noise_factor, 2), before);
    case diagnose::Verdict::cause_named:
        return fmt::format("CAUSE NAMED: all stations lack {}; without it {}.{}", causes[0], before,
                           d.decision.leaves_more_than_noise
                               ? " With it a little more than the stated noise is left, as one right answer in twenty "
                                 "leaves; nothing else that was tried comes near."
                               : "");
    case diagnose::Verdict::ambiguous:
        if (causes.size() > 1) {
            return fmt::format("AMBIGUOUS: all stations lack something ({}); the readings do not tell {}.{}", before,
                               pave::join(causes, " from "), noise);
        }
        return fmt::format("AMBIGUOUS: all stations lack something ({}); it may be {}{}.{}", before, causes[0],
                           d.decision.leaves_more_than_noise ? ", which leaves more than noise"
                           : d.effects[0].ends_range ? ", whose range of sizes reaches the end of what is possible"
                                                     : "",
                           noise);
    default: break;
    }
    if (d.effects.empty() || !d.effects[0].chi2) {
        return fmt::format(
            "UNEXPLAINED: the model misses the readings ({}, {}), and nothing that all stations could lack "
            "alike shows.",
            before, p_words(d.p_value));
    }
    if (!d.decision.leaves_more_than_noise) {
        return fmt::format("UNEXPLAINED: all stations may lack {}, or the noise is larger than stated ({}).",
                           words(d.effects[0]), before);
    }
    return fmt::format(
        "UNEXPLAINED: all stations lack something ({}), and no effect of the catalogue leaves noise only; what "
        "comes nearest is {}. Noise alone would show as much of some effect with {}.",
        before, words(d.effects[0]), p_words(d.effects[0].p_familywise));
}

// Whether an effect that it names, or that comes nearest, is a subgrade that is softer above than below.
bool says_stiffer_below(const RoadDiagnosis& d) {
    const auto is_so = [](const RoadEffect& e) {
        return e.chi2 && e.size > 0.0 && (e.name == "subgrade-depth-gradient" || e.name == "weak-subgrade-top");
    };
    const bool is_nearest =
        d.decision.verdict == diagnose::Verdict::unexplained && !d.effects.empty() && is_so(d.effects[0]);
    return is_nearest || std::ranges::any_of(d.causes, [&](std::size_t cause) { return is_so(d.effects[cause]); });
}

} // namespace

std::string common_name(const RoadResult& result, const CommonParameter& p) {
    const std::string& name = result.survey.study->space.axes[p.axis].name;
    if (!p.section) {
        return name;
    }
    const RoadSection& section = result.survey.sections[*p.section];
    const auto chainage = [&](std::size_t i) { return *result.survey.stations[i].station.chainage_m; };
    return fmt::format("{} at {:g} to {:g} m", name, chainage(section.first), chainage(section.last)) +
           (section.lane.empty() ? "" : " of lane " + section.lane);
}

std::string outlier_words(const RoadResult& result, const RoadOutlier& o) {
    const std::string name = result.survey.study->space.axes[o.axis].name;
    switch (o.cause) {
    case OutlierCause::sensor:
        return fmt::format("without the sensor at {:g} mm it fits ({}): the model is {:+.1f} % off there", o.offset_mm,
                           p_words(o.p_explained), o.model_percent);
    case OutlierCause::common:
        return fmt::format("with common parameters of its own it fits ({}): above all {} = {}, {} elsewhere",
                           p_words(o.p_explained), name, figure(o.there), figure(o.typical));
    case OutlierCause::unlike:
        return fmt::format("no single sensor and no common parameters of its own explain it; {} = {} is far from that "
                           "of its neighbours ({}): another thickness or construction, or the floor",
                           name, figure(o.there), figure(o.typical));
    case OutlierCause::not_explained: break;
    }
    return "no single sensor and no common parameters of its own explain it: another thickness, construction or depth "
           "of the floor, or several readings are wrong";
}

std::string course_length_words(double length_m, double stretch_m) {
    return length_m > stretch_m ? fmt::format("more than the length of the road, {:.0f} m", stretch_m)
                                : fmt::format("some {} m", figure(length_m, 2));
}

std::vector<std::string> findings_of(const RoadResult& result) {
    std::vector<std::string> words;
    say(words, weak_words(result.survey));
    for (const CommonParameter& p : result.common) {
        words.push_back(common_words(result, p));
    }
    if (result.stations.empty()) {
        words.emplace_back("No station could be fitted.");
        return words;
    }
    if (result.weakest.size() > 1 && result.condition > poorly_conditioned) {
        words.push_back(fmt::format(
            "The common parameters are known less well together than each by itself: along {} by {} of the box (one "
            "standard deviation), {:.0f} times worse than along the best known combination. Hold one of them at a "
            "known "
            "value.",
            weakest_words(result), percent(result.weakest_sd), std::sqrt(result.condition)));
    }
    words.push_back(
        result.widened
            ? fmt::format(
                  "The model misses the readings by {:.1f} times their noise (chi2 = {} with {:.0f} degrees of "
                  "freedom, {}): ranges are wider by that much, and an error that the model makes at "
                  "every station shifts the common parameters by more than they say. `road --diagnose` looks for "
                  "what all stations lack.",
                  result.noise_factor(), figure(result.chi2), result.dof, p_words(result.p_value))
            : fmt::format("The fit is consistent with the noise of the readings: chi2 = {} with {:.0f} degrees of "
                          "freedom, {}.",
                          figure(result.chi2), result.dof, p_words(result.p_value)));
    if (result.outliers.empty() && result.stations.size() > 1) {
        words.push_back(fmt::format("No station stands out (5 % over all {}).",
                                    counted(result.stations.size(), "station", "stations")));
    }
    for (const RoadOutlier& o : result.outliers) {
        const RoadStation& s = result.stations[o.station];
        words.push_back(fmt::format("{} does not belong to this road (chi2 = {} where {:.0f} is expected, {} "
                                    "over all stations) and is left out of what is common: {}.",
                                    result.survey.stations[s.station].station.name, figure(s.chi2), s.dof,
                                    p_words(s.p_familywise), outlier_words(result, o)));
    }
    if (result.conflict_dof > 0.0) {
        words.push_back(fmt::format(
            "{}: with common parameters of their own at every station chi2 falls by {} for {:.0f} more parameters, {}.",
            result.conflict_p < 0.05
                ? "Stations by themselves contradict the road, so that what is common here is not the same everywhere, "
                  "or the model errs in a way that differs along the road"
                : "Stations by themselves do not contradict the road",
            figure(result.conflict_chi2), result.conflict_dof, p_words(result.conflict_p)));
    }
    for (const RoadCourse& c : result.courses) {
        if (c.p_none < road_familywise) {
            const auto chainage = [&](std::size_t station) {
                return result.survey.stations[result.stations[station].station].station.chainage_m.value_or(0.0);
            };
            words.push_back(
                fmt::format("{}{} has a course along the road: stations are similar over {} ({} that they are no more "
                            "similar than any two). With it the range of the median station is {:.1f} times narrower.",
                            result.survey.study->space.axes[c.axis].name, c.lane.empty() ? "" : " of lane " + c.lane,
                            course_length_words(c.length_m, chainage(c.stations.back()) - chainage(c.stations.front())),
                            p_words(c.p_none), c.narrower));
        }
    }
    if (result.diagnosis) {
        words.push_back(diagnosis_words(*result.diagnosis));
        if (says_stiffer_below(*result.diagnosis) && result.survey.study->model.half_space) {
            words.push_back(rock_words(*result.survey.study));
        }
    }
    if (result.withheld) {
        words.push_back(withheld_words(*result.withheld));
    }
    if (!result.converged) {
        words.push_back(fmt::format("The search over all stations did not converge: {}. Leave out stations that "
                                    "stand out, or hold a common parameter.",
                                    result.ended));
    }
    words.emplace_back("Ranges hold for errors that are new at every reading. What is wrong in the same way at every "
                       "station, as a sensor's calibration or a thickness, is not in them.");
    return words;
}

} // namespace explore::analysis

#include "analysis/survey/survey_findings.h"
#include "base/text.h"
#include "report/lives.h"
#include "report/survey.h"
#include "report/table.h"
#include "report/text.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

using analysis::StationResult;
using analysis::StationState;
using analysis::SurveyResult;
using pave::counted;
using pave::figure;

std::string with_range(const analysis::ParameterRange& p) {
    return p.determined ? fmt::format("{} ({} to {})", figure(p.value), figure(p.low), figure(p.high))
                        : fmt::format("{} (?)", figure(p.value));
}

// Where its drops stand: " (north.f25, line 12)".
std::string place_of(const data::FwdStation& s) {
    return s.line == 0 ? "" : fmt::format(" ({}, line {})", s.file.substr(s.file.find_last_of('/') + 1), s.line);
}

std::string station_table(const SurveyResult& result) {
    const bool lanes = result.count([](const StationResult& s) { return !s.station.lane.empty(); }) > 0;
    const bool profiles = result.count([](const StationResult& s) { return !s.station.profile.empty(); }) > 0;
    std::vector<std::string> header{"station"};
    if (profiles) {
        header.emplace_back("profile");
    }
    if (lanes) {
        header.emplace_back("lane");
    }
    const bool has_bowls = result.common_pressure_kPa > 0.0;
    for (const std::string& name :
         {std::string("chainage m"), std::string("drops"), std::string("pressure kPa"),
          has_bowls ? fmt::format("D0 um at {} kPa", figure(result.common_pressure_kPa)) : "D0 um",
          std::string("D250/D0"), std::string("ratio")}) {
        header.push_back(name);
    }
    const auto names = result.parameter_names();
    header.insert(header.end(), names.begin(), names.end());
    if (result.study) {
        header.insert(header.end(), {"misfit", "RMS %", "starts"});
    }
    header.emplace_back("status");
    Table table(header);
    for (const StationResult& s : result.stations) {
        std::vector<std::string> cells{s.station.name};
        if (profiles) {
            cells.push_back(s.station.profile);
        }
        if (lanes) {
            cells.push_back(s.station.lane);
        }
        cells.push_back(s.station.chainage_m ? fmt::format("{:g}", *s.station.chainage_m) : "");
        if (s.has_bowl()) {
            const bool is_interpolated = !s.bowl().has_sensor_at(data::ratio_offset_mm);
            std::size_t drops = 0;
            for (const std::size_t level : s.used_levels()) {
                drops += s.bowls->levels[level].drops.size();
            }
            cells.push_back(fmt::format("{}/{}", drops, s.station.drops.size()));
            cells.push_back(figure(s.bowl().pressure_kPa));
            cells.push_back(figure(result.d0_at_common(s)));
            cells.push_back(s.ratio() ? fmt::format("{}{:.3f}", is_interpolated ? "~" : "", *s.ratio()) : "");
            cells.emplace_back(analysis::verdict(s));
            if (s.is_fitted()) {
                for (const auto& p : s.fit->parameters) {
                    cells.push_back(with_range(p));
                }
            } else {
                cells.resize(cells.size() + names.size());
            }
            if (s.fit) {
                cells.push_back(figure(s.fit->best.evaluation.misfit));
                cells.push_back(fmt::format("{:.2f}", s.fit->rms_percent));
                cells.push_back(fmt::format("{}/{}", s.fit->best.members.size(), s.fit->starts));
            }
        }
        cells.resize(header.size() - 1);
        const std::string reason = analysis::reason_of(s);
        cells.push_back(reason.empty() ? "ok"
                                       : fmt::format("{}: {}{}", to_string(s.state), reason,
                                                     s.state == StationState::rejected ? place_of(s.station) : ""));
        table.add(std::move(cells));
    }
    return table.text();
}

// Remarks, each once, with the stations that it holds for.
std::string remark_list(const SurveyResult& result) {
    constexpr std::size_t shown = 30;
    std::vector<std::pair<std::string, std::vector<std::string>>> remarks;
    for (const StationResult& s : result.stations) {
        auto list = analysis::remarks_of(result, s);
        if (const std::string why = analysis::why_no_ratio(s); !why.empty()) {
            list.push_back("no deflection ratio: " + why);
        }
        for (std::string& words : list) {
            const auto same =
                std::find_if(remarks.begin(), remarks.end(), [&](const auto& r) { return r.first == words; });
            if (same == remarks.end()) {
                remarks.emplace_back(std::move(words), std::vector<std::string>{s.station.name});
            } else {
                same->second.push_back(s.station.name);
            }
        }
    }
    std::string text;
    for (std::size_t i = 0; i < std::min(shown, remarks.size()); ++i) {
        const auto& [words, stations] = remarks[i];
        text += stations.size() > 3 ? fmt::format("  {}: {}\n", counted(stations.size(), "station", "stations"), words)
                                    : fmt::format("  {}: {}\n", pave::join(stations), words);
    }
    return remarks.size() > shown ? text + fmt::format("  ... {} more in survey.json\n", remarks.size() - shown) : text;
}

// One mark a station, or a few stations, along the road: the verdicts, and a line for each quantity.
std::string strip_chart(const SurveyResult& result, std::size_t begin, std::size_t end) {
    constexpr std::size_t width = 100;
    const std::size_t group = (end - begin + width - 1) / width;
    // The median of those of each group that have a value.
    const auto line = [&](const std::string& name, const std::string& unit, bool is_log,
                          const std::function<std::optional<double>(const StationResult&)>& value_of) {
        std::vector<double> marks;
        double low = INFINITY;
        double high = -INFINITY;
        for (std::size_t i = begin; i < end; i += group) {
            std::vector<double> values;
            for (std::size_t k = i; k < std::min(end, i + group); ++k) {
                if (const auto value = value_of(result.stations[k])) {
                    values.push_back(*value);
                }
            }
            const double mark = values.empty() ? NAN : data::median(values);
            low = std::fmin(low, mark);
            high = std::fmax(high, mark);
            marks.push_back(is_log ? std::log(mark) : mark);
        }
        return std::vector<std::string>{
            name, sparkline(marks),
            low <= high ? fmt::format("{} to {}{}", figure(low), figure(high), unit.empty() ? "" : " " + unit) : ""};
    };
    std::string verdicts;
    for (std::size_t i = begin; i < end; i += group) {
        const auto any = [&](const auto& is) {
            return std::any_of(result.stations.begin() + static_cast<std::ptrdiff_t>(i),
                               result.stations.begin() + static_cast<std::ptrdiff_t>(std::min(end, i + group)), is);
        };
        verdicts += any([](const StationResult& s) { return analysis::verdict(s) == "fail"; })   ? 'x'
                    : any([](const StationResult& s) { return analysis::verdict(s) == "pass"; }) ? '.'
                                                                                                 : '?';
    }
    Table table({"", fmt::format("one mark: {}", counted(group, "station", "stations")), "lowest to highest"});
    table.add({"ratio", verdicts, ". pass, x fail, ? none"});
    table.add(line("D250/D0", "", false, [](const StationResult& s) { return s.ratio(); }));
    table.add(
        line(fmt::format("D0 at {} kPa", figure(result.common_pressure_kPa)), "um", false, [&](const StationResult& s) {
            return s.has_bowl() ? std::optional(result.d0_at_common(s)) : std::nullopt;
        }));
    for (std::size_t k = 0; result.study && k < result.study->space.axes.size(); ++k) {
        const problem::Axis& axis = result.study->space.axes[k];
        table.add(line(axis.name, "", axis.scale == problem::Scale::log, [&](const StationResult& s) {
            return s.is_fitted() ? std::optional(s.fit->parameters[k].value) : std::nullopt;
        }));
    }
    return table.text();
}

// A chart for every profile and lane.
std::string strip_charts(const SurveyResult& result) {
    std::string text;
    for (std::size_t begin = 0; begin < result.stations.size();) {
        const auto& first = result.stations[begin].station;
        const std::size_t end = result.end_of_lane(begin);
        const bool is_whole = begin == 0 && end == result.stations.size();
        std::vector<std::string> names{first.profile, first.lane.empty() ? "" : "lane " + first.lane};
        names.erase(std::remove(names.begin(), names.end(), ""), names.end());
        text += (is_whole || names.empty() ? "" : "  " + pave::join(names) + "\n") + strip_chart(result, begin, end);
        begin = end;
    }
    return text;
}

std::string index_table(const SurveyResult& result) {
    std::vector<std::string> header{
        "station", "D0 um", "SCI um", "BDI um", "BCI um", "AREA mm", "radius of curvature m", "E0 MPa", "asphalt C"};
    const bool has_indices = result.reference_C && result.curve != data::TemperatureCurve::irc;
    if (has_indices) {
        for (const char* index : {"D0", "SCI", "BDI", "BCI"}) {
            header.push_back(fmt::format("{} um at {:g} C", index, *result.reference_C));
        }
    }
    if (result.reference_C && result.study) {
        header.push_back(fmt::format("asphalt MPa at {:g} C", *result.reference_C));
    }
    Table table(header);
    const auto shown = [](const std::optional<double>& value) { return value ? figure(*value) : ""; };
    for (const StationResult& s : result.stations) {
        if (!s.has_bowl()) {
            continue;
        }
        const auto& i = *s.indices;
        std::vector<std::string> cells{s.station.name,
                                       figure(i.d0_um),
                                       shown(i.sci_um),
                                       shown(i.bdi_um),
                                       shown(i.bci_um),
                                       shown(i.area_mm),
                                       shown(i.curvature_radius_m),
                                       figure(i.surface_moduli[0].modulus_MPa),
                                       s.asphalt ? fmt::format("{:.1f}", s.asphalt->celsius) : ""};
        if (has_indices) {
            const auto at = s.at_reference.value_or(data::IndicesAtReference{});
            cells.insert(cells.end(), {shown(at.d0_um), shown(at.sci_um), shown(at.bdi_um), shown(at.bci_um)});
        }
        if (result.reference_C && result.study) {
            cells.push_back(shown(s.asphalt_at_reference_MPa));
        }
        table.add(std::move(cells));
    }
    return table.text();
}

std::string residual_table(const SurveyResult& result) {
    Table table({"sensor mm", "model over reading %", "model is above at", ""});
    for (const auto& r : result.residuals) {
        table.add({fmt::format("{:g}", r.offset_mm), fmt::format("{:+.1f}", r.percent),
                   fmt::format("{} of {}", r.above, r.stations), r.one_sign ? "one sign" : ""});
    }
    return table.text();
}

std::string load_table(const SurveyResult& result) {
    Table table({"load kPa", "model over reading %", "model is above at", ""});
    for (const auto& r : result.load_residuals) {
        table.add({fmt::format("{:.0f}", r.pressure_kPa), fmt::format("{:+.1f}", r.percent),
                   fmt::format("{} of {}", r.above, r.stations), r.one_sign ? "one sign" : ""});
    }
    return table.text();
}

std::string output_table(const SurveyResult& result) {
    const auto outputs = result.outputs();
    std::vector<std::string> header{"station"};
    for (const auto& output : outputs) {
        header.push_back(fmt::format("{} [{}]", output.output, output.unit.name));
    }
    Table table(header);
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        std::vector<std::string> cells{s.station.name};
        for (std::size_t o = 0; o < s.fit->outputs.size(); ++o) {
            const auto& p = s.fit->outputs[o];
            const auto shown = [&](double si) { return figure(outputs[o].in_unit(si)); };
            cells.push_back(p.determined ? fmt::format("{} ({} to {})", shown(p.value), shown(p.low), shown(p.high))
                                         : shown(p.value) + " (?)");
        }
        if (s.fit->outputs.empty()) {
            cells.push_back("no answer: " + s.fit->why_no_outputs);
        }
        cells.resize(std::max(cells.size(), header.size()));
        table.add(std::move(cells));
    }
    return table.text();
}

std::string section_table(const SurveyResult& result) {
    const auto names = result.parameter_names();
    const auto any = [&](const auto& text_of) {
        return std::any_of(result.sections.begin(), result.sections.end(),
                           [&](const auto& section) { return !text_of(section).empty(); });
    };
    const bool profiles = any([](const auto& section) { return section.profile; });
    const bool lanes = any([](const auto& section) { return section.lane; });
    std::vector<std::string> header{"from m", "to m", "stations", "D0 um"};
    if (lanes) {
        header.insert(header.begin(), "lane");
    }
    if (profiles) {
        header.insert(header.begin(), "profile");
    }
    header.insert(header.end(), names.begin(), names.end());
    Table table(header);
    const auto words = [](const analysis::Percentiles& p) {
        return p.stations == 0 ? "" : fmt::format("{} / {} / {}", figure(p.p15), figure(p.p50), figure(p.p85));
    };
    // A value that is not determined is in no percentile.
    const auto determined = [&](const analysis::Percentiles& p, std::size_t fitted) {
        return p.stations == fitted ? words(p)
               : p.stations == 0    ? fmt::format("? (0 of {})", fitted)
                                    : fmt::format("{} ({} of {})", words(p), p.stations, fitted);
    };
    for (const auto& section : result.sections) {
        std::vector<std::string> cells{fmt::format("{:g}", *result.stations[section.first].station.chainage_m),
                                       fmt::format("{:g}", *result.stations[section.last].station.chainage_m),
                                       std::to_string(section.d0_um.stations), words(section.d0_um)};
        if (lanes) {
            cells.insert(cells.begin(), section.lane);
        }
        if (profiles) {
            cells.insert(cells.begin(), section.profile);
        }
        for (const auto& p : section.parameters) {
            cells.push_back(determined(p, section.fitted));
        }
        table.add(std::move(cells));
    }
    return table.text();
}

} // namespace

std::string survey_text(const SurveyResult& result) {
    const analysis::SurveyCounts counts = result.counts();
    std::string text = result.study ? study_summary(*result.study) + "\n" : "";
    text += fmt::format(
        "{}: {} pass, {} fail, {}{} rejected", counted(result.stations.size(), "station", "stations"), counts.pass,
        counts.fail, counts.no_ratio > 0 ? fmt::format("{} without a ratio, ", counts.no_ratio) : "", counts.rejected);
    if (result.study) {
        text += fmt::format(
            "; {} back-calculated{}, {} failed{}\n  {} in {}", counts.fitted,
            counts.doubtful > 0 ? fmt::format(" ({} doubtful)", counts.doubtful) : "", counts.failed,
            counts.no_fit > 0 ? fmt::format(", {} that the model does not describe", counts.no_fit) : "",
            counted(static_cast<std::size_t>(result.computed), "run", "runs"), run::duration_words(result.seconds));
        if (result.stations_computed > 0) {
            text += fmt::format(" ({:.1f} stations per minute)", 60.0 * result.stations_computed / result.seconds);
        }
    }
    text += fmt::format("\n\n  {}\n  pass: {:g} or more; ~: D250 {}\n  deflections: um, positive down; pressure: under "
                        "the plate, median of the drops used\n",
                        ratio_words, data::deflection_ratio_limit, interpolation_words);
    if (result.study) {
        text +=
            fmt::format("  misfit: {} residuals; RMS: of the relative differences of the deflections; starts: searches "
                        "that ended in the best minimum\n  parameters: best fit (95 % range by its curvature; ?: not "
                        "determined by these readings)\n",
                        to_string(result.study->data.misfit));
    }
    text += "\n" + station_table(result);
    if (!result.outputs().empty()) {
        text += "\nOutputs at the best fits (95 % ranges by their derivatives and the ranges of the parameters)\n" +
                output_table(result);
    }
    if (result.has_lives()) {
        text += "\nLife and overlay at the best fits (95 % ranges to first order)\n" + life_table(result);
        if (!result.sections.empty()) {
            text += "\nLife and overlay of the homogeneous sections\n" + section_life_table(result);
        }
    }
    if (const std::string remarks = remark_list(result); !remarks.empty()) {
        text += "\nRemarks\n" + remarks;
    }
    if (counts.rejected < result.stations.size()) {
        text += "\nAlong the road\n" + strip_charts(result);
    }
    if (std::any_of(result.residuals.begin(), result.residuals.end(), [](const auto& r) { return r.one_sign; })) {
        text += "\nResiduals of the model at the sensors (median over the stations)\n" + residual_table(result);
    }
    if (std::any_of(result.load_residuals.begin(), result.load_residuals.end(),
                    [](const auto& r) { return r.one_sign; })) {
        text += "\nResiduals at the loads (median over the stations)\n" + load_table(result);
    }
    if (result.normalise || result.reference_C) {
        text += fmt::format("\nAt {}\n{}",
                            result.normalise ? result.normalise->pressure_kPa
                                                   ? fmt::format("{:g} kPa", *result.normalise->pressure_kPa)
                                                   : fmt::format("{:g} kN", *result.normalise->force_kN)
                                             : figure(result.common_pressure_kPa) + " kPa",
                            index_table(result));
    }
    if (result.sections.size() > 1 ||
        (!result.sections.empty() && result.sections[0].d0_um.stations >= analysis::section_stations)) {
        text += "\nHomogeneous sections (cumulative differences of ln D0); 15 / 50 / 85 % of the stations do not "
                "exceed (of "
                "parameters: of those that determine them)\n" +
                section_table(result);
    }
    if (const auto findings = analysis::findings_of(result); !findings.empty()) {
        text += "\nFindings\n";
        for (const std::string& words : findings) {
            text += "  " + words + "\n";
        }
    }
    return text;
}

} // namespace explore::report

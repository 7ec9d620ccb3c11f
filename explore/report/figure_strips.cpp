// Strip charts along a road of `survey` and `road`.
#include "data/median.h"
#include "report/figure_key.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::report {
namespace {

// One station of a strip.
struct Value {
    double value = none, low = none, high = none; // a range where there is one
    bool determined = true;
};
struct Strip {
    std::string quantity, unit, label{}; // label: beside the axis
    std::vector<Value> values{};         // in the order of the stations
    bool from_zero = false;
    bool is_log = false; // then values are above 0
    double limit = none; // a dashed line
    bool medians = true; // of homogeneous sections
};

// Stations of one profile and lane: they follow each other along the road, others do not.
struct Lane {
    std::string profile, lane;
    std::vector<std::size_t> stations{};

    std::string name() const {
        return profile.empty() && lane.empty() ? "the road"
               : lane.empty()                  ? profile
               : profile.empty()               ? "lane " + lane
                                               : profile + ", lane " + lane;
    }
};

struct Road {
    const Json& survey;
    const Json& stations;
    std::vector<double> at{}; // m, or numbers of stations where none has a chainage; none: nowhere
    std::string along = "chainage (m)";
    std::vector<Lane> lanes{};

    explicit Road(const Json& json) : survey(json), stations(json.at("stations")) {
        for (const Json& s : stations) {
            at.push_back(number_or_none(s.at("chainage_m")));
        }
        if (std::all_of(at.begin(), at.end(), [](double x) { return std::isnan(x); })) {
            along = "station, in their order";
            for (std::size_t i = 0; i < at.size(); ++i) {
                at[i] = static_cast<double>(i + 1);
            }
        }
        for (std::size_t i = 0; i < stations.size(); ++i) {
            const auto profile = stations[i].value("profile", std::string());
            const auto lane = stations[i].value("lane", std::string());
            auto found = std::find_if(lanes.begin(), lanes.end(),
                                      [&](const Lane& l) { return l.profile == profile && l.lane == lane; });
            if (found == lanes.end()) {
                found = lanes.insert(lanes.end(), Lane{profile, lane});
            }
            found->stations.push_back(i);
        }
    }
    Json weak_stations() const { return survey.value("weak_stations", Json()); } // null: too few to say
    bool is_weak(std::size_t i) const {
        const Json weak = weak_stations();
        return std::any_of(weak.begin(), weak.end(), [&](const Json& w) { return w.at("station") == i; });
    }
    std::vector<std::string> place(std::size_t i) const {
        const Json& s = stations[i];
        return {s.at("station").get<std::string>(), s.value("profile", std::string()), s.value("lane", std::string()),
                cell(number_or_none(s.at("chainage_m")))};
    }
};

Line style_of(std::size_t lane) {
    static constexpr Marker markers[] = {Marker::circle, Marker::square, Marker::triangle, Marker::diamond};
    return {.colour = okabe_ito[lane % std::size(okabe_ito)],
            .width = 0.0,
            .marker = markers[lane % std::size(markers)],
            .marker_size = 1.0};
}

Colour paler(Colour colour) {
    Colour mixed = 0;
    for (const unsigned shift : {16U, 8U, 0U}) {
        const Colour part = (colour >> shift) & 0xFFU;
        mixed |= (part + 2U * (0xFFU - part) / 3U) << shift;
    }
    return mixed;
}

// Points of interest at a station: {kind, words}. What more than half of the stations have in common is not.
std::vector<std::pair<std::string, std::string>> warnings_of(const Road& road, std::size_t i) {
    static const std::map<std::string, std::string> kinds{
        {"doubtful", "doubtful"}, {"rejected", "rejected"}, {"no-fit", "not described"}, {"failed", "no answer"}};
    const Json& s = road.stations[i];
    std::vector<std::pair<std::string, std::string>> warnings;
    if (road.is_weak(i)) {
        warnings.emplace_back("weak", "deflects more than its section");
    }
    if (const auto kind = kinds.find(s.at("status").get<std::string>()); kind != kinds.end()) {
        warnings.emplace_back(kind->second, s.value("reason", std::string()));
    }
    for (const Json& o : road.survey.value("outliers", Json::array())) {
        if (o.at("station") == s.at("station") && o.at("chainage_m") == s.at("chainage_m")) {
            warnings.emplace_back("outlier", o.at("reason").get<std::string>());
        }
    }
    for (const Json& remark : s.value("remarks", Json::array())) {
        const auto with = std::count_if(road.stations.begin(), road.stations.end(), [&](const Json& other) {
            const Json remarks = other.value("remarks", Json::array());
            return std::find(remarks.begin(), remarks.end(), remark) != remarks.end();
        });
        if (2 * static_cast<std::size_t>(with) <= road.stations.size()) {
            warnings.emplace_back("remark", remark.get<std::string>());
        }
    }
    return warnings;
}

constexpr double left = 2.6, width = 13.4; // cm, of a strip

PlotAxis along_axis(const Road& road) {
    PlotAxis axis;
    double low = 0.0;
    double high = 1.0;
    bool first = true;
    for (const double x : road.at) {
        if (std::isfinite(x)) {
            low = first ? x : std::min(low, x);
            high = first ? x : std::max(high, x);
            first = false;
        }
    }
    const double margin = high > low ? 0.03 * (high - low) : 1.0;
    axis.low = low - margin;
    axis.high = high + margin;
    axis.ticks = round_ticks(axis.low, axis.high, false, 10);
    axis.labelled = false;
    return axis;
}

// The way between the stations of a lane, or its stations.
void add_lane(Panel& panel, const Road& road, std::size_t number, const Strip& strip, bool way_alone) {
    const Lane& lane = road.lanes[number];
    const Line style = style_of(number);
    Line way{.colour = paler(style.colour), .width = 0.8};
    Line bars{.colour = style.colour, .width = 0.9};
    Line marks = style;
    Line weak = style;
    weak.colour = okabe_ito[1];
    weak.marker_size = 1.3;
    Line open = style;
    open.colour = white;
    open.marker_size = 0.55;
    for (const std::size_t i : lane.stations) {
        const Value& v = strip.values[i];
        if (std::isnan(v.value) || std::isnan(road.at[i])) {
            continue;
        }
        for (Line* line : {&way, road.is_weak(i) ? &weak : &marks}) {
            line->x.push_back(road.at[i]);
            line->y.push_back(v.value);
        }
        if (!v.determined) {
            open.x.push_back(road.at[i]);
            open.y.push_back(v.value);
        } else if (std::isfinite(v.low) && std::isfinite(v.high)) {
            bars.x.insert(bars.x.end(), {road.at[i], road.at[i], none});
            bars.y.insert(bars.y.end(), {v.low, v.high, none});
        }
    }
    const auto add = [&](Line& line) {
        if (!line.x.empty()) {
            panel.layers.emplace_back(std::move(line));
        }
    };
    if (way_alone) {
        add(way);
        return;
    }
    add(bars);
    add(marks);
    add(weak);
    add(open);
}

// Medians of homogeneous sections, as level lines; rows: {profile, lane, from_m, to_m, quantity, median}.
void add_sections(Panel& panel, const Road& road, std::size_t number, const Strip& strip,
                  std::vector<std::vector<std::string>>& rows) {
    const Lane& lane = road.lanes[number];
    for (const Json& section : road.survey.value("sections", Json::array())) {
        if (section.value("profile", std::string()) != lane.profile ||
            section.value("lane", std::string()) != lane.lane) {
            continue;
        }
        const double from = section.at("from_m").get<double>();
        const double to = section.at("to_m").get<double>();
        std::vector<double> values;
        for (const std::size_t i : lane.stations) {
            if (road.at[i] >= from && road.at[i] <= to && std::isfinite(strip.values[i].value)) {
                values.push_back(strip.values[i].value);
            }
        }
        if (!values.empty()) {
            const double median = data::median(std::move(values));
            panel.layers.emplace_back(
                Line{.x = {from, to}, .y = {median, median}, .colour = paler(style_of(number).colour), .width = 3.0});
            rows.push_back({lane.profile, lane.lane, cell(from), cell(to), strip.quantity, cell(median)});
        }
    }
}

PlotAxis value_axis(const Strip& strip) {
    double low = strip.limit;
    double high = strip.limit;
    for (const Value& v : strip.values) {
        for (const double at : {v.value, v.determined ? v.low : none, v.determined ? v.high : none}) {
            if (std::isfinite(at)) {
                low = std::isnan(low) ? at : std::min(low, at);
                high = std::isnan(high) ? at : std::max(high, at);
            }
        }
    }
    if (strip.is_log) {
        PlotAxis axis{.label = strip.label, .low = low / 1.2, .high = 1.2 * high, .log = true};
        axis.ticks = round_ticks(axis.low, axis.high, true, 4);
        return axis;
    }
    low = strip.from_zero ? std::min(0.0, low) : low;
    const double margin = high > low ? 0.08 * (high - low) : std::max(1e-9, 0.1 * std::abs(high));
    PlotAxis axis{
        .label = strip.label, .low = strip.from_zero && low == 0.0 ? 0.0 : low - margin, .high = high + margin};
    axis.ticks = round_ticks(axis.low, axis.high, false, 4);
    return axis;
}

// Strips below each other; what is worth a look above them.
Figure strips_figure(const std::string& name, const Road& road, const std::vector<Strip>& strips) {
    Figure figure{.name = name, .width = left + width + 0.5};
    DataTable table{
        name,
        {"station", "profile", "lane", "chainage_m", "quantity", "value", "low", "high", "determined", "unit"},
        {}};
    DataTable sections{name + "-sections", {"profile", "lane", "from_m", "to_m", "quantity", "median"}, {}};
    DataTable warnings{"warnings", {"station", "profile", "lane", "chainage_m", "kind", "words"}, {}};

    std::vector<std::string> kinds;
    Panel top;
    top.grid = true;
    std::map<std::size_t, Line> marks; // by lane
    for (std::size_t number = 0; number < road.lanes.size(); ++number) {
        for (const std::size_t i : road.lanes[number].stations) {
            for (const auto& [kind, words] : warnings_of(road, i)) {
                auto row = road.place(i);
                row.insert(row.end(), {kind, words});
                warnings.rows.push_back(std::move(row));
                const auto found = std::find(kinds.begin(), kinds.end(), kind);
                const auto level = static_cast<double>(found - kinds.begin());
                if (found == kinds.end()) {
                    kinds.push_back(kind);
                }
                Line& line = marks.try_emplace(number, style_of(number)).first->second;
                if (std::isfinite(road.at[i])) {
                    line.x.push_back(road.at[i]);
                    line.y.push_back(level);
                }
            }
        }
    }
    const bool ranges = std::any_of(strips.begin(), strips.end(), [](const Strip& s) {
        return std::any_of(s.values.begin(), s.values.end(), [](const Value& v) { return std::isfinite(v.low); });
    });
    const bool undetermined = std::any_of(strips.begin(), strips.end(), [](const Strip& s) {
        return std::any_of(s.values.begin(), s.values.end(), [](const Value& v) { return !v.determined; });
    });
    const bool limits =
        std::any_of(strips.begin(), strips.end(), [](const Strip& s) { return std::isfinite(s.limit); });

    constexpr double gap = 0.35;
    constexpr double page = 23.0; // cm of an A4 page that strips may fill
    const auto count = static_cast<double>(strips.size());
    const double high = std::clamp(page / std::max(1.0, count) - gap, 1.9, 3.0);
    std::vector<Panel> panels; // from the top
    for (const Strip& strip : strips) {
        for (std::size_t i = 0; i < strip.values.size(); ++i) {
            const Value& v = strip.values[i];
            if (std::isfinite(v.value)) {
                auto row = road.place(i);
                row.insert(row.end(), {strip.quantity, cell(v.value), cell(v.low), cell(v.high),
                                       v.determined ? "yes" : "no", strip.unit});
                table.rows.push_back(std::move(row));
            }
        }
        Panel& panel = panels.emplace_back();
        panel.height = high;
        panel.grid = true;
        panel.y = value_axis(strip);
        if (std::isfinite(strip.limit)) {
            const PlotAxis axis = along_axis(road);
            panel.layers.emplace_back(Line{.x = {axis.low, axis.high},
                                           .y = {strip.limit, strip.limit},
                                           .colour = black,
                                           .width = 1.0,
                                           .dashed = true});
        }
        for (std::size_t number = 0; strip.medians && number < road.lanes.size(); ++number) {
            add_sections(panel, road, number, strip, sections.rows);
        }
        for (const bool way_alone : {true, false}) {
            for (std::size_t number = 0; number < road.lanes.size(); ++number) {
                add_lane(panel, road, number, strip, way_alone);
            }
        }
    }
    if (!kinds.empty()) {
        top.height = 0.45 * static_cast<double>(kinds.size());
        top.y.low = -0.5;
        top.y.high = static_cast<double>(kinds.size()) - 0.5;
        top.y.reversed = true;
        for (std::size_t k = 0; k < kinds.size(); ++k) {
            top.y.ticks.push_back({static_cast<double>(k), kinds[k]});
        }
        for (auto& [number, line] : marks) {
            top.layers.emplace_back(std::move(line));
        }
        panels.insert(panels.begin(), std::move(top));
    }

    Key key(left, 0.0);
    for (std::size_t number = 0; road.lanes.size() > 1 && number < road.lanes.size(); ++number) {
        key.mark(style_of(number), road.lanes[number].name());
    }
    if (ranges) {
        key.line(okabe_ito[0], false, 0.9, "bars: 95 % ranges");
    }
    if (undetermined) {
        key.mark({.colour = okabe_ito[0], .marker = Marker::open_circle}, "open: not determined by these readings");
    }
    if (!sections.rows.empty()) {
        key.line(paler(okabe_ito[0]), false, 3.0, "median of a homogeneous section");
    }
    if (!road.weak_stations().empty()) {
        key.mark({.colour = okabe_ito[1], .marker = Marker::circle, .marker_size = 1.3}, "weak");
    }
    if (limits) {
        key.line(black, true, 1.0, "limit of the deflection ratio");
    }
    Panel explained = key.done();
    const double below = 1.25 + explained.height + 0.2; // ticks, the name of the axis, the key
    figure.height = below + 0.3;
    for (const Panel& panel : panels) {
        figure.height += panel.height + gap;
    }
    double from_top = figure.height - 0.3;
    for (std::size_t k = 0; k < panels.size(); ++k) {
        Panel& panel = panels[k];
        panel.left = left;
        panel.width = width;
        panel.bottom = from_top - panel.height;
        from_top = panel.bottom - gap;
        panel.x = along_axis(road);
        if (k + 1 == panels.size()) {
            panel.x.labelled = true;
            panel.x.label = road.along;
        }
        figure.panels.push_back(std::move(panel));
    }
    explained.bottom = 0.2;
    if (!explained.notes.empty()) {
        figure.panels.push_back(std::move(explained));
    }
    figure.tables = {std::move(table)};
    for (DataTable* more : {&sections, &warnings}) {
        if (!more->rows.empty()) {
            figure.tables.push_back(std::move(*more));
        }
    }
    return figure;
}

// A number of every station: `of` gives Json of one, null: none.
template <typename Of>
Strip strip_of(const Road& road, std::string quantity, std::string unit, std::string label, const Of& of) {
    Strip strip{.quantity = std::move(quantity), .unit = std::move(unit), .label = std::move(label)};
    for (const Json& s : road.stations) {
        strip.values.push_back({.value = number_or_none(of(s))});
    }
    return strip;
}

bool has_values(const Strip& strip) {
    return std::any_of(strip.values.begin(), strip.values.end(), [](const Value& v) { return std::isfinite(v.value); });
}

// Names in the order in which they first stand.
void add_names(std::vector<std::string>& names, const Json& object) {
    for (const auto& [name, value] : object.items()) {
        if (std::find(names.begin(), names.end(), name) == names.end()) {
            names.push_back(name);
        }
    }
}

} // namespace

Figure deflections_figure(const Json& survey) {
    const Road road(survey);
    std::vector<Strip> strips;
    const auto add = [&](Strip strip) {
        if (has_values(strip)) {
            strips.push_back(std::move(strip));
        }
    };
    const std::string pressure = fmt::format("{:.0f} kPa", survey.at("common_pressure_kPa").get<double>());
    Strip d0 = strip_of(road, "D0_um_at_common_pressure", "um", "D0 at\n" + pressure + " (µm)",
                        [](const Json& s) { return s.value("D0_um_at_common_pressure", Json()); });
    d0.from_zero = true;
    add(std::move(d0));
    for (const std::string index : {"SCI", "BDI", "BCI"}) {
        Strip strip = strip_of(road, index + "_um", "um", index + "\n(µm)", [&](const Json& s) {
            return s.value("normalised", Json::object()).value(index + "_um", Json());
        });
        strip.from_zero = true;
        add(std::move(strip));
    }
    Strip ratio = strip_of(road, "deflection_ratio", "", "deflection\nratio",
                           [](const Json& s) { return s.value("deflection_ratio", Json()); });
    ratio.limit = survey.at("deflection_ratio").at("limit").get<double>();
    add(std::move(ratio));
    return strips_figure("deflections", road, strips);
}

Figure back_calculation_figure(const Json& survey) {
    const Road road(survey);
    std::vector<std::string> parameters;
    std::vector<std::string> outputs;
    for (const Json& s : road.stations) {
        if (s.contains("fit")) {
            add_names(parameters, s.at("fit").at("parameters"));
            add_names(outputs, s.value("outputs", Json::object()));
        }
    }
    const auto with_range = [&](Strip& strip, const char* group) {
        for (std::size_t i = 0; i < road.stations.size(); ++i) {
            const Json of = road.stations[i].value(group, Json::object()).value(strip.quantity, Json::object());
            Value& v = strip.values[i];
            if (std::isfinite(v.value) && of.contains("determined")) {
                v.low = number_or_none(of.at("low"));
                v.high = number_or_none(of.at("high"));
                v.determined = of.at("determined").get<bool>();
            }
        }
    };
    std::vector<Strip> strips;
    Strip years{.quantity = "years", .unit = "years", .label = "years\nleft", .is_log = true};
    for (const Json& s : road.stations) {
        const Json lives = s.value("lives", Json::object());
        const auto at = [&](const char* key) {
            const double value = number_or_none(lives.value(key, Json()));
            return value > 0.0 ? value : none;
        };
        years.values.push_back({.value = at("years"), .low = at("years_low"), .high = at("years_high")});
    }
    if (has_values(years)) {
        strips.push_back(std::move(years));
    }
    for (const std::string& name : parameters) {
        const AxisWords words = axis_words(name);
        strips.push_back(strip_of(road, name, words.unit, words.lines(), [&](const Json& s) {
            return s.contains("fit") ? s.at("fit").at("parameters").value(name, Json()) : Json();
        }));
        with_range(strips.back(), "parameters");
    }
    for (const std::string& name : outputs) {
        std::string unit;
        Strip strip = strip_of(road, name, "", "", [&](const Json& s) {
            const Json of = s.value("outputs", Json::object()).value(name, Json::object());
            unit = of.value("unit", unit);
            return s.contains("fit") ? of.value("value", Json()) : Json();
        });
        strip.unit = unit;
        strip.label = fmt::format("{}\n({})", name, unit_words(unit));
        with_range(strip, "outputs");
        strips.push_back(std::move(strip));
    }
    strips.push_back(strip_of(road, "rms_percent", "%", "rms of\nthe fit (%)", [](const Json& s) {
        return s.contains("fit") ? s.at("fit").value("rms_percent", Json()) : Json();
    }));
    strips.back().from_zero = true;
    strips.back().medians = false;
    return strips_figure("back-calculation", road, strips);
}

} // namespace explore::report

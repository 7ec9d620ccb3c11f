// Readings against the model, and the residual in standard deviations.
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gsl/gsl_interp.h>
#include <memory>
#include <optional>
#include <set>

namespace explore::report {
namespace {

struct Place {
    std::size_t index = 0; // of the reading
    double x = 0.0, y = 0.0, depth = 0.0, gauge = 0.0, measured = 0.0, sigma = none;
    double time = none; // ms
    bool held_out = false;
};
struct Group {
    std::string load, quantity, unit;
    std::vector<Place> places;
};

std::vector<Group> groups_of(const Json& readings) {
    std::vector<Group> groups;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const Json& r = readings[i];
        const auto load = r.at("load").get<std::string>();
        const auto quantity = r.at("quantity").get<std::string>();
        auto group = std::find_if(groups.begin(), groups.end(),
                                  [&](const Group& g) { return g.load == load && g.quantity == quantity; });
        if (group == groups.end()) {
            group = groups.insert(groups.end(), {load, quantity, r.at("unit").get<std::string>(), {}});
        }
        Place place;
        place.index = i;
        place.x = r.at("x_mm").get<double>();
        place.y = r.at("y_mm").get<double>();
        place.depth = r.at("depth_mm").get<double>();
        place.gauge = r.value("gauge_mm", 0.0);
        place.time = r.value("time_ms", none);
        place.measured = r.at("measured").get<double>();
        if (r.at("unit") != group->unit) { // of another file: no line joins them
            continue;
        }
        place.sigma = r.value("sigma", none);
        place.held_out = r.value("held_out", false);
        group->places.push_back(place);
    }
    return groups;
}

std::string mm(double value) {
    return fmt::format("{:g}", value);
}

std::string place_words(const Place& p) {
    std::string text = fmt::format("x = {}", mm(p.x));
    text += p.y != 0.0 ? fmt::format(", y = {}", mm(p.y)) : "";
    text += p.depth != 0.0 ? fmt::format(", depth {}", mm(p.depth)) : "";
    return text + " mm";
}

// Whether readings of a group are drawn over time: those that have none are left out then.
bool is_over_time(const Group& group) {
    return std::any_of(group.places.begin(), group.places.end(), [](const Place& p) { return !std::isnan(p.time); });
}

// Limits with a margin around values.
void fit_range(PlotAxis& axis, double low, double high, int ticks) {
    const double margin = high > low ? 0.06 * (high - low) : std::max(1e-9, 0.1 * std::abs(high));
    axis.low = low - margin;
    axis.high = high + margin;
    axis.ticks = round_ticks(axis.low, axis.high, false, ticks);
}

// Readings that one line joins: of one depth along x, of one x over the depth, or of one place over time.
struct Strand {
    std::string name;
    std::vector<const Place*> places;
};

// The curve of a model along a strand of a group (places, values), if there is one.
std::optional<std::pair<std::vector<double>, std::vector<double>>> curve_along(const Json& curves, const Group& group,
                                                                               const Strand& strand, bool by_depth) {
    const Place& p = *strand.places.front();
    for (const Json& c : curves) {
        if (c.at("load") == group.load && c.at("quantity") == group.quantity && c.at("unit") == group.unit &&
            c.at("by_depth") == by_depth && c.at("y_mm") == p.y && c.at("gauge_mm") == p.gauge &&
            (by_depth ? c.at("x_mm") == p.x : c.at("depth_mm") == p.depth)) {
            std::vector<double> values;
            for (const Json& value : c.at("values")) {
                values.push_back(number_or_none(value));
            }
            return std::pair{c.at("at_mm").get<std::vector<double>>(), std::move(values)};
        }
    }
    return std::nullopt;
}

// The same by a monotone cubic through points whose places rise, at least three; nothing: there are no such.
std::optional<std::pair<std::vector<double>, std::vector<double>>> cubic_through(const std::vector<double>& at,
                                                                                 const std::vector<double>& values) {
    const bool rises = std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) == at.end();
    if (at.size() < gsl_interp_type_min_size(gsl_interp_steffen) || !rises ||
        !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
        return std::nullopt;
    }
    const std::unique_ptr<gsl_interp, void (*)(gsl_interp*)> cubic(gsl_interp_alloc(gsl_interp_steffen, at.size()),
                                                                   gsl_interp_free);
    gsl_interp_init(cubic.get(), at.data(), values.data(), at.size());
    constexpr int points = 60;
    std::pair<std::vector<double>, std::vector<double>> curve;
    for (int i = 0; i <= points; ++i) {
        const double x = i == points ? at.back() : at.front() + (at.back() - at.front()) * i / points;
        curve.first.push_back(x);
        curve.second.push_back(gsl_interp_eval(cubic.get(), at.data(), values.data(), x, nullptr));
    }
    return curve;
}

// Borders of layers across a panel whose y is the depth [mm], downwards, and the names of those that it shows.
void draw_layers(Panel& panel, const Json& layers) {
    const double span = panel.y.high - panel.y.low;
    double top = 0.0;
    for (const Json& layer : layers) {
        const double bottom = top + number_or_none(layer.value("thickness_mm", Json()));
        const double begins = std::max(top, panel.y.low);
        const double ends = std::isnan(bottom) ? panel.y.high : std::min(bottom, panel.y.high);
        constexpr double readable = 0.07; // of the panel
        if (ends - begins > readable * span) {
            panel.notes.push_back(
                {0.98, (panel.y.high - ends) / span + 0.04, layer.at("name").get<std::string>(), true, grey});
        }
        if (bottom > panel.y.low && bottom < panel.y.high) {
            panel.layers.insert(
                panel.layers.begin(),
                Line{.x = {panel.x.low, panel.x.high}, .y = {bottom, bottom}, .colour = grey, .width = 0.8});
        }
        top = bottom;
    }
}

DataTable readings_table(const std::string& name, const Json& readings, const std::vector<ComparedModel>& models,
                         bool residuals) {
    DataTable table{name, {"load", "quantity", "x_mm", "y_mm", "depth_mm", "series", "value", "unit"}, {}};
    if (residuals) {
        table.columns = {"load", "quantity", "x_mm", "y_mm", "depth_mm", "held_out", "model", "residual_in_deviations"};
    }
    const bool has_times =
        std::any_of(readings.begin(), readings.end(), [](const Json& r) { return r.contains("time_ms"); });
    if (has_times) {
        table.columns.insert(table.columns.begin() + 5, "time_ms");
    }
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const Json& r = readings[i];
        std::vector<std::string> where{r.at("load").get<std::string>(), r.at("quantity").get<std::string>(),
                                       mm(r.at("x_mm").get<double>()), mm(r.at("y_mm").get<double>()),
                                       mm(r.at("depth_mm").get<double>())};
        if (has_times) {
            where.push_back(r.contains("time_ms") ? mm(r.at("time_ms").get<double>()) : "");
        }
        const auto add = [&](std::initializer_list<std::string> rest) {
            auto row = where;
            row.insert(row.end(), rest);
            table.rows.push_back(std::move(row));
        };
        const auto unit = r.at("unit").get<std::string>();
        if (!residuals) {
            add({"measured", cell(r.at("measured").get<double>()), unit});
            if (r.contains("sigma")) {
                add({"standard deviation", cell(r.at("sigma").get<double>()), unit});
            }
        }
        for (const ComparedModel& model : models) {
            if (residuals) {
                add({r.value("held_out", false) ? "yes" : "no", model.name, cell(model.residuals[i])});
            } else {
                add({model.name, cell(model.values[i]), unit});
            }
        }
    }
    return table;
}

} // namespace

Figure fit_figure(const Json& readings, const std::vector<ComparedModel>& models, const Json& layers) {
    const auto groups = groups_of(readings);
    Figure figure{.name = "fit"};
    const std::size_t columns = groups.size() == 1 ? 1 : 2;
    const std::size_t rows = (groups.size() + columns - 1) / columns;
    const double width = columns == 1 ? 9.0 : 6.5;
    const double height = columns == 1 ? 6.0 : 4.8;
    constexpr double left = 2.1;
    constexpr double above = 0.75;
    figure.width = static_cast<double>(columns) * (width + left) + 0.5;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        const Group& group = groups[g];
        const std::size_t row = g / columns; // from the top
        Panel panel;
        panel.left = left + static_cast<double>(g % columns) * (width + left);
        panel.bottom = static_cast<double>(rows - 1 - row);
        panel.width = width;
        panel.height = height;
        panel.grid = true;
        std::set<double> depths;
        std::set<std::pair<double, double>> feet;
        for (const Place& p : group.places) {
            depths.insert(p.depth);
            feet.insert({p.x, p.y});
        }
        const bool over_time = is_over_time(group);
        const bool by_depth = !over_time && depths.size() > 1 && feet.size() <= depths.size();
        std::vector<Strand> strands;
        for (const Place& p : group.places) {
            if (over_time && std::isnan(p.time)) {
                continue;
            }
            const std::string name =
                over_time  ? (depths.size() + feet.size() > 2 ? place_words(p) : "")
                : by_depth ? (feet.size() > 1 ? "x = " + mm(p.x) + (p.y != 0.0 ? ", y = " + mm(p.y) : "") + " mm" : "")
                           : (depths.size() > 1 ? mm(p.depth) + " mm deep" : "");
            auto strand = std::find_if(strands.begin(), strands.end(), [&](const Strand& s) { return s.name == name; });
            if (strand == strands.end()) {
                strand = strands.insert(strands.end(), {name, {}});
            }
            strand->places.push_back(&p);
        }
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        double first = low;
        double last = high;
        static constexpr Marker markers[] = {Marker::circle, Marker::square, Marker::triangle, Marker::diamond};
        std::vector<Layer> points;
        for (std::size_t s = 0; s < strands.size(); ++s) {
            Strand& strand = strands[s];
            const auto along = [&](const Place* p) { return over_time ? p->time : by_depth ? p->depth : p->x; };
            std::stable_sort(strand.places.begin(), strand.places.end(),
                             [&](const Place* a, const Place* b) { return along(a) < along(b); });
            const bool one = strands.size() == 1;
            const auto values_along = [&](const auto& value) {
                Line line;
                for (const Place* p : strand.places) {
                    (by_depth ? line.y : line.x).push_back(along(p));
                    (by_depth ? line.x : line.y).push_back(value(*p));
                    if (std::isfinite(value(*p))) {
                        low = std::min(low, value(*p));
                        high = std::max(high, value(*p));
                    }
                    first = std::min(first, along(p));
                    last = std::max(last, along(p));
                }
                return line;
            };
            for (std::size_t m = 0; m < models.size(); ++m) {
                Line line = values_along([&](const Place& p) { return models[m].values[p.index]; });
                line.colour = okabe_ito[one ? m : s % std::size(okabe_ito)];
                line.dashed = models.size() > 1 && m == 0;
                line.width = 1.5;
                std::string name = models[m].name;
                const auto& at = by_depth ? line.y : line.x;
                const auto& values = by_depth ? line.x : line.y;
                auto curve = over_time ? std::nullopt : curve_along(models[m].curves, group, strand, by_depth);
                if (!curve && !over_time && group.quantity == "deflection") {
                    curve = cubic_through(at, values);
                    name += curve ? " (cubic between readings)" : "";
                }
                if (curve) {
                    for (const double value : curve->second) {
                        low = std::min(low, value);
                        high = std::max(high, value);
                    }
                    (by_depth ? line.y : line.x) = std::move(curve->first);
                    (by_depth ? line.x : line.y) = std::move(curve->second);
                }
                line.name = s == 0 ? name : "";
                if (line.x.size() == 1) {
                    line.marker = Marker::star;
                }
                panel.layers.emplace_back(std::move(line));
            }
            Line measured = values_along([](const Place& p) { return p.measured; });
            for (const Place* p : strand.places) {
                measured.error.push_back(std::isnan(p->sigma) ? 0.0 : p->sigma);
                low = std::min(low, p->measured - measured.error.back());
                high = std::max(high, p->measured + measured.error.back());
            }
            if (std::all_of(measured.error.begin(), measured.error.end(), [](double e) { return e == 0.0; })) {
                measured.error.clear();
            }
            measured.along_x = by_depth;
            measured.width = 0.0;
            measured.marker = markers[s % std::size(markers)];
            measured.colour = one ? black : okabe_ito[s % std::size(okabe_ito)];
            measured.name = strand.name.empty() ? "measured" : (over_time ? "" : "measured, ") + strand.name;
            points.emplace_back(std::move(measured));
        }
        panel.layers.insert(panel.layers.begin(), points.begin(), points.end()); // the legend begins with them
        panel.layers.insert(panel.layers.end(), points.begin(), points.end());   // and lines do not hide them
        for (std::size_t l = panel.layers.size() - points.size(); l < panel.layers.size(); ++l) {
            std::get<Line>(panel.layers[l]).name.clear();
        }
        if (group.quantity == "deflection" || over_time) {
            low = std::min(0.0, low);
        }
        if (over_time) { // room for the names of the places
            last += 0.5 * (last - first);
        }
        PlotAxis& value_axis = by_depth ? panel.x : panel.y;
        PlotAxis& place_axis = by_depth ? panel.y : panel.x;
        fit_range(value_axis, low, high, 5);
        fit_range(place_axis, first, last, 6);
        if (by_depth) {
            draw_layers(panel, layers);
        }
        value_axis.label = fmt::format("{} ({})", quantity_words(group.quantity), unit_words(group.unit));
        place_axis.label = over_time ? "time (ms)" : by_depth ? "depth (mm)" : "distance x (mm)";
        place_axis.reversed = by_depth;
        value_axis.reversed = !by_depth && !over_time && group.quantity == "deflection";
        panel.title = "load " + group.load;
        figure.panels.push_back(std::move(panel));
    }
    double bottom = 0.0; // room for axis and legend
    for (const Panel& panel : figure.panels) {
        bottom = std::max(bottom, legend_below + legend_height(panel) + 0.25);
    }
    for (Panel& panel : figure.panels) { // which know their rows so far
        panel.bottom = bottom + panel.bottom * (height + bottom + above);
    }
    figure.height = static_cast<double>(rows) * (height + bottom + above);
    figure.tables = {readings_table("fit", readings, models, false)};
    return figure;
}

Figure residuals_figure(const Json& readings, const std::vector<ComparedModel>& models) {
    const auto groups = groups_of(readings);
    // A row for every reading and one for the name of each group.
    std::size_t count = 0;
    for (const Group& group : groups) {
        count += group.places.size() + 1;
    }
    constexpr double row = 0.4;
    Figure figure{.name = "residuals", .width = 13.5};
    Panel panel;
    panel.left = 4.4;
    panel.bottom = 1.2;
    panel.width = 8.7;
    panel.height = row * static_cast<double>(count);
    figure.height = panel.bottom + panel.height + (models.size() > 1 ? 1.0 : 0.4);
    double most = 3.0;
    std::vector<Line> marks;
    std::vector<Line> held_out;
    static constexpr Marker markers[] = {Marker::circle, Marker::square};
    for (std::size_t m = 0; m < models.size(); ++m) {
        const Colour colour = models.size() > 1 && m == 0 ? grey : okabe_ito[0];
        marks.push_back({.colour = colour, .width = 0.0, .marker = markers[m % 2], .marker_size = 1.1});
        held_out.push_back({.colour = colour, .width = 0.0, .marker = Marker::open_circle, .marker_size = 1.1});
        for (const double r : models[m].residuals) {
            most = std::isfinite(r) ? std::max(most, std::abs(r)) : most;
        }
    }
    most *= 1.08;
    const auto rows = static_cast<double>(count);
    for (const auto& [reach, colour] : {std::pair<double, Colour>{2.0, 0xF1F3F5}, {1.0, 0xE1E6EA}}) {
        panel.layers.emplace_back(Boxes{{-reach}, {reach}, {-0.5}, {rows - 0.5}, {colour}, false});
    }
    panel.layers.emplace_back(Line{.x = {0.0, 0.0}, .y = {-0.5, rows - 0.5}, .colour = black, .width = 0.8});
    double at = 0.0;
    for (const Group& group : groups) {
        panel.y.ticks.push_back({at, fmt::format("{}: {}", group.load, quantity_words(group.quantity))});
        at += 1.0;
        for (const Place& place : group.places) {
            panel.y.ticks.push_back(
                {at, place_words(place) + (std::isnan(place.time) ? "" : fmt::format(", {:g} ms", place.time))});
            for (std::size_t m = 0; m < models.size(); ++m) {
                const double r = models[m].residuals[place.index];
                if (!std::isfinite(r)) {
                    continue;
                }
                if (m + 1 == models.size()) {
                    panel.layers.emplace_back(
                        Line{.x = {0.0, r}, .y = {at, at}, .colour = marks[m].colour, .width = 1.0});
                }
                Line& line = place.held_out ? held_out[m] : marks[m];
                line.x.push_back(r);
                line.y.push_back(at);
            }
            at += 1.0;
        }
    }
    const bool any_held_out =
        std::any_of(held_out.begin(), held_out.end(), [](const Line& line) { return !line.x.empty(); });
    for (std::size_t m = 0; m < models.size(); ++m) {
        panel.layers.emplace_back(std::move(marks[m]));
        if (!held_out[m].x.empty()) {
            panel.layers.emplace_back(std::move(held_out[m]));
        }
    }
    panel.x.low = -most;
    panel.x.high = most;
    panel.x.ticks = round_ticks(-most, most, false, 8);
    panel.x.label = std::string("model - measured (standard deviations)") + (any_held_out ? "; open: not fitted" : "");
    panel.y.low = -0.5;
    panel.y.high = rows - 0.5;
    panel.y.reversed = true;
    if (models.size() > 1) { // what the marks are, above the panel
        double from = 0.0;
        for (std::size_t m = 0; m < models.size(); ++m) {
            const double place = 1.0 + 0.45 / panel.height;
            panel.notes.push_back(
                {from, place, (m == 0 ? "● " : "■ ") + models[m].name, false, m == 0 ? grey : okabe_ito[0]});
            from += 0.35;
        }
    }
    figure.panels.push_back(std::move(panel));
    figure.tables = {readings_table("residuals", readings, models, true)};
    return figure;
}

} // namespace explore::report

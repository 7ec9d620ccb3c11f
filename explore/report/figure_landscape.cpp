// The landscape of the misfit over pairs of parameters, all others fitted, as a corner of panels.
#include "report/figure_pair.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

// Levels a half decade apart, from a twelfth of the limit to beyond the highest.
std::vector<double> levels_up_to(double highest) {
    std::vector<double> levels;
    for (const double level : {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0}) {
        if (levels.size() < 4 || level < highest) {
            levels.push_back(level);
        }
    }
    return levels;
}

Colour band_colour(std::size_t band, std::size_t bands) {
    return cividis(static_cast<double>(band) / static_cast<double>(bands - 1));
}

void draw_pair(Panel& panel, const Corner& corner, const Pair& pair, const std::vector<double>& levels, double limit) {
    const Parameter& px = corner.parameters[pair.x];
    const Parameter& py = corner.parameters[pair.y];
    const std::size_t nx = pair.grid.x.size();
    if (pair.has_answers()) {
        const Grid fine = fine_roots(pair.grid, 4);
        std::vector<double> roots;
        roots.reserve(levels.size());
        for (const double level : levels) {
            roots.push_back(std::sqrt(level));
        }
        const std::size_t bands = levels.size() + 1;
        panel.layers.emplace_back(
            Boxes{{px.low}, {px.high}, {py.low}, {py.high}, {band_colour(bands - 1, bands)}, false});
        const auto in_parameters = [&](const Contour& contour, auto& shape) {
            for (std::size_t i = 0; i < contour.x.size(); ++i) {
                shape.x.push_back(px.physical(contour.x[i]));
                shape.y.push_back(py.physical(contour.y[i]));
            }
        };
        for (const Contour& contour : contours(fine, roots)) {
            const auto level =
                static_cast<std::size_t>(std::lower_bound(roots.begin(), roots.end(), contour.level) - roots.begin());
            Area area;
            area.colour = band_colour(level + (contour.below ? 0 : 1), bands);
            in_parameters(contour, area);
            panel.layers.emplace_back(std::move(area));
        }
        for (const Contour& contour : contours(fine, {std::sqrt(limit)})) {
            Line line;
            line.colour = okabe_ito[1];
            line.width = 1.6;
            in_parameters(contour, line);
            line.x.push_back(line.x.front());
            line.y.push_back(line.y.front());
            panel.layers.emplace_back(std::move(line));
        }
    }
    Boxes holes;
    const auto ex = edges_of(pair.grid.x);
    const auto ey = edges_of(pair.grid.y);
    for (std::size_t n = 0; n < pair.grid.z.size(); ++n) {
        if (std::isnan(pair.grid.z[n])) {
            holes.left.push_back(px.physical(ex[n % nx]));
            holes.right.push_back(px.physical(ex[n % nx + 1]));
            holes.bottom.push_back(py.physical(ey[n / nx]));
            holes.top.push_back(py.physical(ey[n / nx + 1]));
        }
    }
    add_hatched(panel, std::move(holes));
}

void draw_profile(Panel& panel, const Json& profile, const Json& minima, const Parameter& p, double limit, double top) {
    Line line;
    const auto [units, rises] = smooth_rise(p.units(numbers_of(profile.at("values"))), numbers_of(profile.at("rise")));
    for (const double unit : units) {
        line.x.push_back(p.physical(unit));
    }
    line.y = rises;
    line.width = 1.5;
    line.colour = okabe_ito[0];
    // The first point beyond the panel stays: the line leaves it.
    for (std::size_t i = 0; i < line.y.size(); ++i) {
        line.y[i] = std::min(line.y[i], 1e3 * top);
    }
    Line allowed{.x = {p.low, p.high}, .y = {limit, limit}, .colour = okabe_ito[1], .width = 1.2, .dashed = true};
    panel.layers.emplace_back(std::move(allowed));
    panel.layers.emplace_back(std::move(line));
    add_minima(panel, minima, p, nullptr, 0.0);
    panel.y.low = -0.04 * top;
    panel.y.high = top;
}

// The valley that was followed, from one end through the best minimum to the other.
struct Valley {
    std::vector<const Json*> way; // {name: value}
    std::vector<const Json*> ends;
};
Valley valley_of(const Json& unique) {
    Valley valley;
    const double limit = unique.at("landscape").at("limit").get<double>();
    for (const Json& trace : unique.at("traces")) {
        if (!trace.contains("accepted_end")) {
            continue;
        }
        std::reverse(valley.way.begin(), valley.way.end()); // the first ends where the second begins
        valley.way.push_back(&unique.at("minima").at(0).at("parameters"));
        for (const Json& point : trace.at("points")) {
            if (number_or_none(point.at("rise")) <= limit) {
                valley.way.push_back(&point.at("parameters"));
            }
        }
        valley.way.push_back(&trace.at("accepted_end"));
        valley.ends.push_back(&trace.at("accepted_end"));
    }
    return valley;
}

void draw_valley(Panel& panel, const Valley& valley, const Parameter& x, const Parameter& y) {
    if (valley.ends.empty()) {
        return;
    }
    const auto values = [](const std::vector<const Json*>& points, const Parameter& p) {
        std::vector<double> list;
        std::transform(points.begin(), points.end(), std::back_inserter(list),
                       [&](const Json* point) { return number_or_none(point->at(p.name)); });
        return list;
    };
    draw_way(panel, values(valley.way, x), values(valley.way, y), values(valley.ends, x), values(valley.ends, y));
}

DataTable valley_table(const Valley& valley, const std::vector<Parameter>& parameters) {
    DataTable table{"valley", {}, {}};
    for (const Parameter& p : parameters) {
        table.columns.push_back(p.name);
    }
    for (const Json* point : valley.way) {
        std::vector<std::string>& row = table.rows.emplace_back();
        std::transform(parameters.begin(), parameters.end(), std::back_inserter(row),
                       [&](const Parameter& p) { return cell(number_or_none(point->at(p.name))); });
    }
    return table;
}

// Shows of every parameter what the data accept and three quarters of that on either side, within the box.
void look_close(std::vector<Parameter>& parameters, const Json& unique) {
    for (Parameter& p : parameters) {
        for (const Json& profile : unique.at("profiles")) {
            if (profile.at("name") == p.name) {
                const double low = p.unit(profile.at("low").get<double>());
                const double high = p.unit(profile.at("high").get<double>());
                const double margin = 0.75 * std::max(0.01, high - low);
                p.from = std::max(0.0, low - margin);
                p.to = std::min(1.0, high + margin);
            }
        }
    }
}

} // namespace

bool has_close_landscape(const Json& unique) {
    auto parameters = parameters_of(unique.at("parameters"));
    look_close(parameters, unique);
    constexpr double close = 0.4;
    return std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) { return p.to - p.from < close; });
}

Figure profiled_landscape_figure(const Json& unique, bool close, const std::optional<NamedPair>& only) {
    const Json& landscape = unique.at("landscape");
    const Json& minima = unique.at("minima");
    const double limit = landscape.at("limit").get<double>();
    Corner corner(unique.at("parameters"));
    if (close) {
        look_close(corner.parameters, unique);
    }
    const std::size_t n = corner.parameters.size();
    Figure figure{.name = close ? "landscape-close" : "landscape", .width = corner.width(), .height = corner.height()};
    DataTable nodes{figure.name, {"x_parameter", "y_parameter", "x", "y", "rise_of_chi2"}, {}};
    DataTable singles{figure.name + "-profiles", {"parameter", "value", "rise_of_chi2"}, {}};

    std::vector<Pair> pairs;
    double highest = 0.0;
    for (const Json& json : landscape.at("pairs")) {
        Pair pair = pair_of(json, corner.parameters);
        for (std::size_t k = 0; k < pair.grid.z.size(); ++k) {
            const double rise = pair.grid.z[k];
            highest = std::max(highest, std::isnan(rise) ? 0.0 : rise);
            const Json& x = json.at("x_values").at(k % pair.grid.x.size());
            const Json& y = json.at("y_values").at(k / pair.grid.x.size());
            nodes.rows.push_back({corner.parameters[pair.x].name, corner.parameters[pair.y].name,
                                  cell(number_or_none(x)), cell(number_or_none(y)), cell(rise)});
        }
        pairs.push_back(std::move(pair));
    }
    const std::vector<double> levels = levels_up_to(highest);
    const Valley valley = valley_of(unique);
    bool holes = false;
    for (const Pair& pair : pairs) {
        const Parameter& x = corner.parameters[pair.x];
        const Parameter& y = corner.parameters[pair.y];
        if (only && !only->is(x.name, y.name)) {
            continue;
        }
        Panel panel = only ? corner.alone(pair.x, pair.y) : corner.panel(pair.x, pair.y);
        draw_pair(panel, corner, pair, levels, limit);
        draw_valley(panel, valley, x, y);
        add_minima(panel, minima, x, &y);
        figure.panels.push_back(std::move(panel));
        holes = holes || std::any_of(pair.grid.z.begin(), pair.grid.z.end(), [](double z) { return std::isnan(z); });
    }
    const double top = 3.0 * limit;
    for (const Json& profile : landscape.at("profiles")) {
        const std::size_t k = index_of(corner.parameters, profile.at("name"));
        const auto values = numbers_of(profile.at("values"));
        const auto rises = numbers_of(profile.at("rise"));
        for (std::size_t i = 0; i < values.size(); ++i) {
            singles.rows.push_back({corner.parameters[k].name, cell(values[i]), cell(rises[i])});
        }
        if (only) {
            continue;
        }
        Panel panel = corner.panel(k, k);
        draw_profile(panel, profile, minima, corner.parameters[k], limit, top);
        panel.y.ticks = round_ticks(0.0, top, false, 4);
        panel.y.labelled = k == 0;
        panel.y.label = k == 0 ? "rise of χ²" : "";
        figure.panels.push_back(std::move(panel));
    }

    std::vector<Colour> colours;
    std::vector<Tick> ticks;
    for (std::size_t band = 0; band <= levels.size(); ++band) {
        colours.push_back(band_colour(band, levels.size() + 1));
        if (band < levels.size()) {
            ticks.push_back({static_cast<double>(band + 1), fmt::format("{:g}", levels[band])});
        }
    }
    double left = corner.key_left();
    double key_top = corner.key_top();
    if (only) {
        left = Corner::left + Corner::large + 0.6;
        key_top = Corner::bottom + Corner::large;
        figure.width = left;
        figure.height = key_top + Corner::above;
    } else if (n < 3) { // beside the corner, not in it
        left = corner.width() + 0.4;
    }
    Key key(left, key_top);
    key.line(okabe_ito[1], false, 1.6, fmt::format("accepted by the data: rise of χ² {:.3g}", limit));
    if (!only) {
        key.line(okabe_ito[0], false, 1.5, "profile of each parameter");
    }
    key.minimum(minima.size() > 1 ? "best fit and other accepted minima" : "best fit");
    if (!valley.ends.empty()) {
        key.valley("the valley that was followed, its ends");
    }
    if (holes) {
        key.box(grey, true, "no answer of the model");
    }
    figure.width = std::max(figure.width, left + key.reach() + 0.2);
    Panel explained = key.done();
    const double bar_height = std::min(3.6, std::max(2.4, corner.side));
    const double bar_bottom = explained.bottom - 0.95 - bar_height;
    figure.panels.push_back(colour_bar(left, bar_bottom, bar_height, colours, ticks, "rise of χ², the others fitted"));
    figure.panels.push_back(std::move(explained));
    figure.tables = {std::move(nodes), std::move(singles), minima_table(minima, corner.parameters)};
    if (!valley.ends.empty()) {
        figure.tables.push_back(valley_table(valley, corner.parameters));
    }
    return figure;
}

} // namespace explore::report

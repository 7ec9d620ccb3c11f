// The landscape of the misfit over pairs of parameters, as a corner of panels.
#include "report/contours.h"
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::report {
namespace {

std::vector<double> numbers_of(const Json& list) {
    std::vector<double> values;
    std::transform(list.begin(), list.end(), std::back_inserter(values), number_or_none);
    return values;
}

// A parameter as an axis: its place in the unit interval.
struct Parameter {
    std::string name;
    double low = 0.0, high = 1.0;
    bool log = false;
    double from = 0.0, to = 1.0; // what is shown, in the unit interval

    explicit Parameter(const Json& json)
        : name(json.at("name").get<std::string>()),
          low(json.at("min").get<double>()),
          high(json.at("max").get<double>()),
          log(json.at("scale") == "log") {}
    double unit(double value) const {
        return log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    }
    double physical(double unit) const { return log ? low * std::pow(high / low, unit) : low + unit * (high - low); }
    bool shows(double value) const { return unit(value) >= from - 1e-9 && unit(value) <= to + 1e-9; }
    std::vector<double> units(const std::vector<double>& values) const {
        std::vector<double> all;
        all.reserve(values.size());
        for (const double value : values) {
            all.push_back(unit(value));
        }
        return all;
    }
};

// Over two lines where the panel is too narrow for one.
std::string fitting(const AxisWords& words, double width) {
    constexpr double letter = 0.16; // cm
    std::string line = words.line();
    return static_cast<double>(line.size()) * letter <= width ? line : words.lines();
}

// Where the panels of a corner stand.
struct Corner {
    std::vector<Parameter> parameters;
    double side = 3.0; // of a panel, cm
    static constexpr double gap = 0.25, left = 1.75, bottom = 1.75, above = 0.45, right = 0.5, large = 11.0;

    explicit Corner(const Json& list) {
        for (const Json& p : list) {
            parameters.emplace_back(p);
        }
        static constexpr double sides[] = {7.0, 5.4, 4.4, 3.6, 2.95, 2.45};
        const std::size_t n = parameters.size();
        side = n == 0 ? 7.0 : n <= 6 ? sides[n - 1] : 2.1;
    }
    double reach() const {
        const auto n = static_cast<double>(parameters.size());
        return n * side + (n - 1.0) * gap;
    }
    double height() const { return bottom + reach() + above; }
    double width() const { return left + reach() + right; }

    PlotAxis axis(std::size_t k, bool named) const {
        const Parameter& p = parameters[k];
        PlotAxis axis;
        axis.low = p.physical(p.from);
        axis.high = p.physical(p.to);
        axis.log = p.log;
        constexpr double wide = 3.0; // less is labelled evenly
        axis.ticks = round_ticks(axis.low, axis.high, p.log && axis.high > wide * axis.low, side < 2.5 ? 3 : 4);
        // None at the ends, where the next panel begins.
        const auto share = [&](const Tick& tick) { return (p.unit(tick.at) - p.from) / (p.to - p.from); };
        std::erase_if(axis.ticks, [&](const Tick& tick) { return std::abs(share(tick) - 0.5) > 0.46; });
        axis.labelled = named;
        axis.label = named ? fitting(axis_words(p.name), side) : "";
        return axis;
    }
    Panel panel(std::size_t column, std::size_t row) const {
        const std::size_t n = parameters.size();
        Panel panel;
        panel.left = left + static_cast<double>(column) * (side + gap);
        panel.bottom = bottom + static_cast<double>(n - 1 - row) * (side + gap);
        panel.width = panel.height = side;
        panel.x = axis(column, row == n - 1);
        if (row != column) {
            panel.y = axis(row, column == 0);
        }
        return panel;
    }
    // One pair large.
    Panel alone(std::size_t column, std::size_t row) const {
        Panel panel;
        panel.left = left;
        panel.bottom = bottom;
        panel.width = panel.height = large;
        Corner one = *this;
        one.side = large;
        panel.x = one.axis(column, true);
        panel.y = one.axis(row, true);
        return panel;
    }
    // The empty corner, from there to the right and top edge.
    double key_left() const { return left + 2.0 * (side + gap) + 0.6; }
    double key_top() const { return bottom + reach(); }
};

Line minima_marks(const Json& minima, const Parameter& x, const Parameter* y, double height, bool outer) {
    Line line;
    line.width = 0.0;
    line.marker = Marker::circle;
    line.marker_size = outer ? 1.5 : 0.95;
    line.colour = outer ? black : white;
    for (const Json& m : minima) {
        const double at = m.at("parameters").at(x.name).get<double>();
        const double above = y != nullptr ? m.at("parameters").at(y->name).get<double>() : height;
        if (m.value("accepted", true) && x.shows(at) && (y == nullptr || y->shows(above))) {
            line.x.push_back(at);
            line.y.push_back(above);
        }
    }
    return line;
}

void add_minima(Panel& panel, const Json& minima, const Parameter& x, const Parameter* y, double height = 0.0) {
    panel.layers.emplace_back(minima_marks(minima, x, y, height, true));
    panel.layers.emplace_back(minima_marks(minima, x, y, height, false));
}

// Where there is no answer; no boxes: nothing.
void add_hatched(Panel& panel, Boxes boxes) {
    if (boxes.left.empty()) {
        return;
    }
    boxes.colours = {0xF0F0F0};
    panel.layers.emplace_back(boxes);
    boxes.colours = {grey};
    boxes.hatched = true;
    panel.layers.emplace_back(std::move(boxes));
}

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

// A bar of the colours, read at its right side.
Panel colour_bar(double left, double bottom, double height, const std::vector<Colour>& colours,
                 const std::vector<Tick>& ticks, const std::string& label) {
    Panel bar;
    bar.left = left;
    bar.bottom = bottom;
    bar.width = 0.35;
    bar.height = height;
    Boxes boxes;
    for (std::size_t i = 0; i < colours.size(); ++i) {
        boxes.left.push_back(0.0);
        boxes.right.push_back(1.0);
        boxes.bottom.push_back(static_cast<double>(i));
        boxes.top.push_back(static_cast<double>(i + 1));
    }
    boxes.colours = colours;
    bar.layers.emplace_back(std::move(boxes));
    bar.y.high = static_cast<double>(colours.size());
    bar.y.ticks = ticks;
    bar.y.at_far_side = true;
    bar.title = "";
    bar.notes.push_back({-0.3, 1.0 + 0.32 / height, label});
    return bar;
}

// A way of light colour with a dark border, and squares at its ends.
void draw_way(Panel& panel, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& ends_x, const std::vector<double>& ends_y) {
    for (const bool outer : {true, false}) {
        panel.layers.emplace_back(Line{.x = x, .y = y, .colour = outer ? black : white, .width = outer ? 2.8 : 1.4});
    }
    for (const bool outer : {true, false}) {
        panel.layers.emplace_back(Line{.x = ends_x,
                                       .y = ends_y,
                                       .colour = outer ? black : white,
                                       .width = 0.0,
                                       .marker = Marker::square,
                                       .marker_size = outer ? 1.4 : 0.9});
    }
}

// Marks and what they mean, below each other from the top; each is drawn into a square at the left.
class Key {
public:
    Key(double left, double top) {
        panel_.left = left;
        panel_.bottom = top - 0.5;
        panel_.width = 6.0;
        panel_.height = 0.5;
        panel_.framed = false;
        panel_.x.high = 6.0;
        panel_.y.low = -1.0;
        panel_.y.high = 0.0;
    }
    void line(Colour colour, bool dashed, double width, const std::string& words) {
        Line line{.x = {0.0, 0.55}, .y = {middle(), middle()}, .colour = colour, .width = width, .dashed = dashed};
        panel_.layers.emplace_back(std::move(line));
        text(words);
    }
    void minimum(const std::string& words) {
        for (const bool outer : {true, false}) {
            Line mark;
            mark.x = {0.275};
            mark.y = {middle()};
            mark.width = 0.0;
            mark.marker = Marker::circle;
            mark.marker_size = outer ? 1.5 : 0.95;
            mark.colour = outer ? black : white;
            panel_.layers.emplace_back(std::move(mark));
        }
        text(words);
    }
    void valley(const std::string& words) {
        draw_way(panel_, {0.0, 0.55}, {middle(), middle()}, {0.55}, {middle()});
        text(words);
    }
    void box(Colour colour, bool hatched, const std::string& words) {
        Boxes boxes{{0.0}, {0.55}, {middle() - 0.32}, {middle() + 0.32}, {colour}, false};
        if (hatched) {
            add_hatched(panel_, std::move(boxes));
        } else {
            panel_.layers.emplace_back(std::move(boxes));
        }
        text(words);
    }
    // How far it reaches to the right of its left edge, cm.
    double reach() const { return 0.75 + 0.165 * static_cast<double>(longest_); }
    Panel done() {
        // Rows are 1 apart whatever the height of the panel.
        const double rows = std::max(1.0, count_);
        panel_.bottom += 0.5 - 0.5 * rows;
        panel_.height = 0.5 * rows;
        panel_.y.low = -rows;
        for (Note& note : panel_.notes) {
            note.y = 1.0 + note.y / rows;
        }
        return std::move(panel_);
    }

private:
    double middle() const { return -count_ - 0.5; }
    void text(const std::string& words) {
        panel_.notes.push_back({0.75 / 6.0, middle(), words});
        count_ += 1.0;
        longest_ = std::max(longest_, words.size());
    }
    std::size_t longest_ = 0; // letters
    Panel panel_;
    double count_ = 0.0;
};

// Values without one are the mean of their neighbours', from the edge of a hole inwards: contours end at the hole as
// they came.
std::vector<double> without_holes(std::vector<double> z, std::size_t nx) {
    const std::size_t ny = z.size() / nx;
    for (bool again = true; again;) {
        again = false;
        std::vector<double> filled = z;
        for (std::size_t n = 0; n < z.size(); ++n) {
            if (!std::isnan(z[n])) {
                continue;
            }
            double sum = 0.0;
            int count = 0;
            const std::size_t i = n % nx;
            const std::size_t j = n / nx;
            const auto take = [&](bool there, std::size_t other) {
                if (there && !std::isnan(z[other])) {
                    sum += z[other];
                    ++count;
                }
            };
            take(i > 0, n - 1);
            take(i + 1 < nx, n + 1);
            take(j > 0, n - nx);
            take(j + 1 < ny, n + nx);
            if (count > 0) {
                filled[n] = sum / count;
                again = true;
            }
        }
        z = std::move(filled);
    }
    return z;
}

// What a line of nodes stands for: from half way to the one before to half way to the one after.
std::vector<double> edges_of(const std::vector<double>& lines) {
    std::vector<double> edges{lines.front()};
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        edges.push_back(0.5 * (lines[i] + lines[i + 1]));
    }
    edges.push_back(lines.back());
    return edges;
}

struct Pair {
    std::size_t x = 0, y = 0; // parameters
    Grid grid;                // unit coordinates; z the rise, not a number: no answer
};

void draw_pair(Panel& panel, const Corner& corner, const Pair& pair, const std::vector<double>& levels, double limit) {
    const Parameter& px = corner.parameters[pair.x];
    const Parameter& py = corner.parameters[pair.y];
    const std::size_t nx = pair.grid.x.size();
    Grid grid = pair.grid;
    const bool any = std::any_of(grid.z.begin(), grid.z.end(), [](double z) { return !std::isnan(z); });
    if (any) {
        grid.z = without_holes(grid.z, nx);
        Grid fine = refined(grid, 4);
        for (double& z : fine.z) {
            z = std::sqrt(std::max(0.0, z)); // nearly linear around a minimum
        }
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

std::size_t index_of(const std::vector<Parameter>& parameters, const Json& name) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const Parameter& p) { return p.name == name.get<std::string>(); });
    if (found == parameters.end()) {
        throw std::out_of_range("a pair of a parameter that the result does not have");
    }
    return static_cast<std::size_t>(found - parameters.begin());
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

std::vector<Parameter> parameters_of(const Json& list) {
    return {list.begin(), list.end()};
}

DataTable minima_table(const Json& minima, const std::vector<Parameter>& parameters) {
    DataTable table{"minima", {"minimum", "accepted", "misfit"}, {}};
    for (const Parameter& p : parameters) {
        table.columns.push_back(p.name);
    }
    for (const Json& m : minima) {
        std::vector<std::string> row{fmt::format("{}", table.rows.size() + 1),
                                     m.contains("accepted") ? (m.at("accepted") ? "yes" : "no") : "",
                                     cell(number_or_none(m.value("misfit", Json())))};
        for (const Parameter& p : parameters) {
            row.push_back(cell(number_or_none(m.at("parameters").at(p.name))));
        }
        table.rows.push_back(std::move(row));
    }
    return table;
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
        Pair pair;
        pair.x = index_of(corner.parameters, json.at("x"));
        pair.y = index_of(corner.parameters, json.at("y"));
        const auto x = numbers_of(json.at("x_values"));
        const auto y = numbers_of(json.at("y_values"));
        pair.grid = {corner.parameters[pair.x].units(x), corner.parameters[pair.y].units(y), {}};
        for (std::size_t j = 0; j < y.size(); ++j) {
            for (std::size_t i = 0; i < x.size(); ++i) {
                const double rise = number_or_none(json.at("rise").at(j).at(i));
                pair.grid.z.push_back(rise);
                highest = std::max(highest, std::isnan(rise) ? 0.0 : rise);
                nodes.rows.push_back({corner.parameters[pair.x].name, corner.parameters[pair.y].name, cell(x[i]),
                                      cell(y[j]), cell(rise)});
            }
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

Figure sampled_landscape_figure(const Json& evaluations, const Json& parameters, const Json& minima) {
    const Corner corner(parameters);
    const std::size_t n = corner.parameters.size();
    Figure figure{.name = "landscape", .width = corner.width(), .height = corner.height()};
    DataTable points{"landscape", {"status", "misfit"}, {}};
    for (const Parameter& p : corner.parameters) {
        points.columns.push_back(p.name);
    }
    struct Point {
        double misfit = none;
        std::vector<double> unit;
    };
    std::vector<Point> all;
    std::vector<double> misfits;
    for (const Json& row : evaluations.at("rows")) {
        Point point{number_or_none(row.at(1)), {}};
        std::vector<std::string> cells{row.at(0).get<std::string>(), cell(point.misfit)};
        for (std::size_t k = 0; k < n; ++k) {
            const double value = row.at(2 + k).get<double>();
            point.unit.push_back(corner.parameters[k].unit(value));
            cells.push_back(cell(value));
        }
        if (!std::isnan(point.misfit)) {
            misfits.push_back(point.misfit);
        }
        all.push_back(std::move(point));
        points.rows.push_back(std::move(cells));
    }
    std::sort(misfits.begin(), misfits.end());
    const double lowest = misfits.empty() ? 1.0 : std::max(misfits.front(), 1e-12);
    // Of all but the worst tenth.
    const double highest = misfits.empty() ? 2.0 : std::max(misfits[(misfits.size() - 1) * 9 / 10], 1.05 * lowest);
    const auto share = [&](double misfit) { return std::log(misfit / lowest) / std::log(highest / lowest); };

    constexpr int shades = 48;
    const auto shade = [&](double at) {
        return cividis((std::floor(std::clamp(at, 0.0, 0.999) * shades) + 0.5) / shades);
    };

    // A grid has a cell a value, other points so many cells that a few fall in each.
    const auto cells_of = [&](std::size_t k) {
        std::vector<double> values;
        values.reserve(all.size());
        for (const Point& point : all) {
            values.push_back(point.unit[k]);
        }
        std::sort(values.begin(), values.end());
        std::vector<double> distinct;
        for (const double v : values) {
            if (distinct.empty() || v > distinct.back() + 1e-9) {
                distinct.push_back(v);
            }
        }
        if (distinct.size() > 1 && distinct.size() <= 40 && distinct.size() * 4 <= values.size()) {
            auto edges = edges_of(distinct);
            edges.front() = 0.0;
            edges.back() = 1.0;
            return edges;
        }
        const int count = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(all.size()) / 3.0)), 4, 30);
        std::vector<double> edges;
        for (int i = 0; i <= count; ++i) {
            edges.push_back(static_cast<double>(i) / count);
        }
        return edges;
    };
    std::vector<std::vector<double>> edges;
    for (std::size_t k = 0; k < n; ++k) {
        edges.push_back(cells_of(k));
    }
    const auto cell_at = [](const std::vector<double>& of, double unit) {
        const auto above = std::upper_bound(of.begin() + 1, of.end() - 1, unit);
        return static_cast<std::size_t>(above - of.begin()) - 1;
    };
    bool holes = false;
    for (std::size_t x = 0; x < n; ++x) {
        for (std::size_t y = x; y < n; ++y) {
            Panel panel = corner.panel(x, y);
            const Parameter& px = corner.parameters[x];
            const Parameter& py = corner.parameters[y];
            std::map<std::pair<std::size_t, std::size_t>, double> low; // not a number: tried, no answer
            for (const Point& point : all) {
                const std::pair at{cell_at(edges[x], point.unit[x]), y == x ? 0 : cell_at(edges[y], point.unit[y])};
                double& value = low.try_emplace(at, none).first->second;
                if (!std::isnan(point.misfit) && !(value <= point.misfit)) {
                    value = point.misfit;
                }
            }
            if (y == x) {
                Line line;
                line.width = 1.5;
                line.colour = okabe_ito[0];
                for (const auto& [at, misfit] : low) {
                    for (const std::size_t side : {at.first, at.first + 1}) {
                        line.x.push_back(px.physical(edges[x][side]));
                        line.y.push_back(std::min(misfit, 100.0 * highest));
                    }
                }
                panel.layers.emplace_back(std::move(line));
                panel.y.low = lowest / std::pow(highest / lowest, 0.06);
                panel.y.high = highest;
                panel.y.log = true;
                panel.y.ticks = round_ticks(panel.y.low, highest, true, 4);
                panel.y.labelled = x == 0;
                panel.y.label = x == 0 ? "lowest misfit" : "";
                figure.panels.push_back(std::move(panel));
                continue;
            }
            Boxes boxes;
            Boxes failed;
            for (const auto& [at, misfit] : low) {
                Boxes& to = std::isnan(misfit) ? failed : boxes;
                to.left.push_back(px.physical(edges[x][at.first]));
                to.right.push_back(px.physical(edges[x][at.first + 1]));
                to.bottom.push_back(py.physical(edges[y][at.second]));
                to.top.push_back(py.physical(edges[y][at.second + 1]));
                if (!std::isnan(misfit)) {
                    to.colours.push_back(shade(share(misfit)));
                }
            }
            panel.layers.emplace_back(std::move(boxes));
            if (!failed.left.empty()) {
                holes = true;
                add_hatched(panel, std::move(failed));
            }
            add_minima(panel, minima, px, &py);
            figure.panels.push_back(std::move(panel));
        }
    }
    std::vector<Colour> colours;
    colours.reserve(shades);
    for (int i = 0; i < shades; ++i) {
        colours.push_back(shade((i + 0.5) / shades));
    }
    std::vector<Tick> ticks = round_ticks(lowest, highest, true, 6);
    for (Tick& tick : ticks) {
        tick.at = shades * share(tick.at);
    }
    double left = corner.key_left();
    if (n < 3) {
        left = corner.width() + 0.4;
    }
    Key key(left, corner.key_top());
    key.minimum(minima.size() > 1 ? "minima" : "lowest point");
    if (holes) {
        key.box(grey, true, "no answer of the model");
    }
    key.box(white, false, "white: nothing was computed");
    figure.width = std::max(figure.width, left + key.reach() + 0.2);
    Panel explained = key.done();
    const double bar_height = std::min(3.6, std::max(2.4, corner.side));
    figure.panels.push_back(colour_bar(left, explained.bottom - 0.95 - bar_height, bar_height, colours, ticks,
                                       "lowest misfit computed in a cell"));
    figure.panels.push_back(std::move(explained));
    figure.tables = {std::move(points), minima_table(minima, corner.parameters)};
    return figure;
}

} // namespace explore::report

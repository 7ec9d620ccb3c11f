#include "report/figure_corner.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

// Over two lines where the panel is too narrow for one.
std::string fitting(const AxisWords& words, double width) {
    constexpr double letter = 0.16; // cm
    std::string line = words.line();
    return static_cast<double>(line.size()) * letter <= width ? line : words.lines();
}

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

} // namespace

std::vector<double> numbers_of(const Json& list) {
    std::vector<double> values;
    std::transform(list.begin(), list.end(), std::back_inserter(values), number_or_none);
    return values;
}

std::vector<Parameter> parameters_of(const Json& list) {
    return {list.begin(), list.end()};
}

std::size_t index_of(const std::vector<Parameter>& parameters, const Json& name) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const Parameter& p) { return p.name == name.get<std::string>(); });
    if (found == parameters.end()) {
        throw std::out_of_range("a pair of a parameter that the result does not have");
    }
    return static_cast<std::size_t>(found - parameters.begin());
}

void add_minima(Panel& panel, const Json& minima, const Parameter& x, const Parameter* y, double height) {
    panel.layers.emplace_back(minima_marks(minima, x, y, height, true));
    panel.layers.emplace_back(minima_marks(minima, x, y, height, false));
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

std::vector<double> edges_of(const std::vector<double>& lines) {
    std::vector<double> edges{lines.front()};
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        edges.push_back(0.5 * (lines[i] + lines[i + 1]));
    }
    edges.push_back(lines.back());
    return edges;
}

Parameter::Parameter(const Json& json)
    : name(json.at("name").get<std::string>()),
      low(json.at("min").get<double>()),
      high(json.at("max").get<double>()),
      log(json.at("scale") == "log") {}

double Parameter::unit(double value) const {
    return log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
}

double Parameter::physical(double unit) const {
    return log ? low * std::pow(high / low, unit) : low + unit * (high - low);
}

std::vector<double> Parameter::units(const std::vector<double>& values) const {
    std::vector<double> all;
    all.reserve(values.size());
    for (const double value : values) {
        all.push_back(unit(value));
    }
    return all;
}

Corner::Corner(const Json& list) {
    for (const Json& p : list) {
        parameters.emplace_back(p);
    }
    static constexpr double sides[] = {7.0, 5.4, 4.4, 3.6, 2.95, 2.45};
    const std::size_t n = parameters.size();
    side = n == 0 ? 7.0 : n <= 6 ? sides[n - 1] : 2.1;
}

double Corner::reach() const {
    const auto n = static_cast<double>(parameters.size());
    return n * side + (n - 1.0) * gap;
}

PlotAxis Corner::axis(std::size_t k, bool named) const {
    const Parameter& p = parameters[k];
    PlotAxis axis;
    axis.low = p.physical(p.from);
    axis.high = p.physical(p.to);
    axis.log = p.log;
    const auto share = [&](const Tick& tick) { return (p.unit(tick.at) - p.from) / (p.to - p.from); };
    const auto ticks = [&](bool log, int most) {
        auto all = round_ticks(axis.low, axis.high, log, most);
        // None at the ends, where the next panel begins.
        std::erase_if(all, [&](const Tick& tick) { return std::abs(share(tick) - 0.5) > 0.46; });
        // Nor two so near that their texts touch.
        constexpr double letter = 0.16; // cm
        double free = -1.0;             // from there on, cm
        std::erase_if(all, [&](const Tick& tick) {
            const double half = 0.5 * letter * static_cast<double>(tick.text.size());
            const double at = share(tick) * side;
            const bool touches = at - half < free;
            free = touches ? free : at + half + 0.5 * letter;
            return touches;
        });
        return all;
    };
    constexpr double wide = 3.0; // less is labelled evenly
    const int most = side < 2.5 ? 3 : 4;
    axis.ticks = ticks(p.log && axis.high > wide * axis.low, most);
    for (int more = most; axis.ticks.size() < 2 && more <= 2 * most; ++more) { // one says nothing of the scale
        axis.ticks = ticks(false, more);
    }
    axis.labelled = named;
    axis.label = named ? fitting(axis_words(p.name), side) : "";
    return axis;
}

Panel Corner::panel(std::size_t column, std::size_t row) const {
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

Panel Corner::alone(std::size_t column, std::size_t row) const {
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

} // namespace explore::report

// Readings against what the draws of a posterior, or of the prior, predict of them, with their noise.
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {
namespace {

std::string words_of(const Json& row) {
    if (row.contains("name")) {
        return row.at("name").get<std::string>();
    }
    const auto number = [&](const char* key) { return row.at(key).get<double>(); };
    std::string text = fmt::format("{} {} at {:g} mm", row.at("load").get<std::string>(),
                                   row.at("quantity").get<std::string>(), number("x_mm"));
    if (number("depth_mm") != 0.0) {
        text += fmt::format(", {:g} mm deep", number("depth_mm"));
    }
    return text + (row.contains("time_ms") ? fmt::format(", {:g} ms", number("time_ms")) : "");
}

} // namespace

Figure predictive_figure(const Json& rows, const std::string& name) {
    const auto count = static_cast<double>(rows.size());
    constexpr double row_height = 0.4;
    Figure figure{.name = name, .width = 13.5};
    Panel panel;
    panel.left = 4.4;
    panel.bottom = 1.2;
    panel.width = 8.7;
    panel.height = row_height * count;
    figure.height = panel.bottom + panel.height + 0.4;
    DataTable table{name, {"reading", "measured", "low", "median", "high", "unit", "pit"}, {}};
    Boxes ranges{.colours = {0xE1E6EA}};
    Line inside{.colour = okabe_ito[0], .width = 0.0, .marker = Marker::circle, .marker_size = 1.1};
    Line outside{.colour = okabe_ito[1], .width = 0.0, .marker = Marker::square, .marker_size = 1.1};
    double most = 1.5;
    double at = 0.0;
    for (const Json& row : rows) {
        const double median = row.at("median").get<double>();
        const double low = row.at("low").get<double>();
        const double high = row.at("high").get<double>();
        const double half = 0.5 * (high - low);
        ranges.left.push_back((low - median) / half);
        ranges.right.push_back((high - median) / half);
        ranges.bottom.push_back(at - 0.35);
        ranges.top.push_back(at + 0.35);
        Line& line = row.at("inside").get<bool>() ? inside : outside;
        line.x.push_back((row.at("measured").get<double>() - median) / half);
        line.y.push_back(at);
        most = std::max({most, std::abs(line.x.back()), ranges.right.back(), -ranges.left.back()});
        panel.y.ticks.push_back({at, words_of(row)});
        table.rows.push_back({words_of(row), cell(row.at("measured").get<double>()), cell(low), cell(median),
                              cell(high), row.at("unit").get<std::string>(), cell(row.at("pit").get<double>())});
        at += 1.0;
    }
    most *= 1.08;
    panel.layers.emplace_back(std::move(ranges));
    panel.layers.emplace_back(Line{.x = {0.0, 0.0}, .y = {-0.5, count - 0.5}, .colour = black, .width = 0.8});
    for (Line* line : {&inside, &outside}) {
        if (!line->x.empty()) {
            panel.layers.emplace_back(std::move(*line));
        }
    }
    panel.x.low = -most;
    panel.x.high = most;
    panel.x.ticks = round_ticks(-most, most, false, 8);
    panel.x.label = "reading - median prediction (half-widths of its 95 % range)";
    panel.y.low = -0.5;
    panel.y.high = count - 0.5;
    panel.y.reversed = true;
    figure.panels.push_back(std::move(panel));
    figure.tables = {std::move(table)};
    return figure;
}

} // namespace explore::report

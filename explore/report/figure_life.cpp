// The decision of `design`: each life against the probability that it is shorter, the overlay against the reliability.
#include "report/figures.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace explore::report {
namespace {

Panel framed(std::string x, std::string y) {
    Panel panel;
    panel.left = 2.0;
    panel.width = 9.0;
    panel.height = 6.0;
    panel.grid = true;
    panel.x.label = std::move(x);
    panel.y.label = std::move(y);
    return panel;
}

PlotAxis percent_axis(std::string label) {
    PlotAxis axis{.label = std::move(label), .low = 0.0, .high = 100.0};
    axis.ticks = round_ticks(0.0, 100.0, false, 6);
    return axis;
}

} // namespace

Figure life_figure(const Json& design) {
    DataTable table{"life", {"criterion", "allowable", "probability"}, {}};
    Panel panel = framed("repetitions of the axle (millions)", "probability that\nthe life is shorter (%)");
    panel.y = percent_axis(panel.y.label);
    double low = none;
    double high = none;
    std::size_t number = 0;
    for (const Json& criterion : design.at("criteria")) {
        const auto name = criterion.at("name").get<std::string>();
        Line line{.colour = okabe_ito[number++ % std::size(okabe_ito)], .width = 1.6, .name = name};
        for (const Json& point : criterion.value("distribution", Json::array())) {
            const double life = number_or_none(point.at("allowable"));
            const double probability = point.at("probability").get<double>();
            if (!(life > 0.0)) {
                continue;
            }
            line.x.push_back(life);
            line.y.push_back(100.0 * probability);
            low = std::fmin(low, life);
            high = std::fmax(high, life);
            table.rows.push_back({name, cell(life), cell(probability)});
        }
        if (!line.x.empty()) {
            const double required = criterion.at("required").get<double>();
            low = std::fmin(low, required);
            high = std::fmax(high, required);
            panel.layers.emplace_back(Line{.x = {required, required},
                                           .y = {0.0, 100.0},
                                           .colour = line.colour,
                                           .width = 1.0,
                                           .dashed = true,
                                           .name = name + ", required"});
            panel.layers.emplace_back(std::move(line));
        }
    }
    constexpr double beside = 1.5;
    panel.x.low = low / beside;
    panel.x.high = high * beside;
    panel.x.log = true;
    panel.x.ticks = round_ticks(panel.x.low, panel.x.high, true, 6);
    constexpr double million = 1e6;
    for (Tick& tick : panel.x.ticks) {
        tick.text = fmt::format("{:.6g}", tick.at / million);
    }
    panel.bottom = 1.3 + legend_height(panel);
    Figure figure{.name = "life", .width = 11.6, .height = panel.bottom + panel.height + 0.4};
    figure.panels.push_back(std::move(panel));
    figure.tables = {std::move(table)};
    return figure;
}

Figure overlay_figure(const Json& design) {
    const Json& overlay = design.at("overlay_mm");
    DataTable table{"overlay", {"reliability_percent", "overlay_mm"}, {}};
    Panel panel = framed("reliability over what the data accept (%)",
                         fmt::format("overlay on the {} (mm)", overlay.at("layer").get<std::string>()));
    panel.x = percent_axis(panel.x.label);
    std::vector<std::pair<double, double>> points;
    const auto add = [&](double reliability, const char* key) {
        if (const double mm = number_or_none(overlay.at(key)); std::isfinite(mm)) {
            points.emplace_back(reliability, mm);
        }
    };
    add(2.5, "low");
    add(50.0, "value");
    add(overlay.at("reliability_percent").get<double>(), "at_reliability");
    add(97.5, "high");
    std::sort(points.begin(), points.end());
    Line line{.colour = okabe_ito[0], .width = 1.4, .marker = Marker::circle, .marker_size = 1.1};
    double low = 0.0;
    double high = 10.0;
    for (const auto& [reliability, mm] : points) {
        line.x.push_back(reliability);
        line.y.push_back(mm);
        low = std::min(low, mm);
        high = std::max(high, mm);
        table.rows.push_back({cell(reliability), cell(mm)});
    }
    const double margin = 0.08 * (high - low);
    panel.y.low = low - margin;
    panel.y.high = high + margin;
    panel.y.ticks = round_ticks(panel.y.low, panel.y.high, false, 6);
    panel.layers.emplace_back(std::move(line));
    panel.bottom = 1.3;
    Figure figure{.name = "overlay", .width = 11.6, .height = panel.bottom + panel.height + 0.4};
    figure.panels.push_back(std::move(panel));
    figure.tables = {std::move(table)};
    return figure;
}

} // namespace explore::report

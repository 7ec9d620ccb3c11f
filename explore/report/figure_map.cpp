// The misfit where it was computed, over every pair of parameters: a cell a node of a grid, else a mark a point. No
// mark stands for what lies between.
#include "report/figure_corner.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace explore::report {

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

    // Edges of the cells of a grid, one a value; empty: the points are not on one.
    const auto cells_of = [&](std::size_t k) -> std::vector<double> {
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
        return {};
    };
    std::vector<std::vector<double>> edges;
    for (std::size_t k = 0; k < n; ++k) {
        edges.push_back(cells_of(k));
    }
    const auto cell_at = [](const std::vector<double>& of, double unit) {
        const auto above = std::upper_bound(of.begin() + 1, of.end() - 1, unit);
        return static_cast<std::size_t>(above - of.begin()) - 1;
    };
    const bool is_grid = std::none_of(edges.begin(), edges.end(), [](const auto& of) { return of.empty(); });
    // The points in the order of drawing, the lowest last, above the others.
    std::vector<const Point*> highest_first;
    std::transform(all.begin(), all.end(), std::back_inserter(highest_first), [](const Point& p) { return &p; });
    std::stable_sort(highest_first.begin(), highest_first.end(), [](const Point* a, const Point* b) {
        return std::isnan(a->misfit) ? !std::isnan(b->misfit) : a->misfit > b->misfit;
    });
    const auto draw_points = [&](Panel& panel, const auto& place_of) {
        std::vector<Line> marks; // of one colour each, as they follow each other
        for (const Point* point : highest_first) {
            const Colour colour = std::isnan(point->misfit) ? grey : shade(share(point->misfit));
            if (marks.empty() || marks.back().colour != colour) {
                const Marker marker = std::isnan(point->misfit) ? Marker::open_circle : Marker::circle;
                marks.push_back({.colour = colour, .width = 0.0, .marker = marker, .marker_size = 0.45});
            }
            const auto [at_x, at_y] = place_of(*point);
            marks.back().x.push_back(at_x);
            marks.back().y.push_back(at_y);
        }
        panel.layers.insert(panel.layers.end(), marks.begin(), marks.end());
    };
    bool holes = false;
    for (std::size_t x = 0; x < n; ++x) {
        for (std::size_t y = x; y < n; ++y) {
            Panel panel = corner.panel(x, y);
            const Parameter& px = corner.parameters[x];
            const Parameter& py = corner.parameters[y];
            std::map<std::pair<std::size_t, std::size_t>, double> low; // not a number: tried, no answer
            for (const Point& point : is_grid ? all : std::vector<Point>{}) {
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
                if (is_grid) {
                    panel.layers.emplace_back(std::move(line));
                } else {
                    draw_points(panel, [&](const Point& p) {
                        return std::pair{px.physical(p.unit[x]), std::min(p.misfit, 100.0 * highest)};
                    });
                }
                panel.y.low = lowest / std::pow(highest / lowest, 0.06);
                panel.y.high = highest;
                panel.y.log = true;
                panel.y.ticks = round_ticks(panel.y.low, highest, true, 4);
                panel.y.labelled = x == 0;
                panel.y.label = x != 0 ? "" : is_grid ? "lowest misfit" : "misfit";
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
            if (is_grid) {
                panel.layers.emplace_back(std::move(boxes));
            } else {
                draw_points(panel, [&](const Point& p) {
                    return std::pair{px.physical(p.unit[x]), py.physical(p.unit[y])};
                });
            }
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
    if (!is_grid && misfits.size() < all.size()) {
        key.mark({.colour = grey, .marker = Marker::open_circle, .marker_size = 0.6}, "no answer of the model");
    }
    if (is_grid) {
        key.box(white, false, "white: nothing was computed");
    } else {
        key.text("each mark: a computed point;");
        key.text("nothing is known between them");
    }
    figure.width = std::max(figure.width, left + key.reach() + 0.2);
    Panel explained = key.done();
    const double bar_height = std::min(3.6, std::max(2.4, corner.side));
    figure.panels.push_back(colour_bar(left, explained.bottom - 0.95 - bar_height, bar_height, colours, ticks,
                                       is_grid ? "lowest misfit computed in a cell" : "misfit"));
    figure.panels.push_back(std::move(explained));
    figure.tables = {std::move(points), minima_table(minima, corner.parameters)};
    return figure;
}

} // namespace explore::report

// The posterior of the parameters that `sample` draws: every pair, and each alone.
#include "report/figure_corner.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace explore::report {
namespace {

constexpr int bins = 24;

// Draws with their weights, 1 on average; places in the unit interval of each parameter.
struct Draws {
    std::vector<double> weight;
    std::vector<std::vector<double>> unit; // of each parameter
};

Draws draws_of(const Json& rows, const std::vector<Parameter>& parameters) {
    Draws draws{{}, std::vector<std::vector<double>>(parameters.size())};
    for (const Json& row : rows) {
        draws.weight.push_back(row.at(0).get<double>());
        for (std::size_t k = 0; k < parameters.size(); ++k) {
            draws.unit[k].push_back(parameters[k].unit(row.at(1 + k).get<double>()));
        }
    }
    return draws;
}

// Density over that of a parameter that is uniform in its box.
struct Marginal {
    std::vector<double> edges, density; // unit interval
};

Marginal marginal_of(const std::vector<double>& unit, const std::vector<double>& weight, const Parameter& p) {
    Marginal marginal;
    const double low = std::max(0.0, p.from);
    const double width = (std::min(1.0, p.to) - low) / bins;
    for (int b = 0; b <= bins; ++b) {
        marginal.edges.push_back(low + b * width);
    }
    marginal.density.resize(bins);
    double sum = 0.0;
    for (std::size_t i = 0; i < unit.size(); ++i) {
        const auto bin = static_cast<int>((unit[i] - low) / width);
        marginal.density[static_cast<std::size_t>(std::clamp(bin, 0, bins - 1))] += weight[i];
        sum += weight[i];
    }
    for (double& d : marginal.density) {
        d /= sum * width;
    }
    return marginal;
}

// The same of a prior, at a place of the unit interval; json: of the parameter.
double prior_density(const Json& json, const Parameter& p, double unit) {
    if (!json.contains("prior")) {
        return 1.0;
    }
    const double mean = p.unit(json.at("prior").at("mean").get<double>());
    const double sd = json.at("prior").at("sd").get<double>() / (p.log ? std::log(p.high / p.low) : p.high - p.low);
    const auto below = [&](double u) { return 0.5 * std::erfc(-(u - mean) / sd / std::numbers::sqrt2); };
    const double z = (unit - mean) / sd;
    return std::exp(-0.5 * z * z) / (sd * std::sqrt(2.0 * std::numbers::pi)) / (below(1.0) - below(0.0));
}

// Draws and the regions that hold most of them, and a little more; bounds that are there are seen from inside.
void look_at(Parameter& p, const std::vector<double>& unit, const Json& regions) {
    auto [low, high] = std::ranges::minmax(unit);
    for (const Json& region : regions) {
        for (const std::size_t along : {0, 1}) {
            if (region.at(along == 0 ? "x" : "y") != p.name) {
                continue;
            }
            for (const Json& border : region.at("borders")) {
                for (const Json& at : border) {
                    low = std::min(low, p.unit(at.at(along).get<double>()));
                    high = std::max(high, p.unit(at.at(along).get<double>()));
                }
            }
        }
    }
    const double margin = 0.06 * std::max(high - low, 1e-6);
    p.from = std::max(low - margin, -margin);
    p.to = std::min(high + margin, 1.0 + margin);
}

// The part beyond the bounds of x and (not of a marginal) y.
bool add_outside(Panel& panel, const Parameter& x, const Parameter* y) {
    Boxes outside;
    const double low_y = y != nullptr ? y->physical(y->from) : panel.y.low;
    const double high_y = y != nullptr ? y->physical(y->to) : panel.y.high;
    const auto add = [&](double left, double right, double bottom, double top) {
        outside.left.push_back(left);
        outside.right.push_back(right);
        outside.bottom.push_back(bottom);
        outside.top.push_back(top);
    };
    if (x.from < 0.0) {
        add(x.physical(x.from), x.low, low_y, high_y);
    }
    if (x.to > 1.0) {
        add(x.high, x.physical(x.to), low_y, high_y);
    }
    if (y != nullptr && y->from < 0.0) {
        add(x.physical(x.from), x.physical(x.to), low_y, y->low);
    }
    if (y != nullptr && y->to > 1.0) {
        add(x.physical(x.from), x.physical(x.to), y->high, high_y);
    }
    const bool any = !outside.left.empty();
    add_hatched(panel, std::move(outside));
    return any;
}

// Larger where they weigh more, in quarters of the largest weight.
void add_draws(Panel& panel, const Draws& draws, std::size_t x, std::size_t y,
               const std::vector<Parameter>& parameters) {
    const double most = *std::max_element(draws.weight.begin(), draws.weight.end());
    constexpr int classes = 4;
    for (int c = 1; c <= classes; ++c) {
        Line line{.colour = okabe_ito[5],
                  .width = 0.0,
                  .marker = Marker::circle,
                  .marker_size = 0.5 * std::sqrt(static_cast<double>(c) / classes)};
        for (std::size_t i = 0; i < draws.weight.size(); ++i) {
            if (std::clamp(static_cast<int>(std::ceil(classes * draws.weight[i] / most)), 1, classes) == c) {
                line.x.push_back(parameters[x].physical(draws.unit[x][i]));
                line.y.push_back(parameters[y].physical(draws.unit[y][i]));
            }
        }
        if (!line.x.empty()) {
            panel.layers.emplace_back(std::move(line));
        }
    }
}

Panel marginal_panel(Panel panel, const Json& json, const Parameter& p, const Marginal& marginal) {
    double highest = 0.0;
    Boxes bars{.colours = {0xBFDFF2}};
    for (std::size_t b = 0; b < marginal.density.size(); ++b) {
        bars.left.push_back(p.physical(marginal.edges[b]));
        bars.right.push_back(p.physical(marginal.edges[b + 1]));
        bars.bottom.push_back(0.0);
        bars.top.push_back(marginal.density[b]);
        highest = std::max(highest, marginal.density[b]);
    }
    Line prior{.colour = black, .width = 1.0, .dashed = true};
    constexpr int steps = 100;
    for (int i = 0; i <= steps; ++i) {
        const double unit = marginal.edges.front() + (marginal.edges.back() - marginal.edges.front()) * i / steps;
        prior.x.push_back(p.physical(unit));
        prior.y.push_back(prior_density(json, p, unit));
    }
    panel.y.low = 0.0;
    panel.y.high = 1.1 * std::max(highest, *std::max_element(prior.y.begin(), prior.y.end()));
    panel.layers.emplace_back(std::move(bars));
    for (const char* quantile : {"q025", "q50", "q975"}) {
        const double at = number_or_none(json.value(quantile, Json()));
        if (p.shows(at)) {
            panel.layers.emplace_back(Line{.x = {at, at},
                                           .y = {0.0, panel.y.high},
                                           .colour = okabe_ito[1],
                                           .width = quantile == std::string("q50") ? 1.6 : 0.9});
        }
    }
    panel.layers.emplace_back(std::move(prior));
    return panel;
}

} // namespace

Figure posterior_figure(const Json& sample) {
    const Json& list = sample.at("parameters");
    Corner corner(list);
    auto& parameters = corner.parameters;
    const std::size_t n = parameters.size();
    const Draws draws = draws_of(sample.at("draws"), parameters);
    DataTable table{"posterior-draws", {"weight"}, {}};
    DataTable ranges{"posterior", {}, {}};
    ranges.columns = {"name", "mean", "sd",  "q025",  "q50",        "q975",
                      "unit", "min",  "max", "scale", "prior_mean", "prior_sd"};
    DataTable marginals{"posterior-marginals", {"parameter", "from", "to", "density_over_uniform"}, {}};
    DataTable borders{"posterior-regions", {"x_parameter", "y_parameter", "border", "x", "y"}, {}};
    for (const Parameter& p : parameters) {
        table.columns.push_back(p.name);
    }
    for (const Json& row : sample.at("draws")) {
        std::vector<std::string>& cells = table.rows.emplace_back();
        std::transform(row.begin(), row.end(), std::back_inserter(cells),
                       [](const Json& value) { return cell(number_or_none(value)); });
    }
    const auto add_range = [&](const Json& of, const std::string& unit) {
        std::vector<std::string> cells{of.at("name").get<std::string>()};
        for (const char* key : {"mean", "sd", "q025", "q50", "q975"}) {
            cells.push_back(cell(number_or_none(of.at(key))));
        }
        const Json prior = of.value("prior", Json::object());
        cells.insert(cells.end(), {unit, cell(number_or_none(of.value("min", Json()))),
                                   cell(number_or_none(of.value("max", Json()))), of.value("scale", std::string()),
                                   cell(number_or_none(prior.value("mean", Json()))),
                                   cell(number_or_none(prior.value("sd", Json())))});
        ranges.rows.push_back(std::move(cells));
    };

    Figure figure{.name = "posterior", .width = corner.width(), .height = corner.height()};
    const Json regions = sample.value("regions", Json::array());
    for (std::size_t k = 0; k < n; ++k) {
        look_at(parameters[k], draws.unit[k], regions);
    }
    bool outside = false;
    for (std::size_t x = 0; x < n; ++x) {
        add_range(list.at(x), axis_words(parameters[x].name).unit);
        const Marginal marginal = marginal_of(draws.unit[x], draws.weight, parameters[x]);
        for (std::size_t b = 0; b < marginal.density.size(); ++b) {
            marginals.rows.push_back({parameters[x].name, cell(parameters[x].physical(marginal.edges[b])),
                                      cell(parameters[x].physical(marginal.edges[b + 1])), cell(marginal.density[b])});
        }
        Panel alone = marginal_panel(corner.panel(x, x), list.at(x), parameters[x], marginal);
        alone.y.label = x == 0 ? "density" : "";
        outside = add_outside(alone, parameters[x], nullptr) || outside;
        figure.panels.push_back(std::move(alone));
        for (std::size_t y = x + 1; y < n; ++y) {
            Panel panel = corner.panel(x, y);
            add_draws(panel, draws, x, y, parameters);
            outside = add_outside(panel, parameters[x], &parameters[y]) || outside;
            for (const Json& region : regions) {
                if (region.at("x") != parameters[x].name || region.at("y") != parameters[y].name) {
                    continue;
                }
                std::size_t number = 0;
                for (const Json& border : region.at("borders")) {
                    Line line{.colour = okabe_ito[1], .width = 1.4};
                    ++number;
                    for (const Json& at : border) {
                        line.x.push_back(at.at(0).get<double>());
                        line.y.push_back(at.at(1).get<double>());
                        borders.rows.push_back({parameters[x].name, parameters[y].name, fmt::format("{}", number),
                                                cell(line.x.back()), cell(line.y.back())});
                    }
                    panel.layers.emplace_back(std::move(line));
                }
            }
            figure.panels.push_back(std::move(panel));
        }
    }
    for (const Json& output : sample.value("outputs", Json::array())) {
        add_range(output, output.at("unit").get<std::string>());
    }

    const double left = n < 3 ? corner.width() + 0.4 : corner.key_left();
    Key key(left, corner.key_top());
    if (sample.at("status") != "converged") {
        key.text("the sample has not converged: no ranges");
    } else {
        key.line(okabe_ito[1], false, 1.6, "median; thin: the 95 % range");
    }
    if (n > 1) {
        key.line(okabe_ito[1], false, 1.4, "over pairs: holds 95 % of the draws");
        key.mark({.colour = okabe_ito[5], .marker = Marker::circle, .marker_size = 0.5},
                 "draws, the larger the more they weigh");
    }
    key.line(black, true, 1.0, "prior");
    if (outside) {
        key.box(grey, true, "beyond the bounds");
    }
    figure.width = std::max(figure.width, left + key.reach() + 0.2);
    figure.panels.push_back(key.done());
    figure.tables = {std::move(ranges), std::move(table), std::move(marginals)};
    if (!borders.rows.empty()) {
        figure.tables.push_back(std::move(borders));
    }
    return figure;
}

} // namespace explore::report

// The landscape of the misfit over one pair of parameters as a surface.
#include "report/figure_pair.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace explore::report {
namespace {

// Rises over a pair; what is above the top is cut off.
struct Relief {
    Grid grid; // unit coordinates
    double top = 1.0;

    // Between the nodes linear; none: beyond the box, or a hole.
    double at(double x, double y) const {
        const auto cell = [](const std::vector<double>& lines, double v) {
            const auto above = std::upper_bound(lines.begin() + 1, lines.end() - 1, v);
            return static_cast<std::size_t>(above - lines.begin()) - 1;
        };
        if (x < grid.x.front() || x > grid.x.back() || y < grid.y.front() || y > grid.y.back()) {
            return none;
        }
        const std::size_t i = cell(grid.x, x);
        const std::size_t j = cell(grid.y, y);
        const double u = (x - grid.x[i]) / (grid.x[i + 1] - grid.x[i]);
        const double v = (y - grid.y[j]) / (grid.y[j + 1] - grid.y[j]);
        const auto z = [&](std::size_t a, std::size_t b) { return grid.z[b * grid.x.size() + a]; };
        return (1.0 - v) * ((1.0 - u) * z(i, j) + u * z(i + 1, j)) +
               v * ((1.0 - u) * z(i, j + 1) + u * z(i + 1, j + 1));
    }

    // Whether the eye sees a point of the surface.
    bool is_seen(double x, double y, double turned) const {
        const double azimuth = turned * std::numbers::pi / 180.0;
        const double tilt = space_tilt * std::numbers::pi / 180.0;
        constexpr double step = 0.01;
        const double rise = step / std::tan(tilt) / space_height * top;
        double z = at(x, y) + 0.01 * top;
        while (z < top) {
            x += step * std::sin(azimuth);
            y -= step * std::cos(azimuth);
            z += rise;
            const double surface = at(x, y);
            if (surface > z && surface < top) {
                return false;
            }
        }
        return true;
    }
};

// From where most of what the data accept, and of the minima, is seen.
double best_turn(const Relief& relief, double limit, const std::vector<std::pair<double, double>>& minima) {
    double best = 0.0;
    double most = -1.0;
    const std::size_t nx = relief.grid.x.size();
    for (const double within : {30.0, 60.0, 45.0, 15.0, 75.0}) {
        for (const double quarter : {0.0, 90.0, 180.0, 270.0}) {
            const double turned = quarter + within;
            double seen = 0.0;
            double all = 0.0;
            for (std::size_t n = 0; n < relief.grid.z.size(); ++n) {
                if (relief.grid.z[n] <= limit) {
                    all += 1.0;
                    seen += relief.is_seen(relief.grid.x[n % nx], relief.grid.y[n / nx], turned) ? 1.0 : 0.0;
                }
            }
            double share = all > 0.0 ? seen / all : 0.0;
            for (const auto& [x, y] : minima) {
                share += relief.is_seen(x, y, turned) ? 1.0 : 0.0;
            }
            if (share > most) {
                most = share;
                best = turned;
            }
        }
    }
    return best;
}

} // namespace

Figure surface_figure(const Json& unique, const NamedPair& wanted) {
    const Json& landscape = unique.at("landscape");
    const double limit = landscape.at("limit").get<double>();
    Corner corner(unique.at("parameters"));
    corner.side = Corner::large;
    const auto& json = *std::find_if(landscape.at("pairs").begin(), landscape.at("pairs").end(), [&](const Json& p) {
        return wanted.is(p.at("x").get<std::string>(), p.at("y").get<std::string>());
    });
    const Pair pair = pair_of(json, corner.parameters);
    const Parameter& px = corner.parameters[pair.x];
    const Parameter& py = corner.parameters[pair.y];
    Figure figure{.name = fmt::format("landscape-{}-{}-surface", px.name, py.name), .width = 13.6, .height = 12.6};
    DataTable nodes{figure.name, {px.name, py.name, "rise_of_chi2"}, {}};
    const std::size_t nx = pair.grid.x.size();
    for (std::size_t n = 0; n < pair.grid.z.size(); ++n) {
        nodes.rows.push_back(
            {cell(px.physical(pair.grid.x[n % nx])), cell(py.physical(pair.grid.y[n / nx])), cell(pair.grid.z[n])});
    }
    figure.tables = {std::move(nodes)};

    const double top = 10.0 * limit;
    Space space{.left = 0.4, .bottom = 2.0, .width = 12.2, .height = 10.6};
    space.x = corner.axis(pair.x, true);
    space.y = corner.axis(pair.y, true);
    space.x.label = axis_words(px.name).line();
    space.y.label = axis_words(py.name).line();
    space.z.high = top;
    space.z.ticks = round_ticks(0.0, top, false, 6);
    space.z.label = "rise of χ², the others fitted";
    constexpr int times = 4;
    Relief relief{pair.has_answers() ? fine_roots(pair.grid, times) : pair.grid, top};
    const Grid roots = relief.grid;
    bool holes = false;
    const std::size_t fine = relief.grid.x.size();
    for (std::size_t n = 0; n < relief.grid.z.size(); ++n) {
        const auto coarse = [](std::size_t k) { return (k + times / 2) / times; };
        const bool hole = std::isnan(pair.grid.z[coarse(n / fine) * nx + coarse(n % fine)]);
        relief.grid.z[n] = hole ? none : relief.grid.z[n] * relief.grid.z[n];
        holes = holes || hole;
    }
    for (const double x : relief.grid.x) {
        space.grid_x.push_back(px.physical(x));
    }
    for (const double y : relief.grid.y) {
        space.grid_y.push_back(py.physical(y));
    }
    space.high = relief.grid.z;
    const double lowest = limit / 12.0;
    for (const double z : space.high) {
        space.colours.push_back(cividis(std::log(std::clamp(z, lowest, top) / lowest) / std::log(top / lowest)));
    }

    const double lift = 0.004 * top; // of lines over the surface that they lie on
    const auto add = [&](Course& to, double x, double y) {
        const double z = relief.at(x, y);
        to.x.push_back(px.physical(x));
        to.y.push_back(py.physical(y));
        to.z.push_back(z <= top ? z + lift : none);
    };
    const auto gap = [](Course& in) {
        in.x.push_back(none);
        in.y.push_back(none);
        in.z.push_back(none);
    };
    Course mesh{.colour = 0x444444, .width = 0.3}; // what was computed
    for (const double y : pair.grid.y) {
        for (const double x : relief.grid.x) {
            add(mesh, x, y);
        }
        gap(mesh);
    }
    for (const double x : pair.grid.x) {
        for (const double y : relief.grid.y) {
            add(mesh, x, y);
        }
        gap(mesh);
    }
    space.lines.push_back(std::move(mesh));
    Course accepted{.colour = okabe_ito[1], .width = 1.8};
    if (pair.has_answers()) {
        for (const Contour& contour : contours(roots, {std::sqrt(limit)})) {
            for (std::size_t i = 0; i <= contour.x.size(); ++i) {
                add(accepted, contour.x[i % contour.x.size()], contour.y[i % contour.x.size()]);
            }
            gap(accepted);
        }
    }
    space.lines.push_back(std::move(accepted));
    std::vector<std::pair<double, double>> minima;
    for (const Json& m : unique.at("minima")) {
        if (m.value("accepted", true)) {
            minima.emplace_back(px.unit(m.at("parameters").at(px.name).get<double>()),
                                py.unit(m.at("parameters").at(py.name).get<double>()));
        }
    }
    for (const bool outer : {true, false}) {
        Course marks{
            .colour = outer ? black : white, .width = 0.0, .marker = Marker::circle, .marker_size = outer ? 1.8 : 1.1};
        for (const auto& [x, y] : minima) {
            add(marks, x, y);
        }
        space.lines.push_back(std::move(marks));
    }
    space.turned = best_turn(relief, limit, minima);
    figure.spaces.push_back(std::move(space));

    Key key(0.6, 1.6);
    key.line(okabe_ito[1], false, 1.8, fmt::format("accepted by the data: rise of χ² {:.3g}", limit));
    key.minimum(minima.size() > 1 ? "best fit and other accepted minima" : "best fit");
    key.line(0x444444, false, 0.3,
             fmt::format("mesh of computed values, cut off at {:.3g}{}", top,
                         holes ? "; hole: no answer of the model" : ""));
    figure.panels.push_back(key.done());
    return figure;
}

} // namespace explore::report

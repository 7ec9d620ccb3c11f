#include "report/figure.h"

#include "data/csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gsl/gsl_interp.h>
#include <map>
#include <memory>

namespace explore::report {
namespace {

// Text as gnuplot takes it literally: within single quotes neither commands nor escapes are looked for.
std::string quoted(const std::string& text) {
    std::string safe = "'";
    for (const char c : text) {
        if (c == '\'') {
            safe += "''";
        } else if (c == '\n') {
            safe += "'.\"\\n\".'";
        } else if (static_cast<unsigned char>(c) >= 0x20) {
            safe += c;
        }
    }
    return safe + "'";
}

std::string rgb(Colour colour) {
    return fmt::format("'#{:06X}'", colour);
}

std::string gnuplot_number(double value) {
    return std::isfinite(value) ? fmt::format("{:.8g}", value) : std::string("NaN");
}

int point_type(Marker marker) {
    switch (marker) {
    case Marker::none: return 0;
    case Marker::circle: return 7;
    case Marker::open_circle: return 6;
    case Marker::square: return 5;
    case Marker::diamond: return 13;
    case Marker::triangle: return 9;
    case Marker::star: return 3;
    }
    return 0;
}

constexpr double font_points = 8.0;

std::string terminal(const Figure& figure, FigureFormat format) {
    constexpr double inch = 2.54;
    constexpr double of_pango = 72.0 / 96.0; // by which its points are larger
    switch (format) {
    case FigureFormat::svg:
        return fmt::format("set terminal svg size {:.0f},{:.0f} font 'Arial,{}' background '#FFFFFF' noenhanced",
                           figure.width / inch * 96.0, figure.height / inch * 96.0, font_points * 96.0 / 72.0);
    case FigureFormat::pdf:
        return fmt::format("set terminal pdfcairo size {}cm,{}cm font 'Arial,{}' fontscale {} background '#FFFFFF' "
                           "noenhanced",
                           figure.width, figure.height, font_points, of_pango);
    case FigureFormat::png: {
        constexpr double dpi = 300.0;
        constexpr double scale = dpi / 72.0;
        return fmt::format("set terminal pngcairo size {:.0f},{:.0f} font 'Arial,{}' fontscale {:.4f} linewidth {:.4f} "
                           "pointscale {:.4f} background '#FFFFFF' noenhanced",
                           figure.width / inch * dpi, figure.height / inch * dpi, font_points, scale * of_pango, scale,
                           scale);
    }
    }
    return {};
}

// The plot elements of a panel: data blocks, and what `plot` is to draw of them.
struct Drawn {
    std::string blocks;
    std::vector<std::string> elements;
};

void add(Drawn& drawn, const std::string& name, const Line& line) {
    drawn.blocks += name + " << EOD\n";
    for (std::size_t i = 0; i < line.x.size(); ++i) {
        if (!std::isfinite(line.x[i]) || !std::isfinite(line.y[i])) {
            drawn.blocks += "\n";
            continue;
        }
        drawn.blocks += gnuplot_number(line.x[i]) + " " + gnuplot_number(line.y[i]);
        if (!line.error.empty()) {
            drawn.blocks += " " + gnuplot_number(line.error[i]);
        }
        drawn.blocks += "\n";
    }
    drawn.blocks += "EOD\n";
    const std::string title = line.name.empty() ? "notitle" : "title " + quoted(line.name);
    const std::string colour = "lc rgb " + rgb(line.colour);
    if (!line.error.empty()) {
        drawn.elements.push_back(fmt::format("{} using 1:2:3 with {} pt 0 lw 0.8 {} notitle", name,
                                             line.along_x ? "xerrorbars" : "yerrorbars", colour));
    }
    const std::string stroke = fmt::format("lw {:.2f} dt {} {}", line.width, line.dashed ? "(8,5)" : "1", colour);
    const std::string points = fmt::format("pt {} ps {:.2f}", point_type(line.marker), 0.5 * line.marker_size);
    if (line.marker == Marker::none) {
        drawn.elements.push_back(fmt::format("{} using 1:2 with lines {} {}", name, stroke, title));
    } else if (line.width > 0.0) {
        drawn.elements.push_back(fmt::format("{} using 1:2 with linespoints {} {} {}", name, stroke, points, title));
    } else {
        drawn.elements.push_back(fmt::format("{} using 1:2 with points {} lw 1 {} {}", name, points, colour, title));
    }
}

void add(Drawn& drawn, const std::string& name, const Area& area) {
    drawn.blocks += name + " << EOD\n";
    for (std::size_t i = 0; i < area.x.size(); ++i) {
        drawn.blocks += gnuplot_number(area.x[i]) + " " + gnuplot_number(area.y[i]) + "\n";
    }
    drawn.blocks += "EOD\n";
    drawn.elements.push_back(fmt::format("{} using 1:2 with filledcurves closed fc rgb {} fs solid noborder notitle",
                                         name, rgb(area.colour)));
}

void add(Drawn& drawn, const std::string& name, const Boxes& boxes) {
    if (boxes.left.empty()) {
        return;
    }
    // A block for every colour: those of a map are few.
    std::map<Colour, std::string> rows;
    for (std::size_t i = 0; i < boxes.left.size(); ++i) {
        const Colour colour = boxes.colours[boxes.colours.size() == 1 ? 0 : i];
        rows[colour] += fmt::format("{} {} {} {}\n", gnuplot_number(boxes.left[i]), gnuplot_number(boxes.right[i]),
                                    gnuplot_number(boxes.bottom[i]), gnuplot_number(boxes.top[i]));
    }
    for (const auto& [colour, text] : rows) {
        const std::string block = fmt::format("{}_{:06X}", name, colour);
        drawn.blocks += fmt::format("{} << EOD\n{}EOD\n", block, text);
        drawn.elements.push_back(fmt::format("{} using 1:3:1:2:3:4 with boxxyerror {} fc rgb {} lw 0.3 notitle", block,
                                             boxes.hatched ? "fs transparent pattern 4 noborder"
                                                           : fmt::format("fs solid border lc rgb {}", rgb(colour)),
                                             rgb(colour)));
    }
}

std::string tick_list(const PlotAxis& axis) {
    std::string ticks;
    for (const Tick& tick : axis.ticks) {
        ticks += fmt::format("{}{} {}", ticks.empty() ? "" : ", ", quoted(axis.labelled ? tick.text : ""),
                             gnuplot_number(tick.at));
    }
    return ticks;
}

std::string axis_commands(const PlotAxis& axis, const std::string& name, bool grid) {
    const std::string other = name + "2";
    const std::string& of = axis.at_far_side ? other : name;
    std::string text =
        fmt::format("unset {0}tics\nunset {1}tics\nunset m{0}tics\nset {0}label ''\nset {1}label ''\n"
                    "{2} logscale {0}\nset {0}range [{3}:{4}]\n",
                    name, other, axis.log ? "set" : "unset", gnuplot_number(axis.reversed ? axis.high : axis.low),
                    gnuplot_number(axis.reversed ? axis.low : axis.high));
    if (axis.at_far_side) {
        text += fmt::format("set link {}\n", other);
    }
    const std::string ticks = tick_list(axis);
    if (!ticks.empty()) {
        text += fmt::format("set {}tics out nomirror scale 0.5 offset {} ({})\n", of,
                            name == "x"        ? "0,0.35"
                            : axis.at_far_side ? "-0.4,0"
                                               : "0.4,0",
                            ticks);
        text += grid ? fmt::format("set grid {}tics lc rgb '#E6E9EC' lw 0.6 dt 1\n", of) : std::string();
    }
    if (!axis.label.empty()) {
        text += fmt::format("set {}label {} offset {}\n", of, quoted(axis.label),
                            name == "x"                                  ? "0,0.5"
                            : axis.label.find('\n') == std::string::npos ? "0,0"
                                                                         : "-1.2,0"); // its second line is the nearer
    }
    return text;
}

std::string commands_of(const Space& space, const Figure& figure, FigureFormat format, const std::string& block) {
    std::string text = block + "s << EOD\n";
    const std::size_t nx = space.grid_x.size();
    for (std::size_t n = 0; n < space.high.size(); ++n) {
        text +=
            fmt::format("{} {} {} {}\n{}", gnuplot_number(space.grid_x[n % nx]), gnuplot_number(space.grid_y[n / nx]),
                        gnuplot_number(space.high[n]), space.colours[n], (n + 1) % nx == 0 ? "\n" : "");
    }
    text += "EOD\n";
    // The same once more, not drawn, is what hides the lines: gnuplot draws lines in front of colours.
    std::string plot =
        fmt::format("splot {0}s using 1:2:3:4 with pm3d fc rgb variable, \\\n  {0}s using 1:2:3 with lines "
                    "lt nodraw",
                    block);
    for (std::size_t k = 0; k < space.lines.size(); ++k) {
        const Course& line = space.lines[k];
        const std::string name = fmt::format("{}l{}", block, k);
        text += name + " << EOD\n";
        for (std::size_t i = 0; i < line.x.size(); ++i) {
            text += std::isfinite(line.z[i]) ? fmt::format("{} {} {}\n", gnuplot_number(line.x[i]),
                                                           gnuplot_number(line.y[i]), gnuplot_number(line.z[i]))
                                             : std::string("\n\n"); // one empty line alone would make it a surface
        }
        text += "EOD\n";
        plot += fmt::format(", \\\n  {} using 1:2:3 with ", name);
        plot += line.width > 0.0 ? fmt::format("lines lw {:.2f} lc rgb {}", line.width, rgb(line.colour))
                                 : fmt::format("points pt {} ps {:.2f} lc rgb {}", point_type(line.marker),
                                               0.5 * line.marker_size, rgb(line.colour));
    }
    text += fmt::format("set lmargin\nset rmargin\nset bmargin\nset tmargin\nset origin {:.6f},{:.6f}\nset size "
                        "{:.6f},{:.6f}\nunset label\nunset grid\nunset key\nunset colorbox\nset title\n",
                        space.left / figure.width, space.bottom / figure.height, space.width / figure.width,
                        space.height / figure.height);
    text += axis_commands(space.x, "x", false) + axis_commands(space.y, "y", false);
    text += fmt::format(
        "set xtics offset 0,-0.3\nset ytics offset 0.3,-0.2\nset xlabel offset 0,-0.6 rotate parallel\n"
        "set ylabel offset 1.0,-0.6 rotate parallel\nset zrange [{}:{}]\nset ztics in nomirror scale 0.5 ({})\n"
        "set zlabel {} rotate by 90\nset ticslevel 0\n",
        gnuplot_number(space.z.low), gnuplot_number(space.z.high), tick_list(space.z), quoted(space.z.label));
    // Seams show in what cairo draws, unless each piece is drawn around as well; in SVG that draws black lines.
    text += fmt::format("set view {},{},1.16,0.9\nunset border\nset hidden3d front\nset pm3d depthorder {} clip z\n",
                        space_tilt, space.turned, format == FigureFormat::svg ? "noborder" : "border retrace");
    // The edges of the box but for those that would cross the surface: they end at the nearest corner's upper end.
    const auto quarter = static_cast<int>(std::floor(space.turned / 90.0)) % 4;
    const std::array near{quarter < 2, quarter == 1 || quarter == 2, true};
    const std::array axes{&space.x, &space.y, &space.z};
    for (std::size_t along = 0; along < 3; ++along) {
        for (const bool a : {false, true}) {
            for (const bool b : {false, true}) {
                const std::size_t one = (along + 1) % 3;
                const std::size_t other = (along + 2) % 3;
                if (a == near[one] && b == near[other]) {
                    continue;
                }
                std::array<double, 3> from{};
                std::array<double, 3> to{};
                from[along] = axes[along]->low;
                to[along] = axes[along]->high;
                from[one] = to[one] = a ? axes[one]->high : axes[one]->low;
                from[other] = to[other] = b ? axes[other]->high : axes[other]->low;
                text += fmt::format("set arrow from {},{},{} to {},{},{} nohead back lw 0.7 lc rgb '#333333'\n",
                                    gnuplot_number(from[0]), gnuplot_number(from[1]), gnuplot_number(from[2]),
                                    gnuplot_number(to[0]), gnuplot_number(to[1]), gnuplot_number(to[2]));
            }
        }
    }
    return text + plot + "\n";
}

} // namespace

std::string gnuplot_script(const Figure& figure, FigureFormat format, const std::string& file) {
    std::string text = fmt::format("# Figure {} of a Pavescape run, for gnuplot 5.4.\n{}\nset output {}\n"
                                   "set encoding utf8\nset multiplot\nset errorbars small\n",
                                   figure.name, terminal(figure, format), quoted(file));
    int block = 0;
    for (const Panel& panel : figure.panels) {
        Drawn drawn;
        for (const Layer& layer : panel.layers) {
            std::visit([&](const auto& shape) { add(drawn, fmt::format("$d{}", block++), shape); }, layer);
        }
        text += "\n" + drawn.blocks;
        text += fmt::format("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}\nset bmargin at screen "
                            "{:.6f}\nset tmargin at screen {:.6f}\n",
                            panel.left / figure.width, (panel.left + panel.width) / figure.width,
                            panel.bottom / figure.height, (panel.bottom + panel.height) / figure.height);
        text += "unset label\nunset grid\n";
        text += axis_commands(panel.x, "x", panel.grid) + axis_commands(panel.y, "y", panel.grid);
        text += panel.framed ? "set border 15 front lw 0.7 lc rgb '#333333'\n" : "unset border\n";
        text += panel.title.empty() ? "set title\n" : fmt::format("set title {} offset 0,-0.6\n", quoted(panel.title));
        const std::size_t named = legend_entries(panel);
        text += named > 0
                    ? fmt::format("set key at screen {:.6f},{:.6f} left top reverse Left samplen 2 spacing 1.1 {} "
                                  "noenhanced\n",
                                  panel.left / figure.width, (panel.bottom - legend_below) / figure.height,
                                  named > 3 ? "horizontal maxcols 2" : "vertical maxcols 1")
                    : "unset key\n";
        for (const Note& note : panel.notes) {
            text += fmt::format("set label {} at graph {},{} {} front textcolor rgb {}\n", quoted(note.text),
                                gnuplot_number(note.x), gnuplot_number(note.y), note.at_right ? "right" : "left",
                                rgb(note.colour));
        }
        std::string plot;
        for (const std::string& element : drawn.elements) {
            plot += (plot.empty() ? "plot " : ", \\\n  ") + element;
        }
        text += (plot.empty() ? "plot NaN notitle" : plot) + "\n";
    }
    for (const Space& space : figure.spaces) {
        text += "\n" + commands_of(space, figure, format, fmt::format("$d{}", block++));
    }
    return text + "\nunset multiplot\nset output\n";
}

std::size_t legend_entries(const Panel& panel) {
    return static_cast<std::size_t>(std::count_if(panel.layers.begin(), panel.layers.end(), [](const Layer& layer) {
        const auto* line = std::get_if<Line>(&layer);
        return line != nullptr && !line->name.empty();
    }));
}

double legend_height(const Panel& panel) {
    const std::size_t entries = legend_entries(panel);
    constexpr double line = 0.38; // cm
    return line * static_cast<double>(entries > 3 ? (entries + 1) / 2 : entries);
}

std::pair<std::vector<double>, std::vector<double>> smooth_rise(const std::vector<double>& at,
                                                                const std::vector<double>& rise) {
    if (at.size() < gsl_interp_type_min_size(gsl_interp_steffen) ||
        std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) != at.end() ||
        !std::all_of(rise.begin(), rise.end(), [](double r) { return std::isfinite(r); })) {
        return {at, rise};
    }
    const auto least = static_cast<std::size_t>(std::min_element(rise.begin(), rise.end()) - rise.begin());
    const bool inside = least > 0 && least + 1 < rise.size();
    std::vector<double> shape = rise;
    for (std::size_t i = 0; inside && i < shape.size(); ++i) {
        shape[i] = (i < least ? -1.0 : 1.0) * std::sqrt(std::max(0.0, rise[i]));
    }
    const std::unique_ptr<gsl_interp, void (*)(gsl_interp*)> cubic(gsl_interp_alloc(gsl_interp_steffen, at.size()),
                                                                   gsl_interp_free);
    gsl_interp_init(cubic.get(), at.data(), shape.data(), at.size());
    constexpr int each = 12; // points from one to the next
    std::pair<std::vector<double>, std::vector<double>> curve;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
        for (int k = 0; k < each; ++k) {
            const double x = at[i] + (at[i + 1] - at[i]) * k / each;
            const double value = gsl_interp_eval(cubic.get(), at.data(), shape.data(), x, nullptr);
            curve.first.push_back(x);
            curve.second.push_back(inside ? value * value : value);
        }
    }
    curve.first.push_back(at.back());
    curve.second.push_back(rise.back());
    return curve;
}

std::string csv_text(const DataTable& table) {
    const auto line = [](const std::vector<std::string>& cells) {
        std::string text;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            text += (i > 0 ? "," : "") + data::csv_cell(cells[i]);
        }
        return text + "\n";
    };
    std::string text = line(table.columns);
    for (const auto& row : table.rows) {
        text += line(row);
    }
    return text;
}

std::string cell(double value) {
    return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

std::string cell(const std::optional<double>& value) {
    return value ? cell(*value) : std::string();
}

std::vector<Tick> round_ticks(double low, double high, bool log, int most) {
    const auto named = [](double at) { return Tick{at, fmt::format("{:.6g}", at)}; };
    std::vector<Tick> ticks;
    const double slack = 1e-9;
    if (log) {
        for (const std::vector<double>& set : {std::vector<double>{1, 2, 5}, {1, 3}, {1}}) {
            ticks.clear();
            const int first = static_cast<int>(std::floor(std::log10(low)));
            const int last = static_cast<int>(std::ceil(std::log10(high)));
            int every = 1;
            while (set.size() == 1 && (last - first) / every > most) {
                ++every;
            }
            for (int decade = first; decade <= last; decade += every) {
                for (const double factor : set) {
                    const double at = factor * std::pow(10.0, decade);
                    if (at >= low * (1.0 - slack) && at <= high * (1.0 + slack)) {
                        ticks.push_back(named(at));
                    }
                }
            }
            if (static_cast<int>(ticks.size()) <= most && ticks.size() >= 2) {
                return ticks;
            }
        }
        if (ticks.size() >= 2) {
            return ticks;
        }
    }
    ticks.clear();
    const double rough = (high - low) / std::max(1, most);
    const double decade = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10.0 * decade;
    for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
        if (factor * decade >= rough * (1.0 - slack)) {
            step = factor * decade;
            break;
        }
    }
    for (double n = std::ceil(low / step - slack); n * step <= high + slack * step; ++n) {
        ticks.push_back(named(std::abs(n * step) < 1e-12 * step ? 0.0 : n * step));
    }
    return ticks;
}

Colour cividis(double share) {
    // Every eighth of the map.
    static constexpr double table[9][3] = {{0, 32, 77},     {15, 54, 110},   {62, 77, 107},
                                           {87, 98, 112},   {108, 119, 122}, {137, 140, 121},
                                           {173, 166, 111}, {214, 193, 92},  {255, 234, 70}};
    const double at = std::clamp(share, 0.0, 1.0) * 8.0;
    const auto i = std::min<std::size_t>(7, static_cast<std::size_t>(at));
    Colour colour = 0;
    for (int c = 0; c < 3; ++c) {
        const double value = table[i][c] + (at - static_cast<double>(i)) * (table[i + 1][c] - table[i][c]);
        colour = colour << 8U | static_cast<Colour>(std::lround(value));
    }
    return colour;
}

std::string unit_words(const std::string& unit) {
    return unit == "um" ? "µm" : unit;
}

std::string quantity_words(const std::string& quantity) {
    if (quantity == "benkelman") {
        return "Benkelman deflection";
    }
    const auto cut = quantity.find('_');
    const std::string kind = quantity.substr(0, cut);
    const std::string axis = cut == std::string::npos ? "" : quantity.substr(cut + 1);
    const std::string way = axis == "zz"   ? "vertical "
                            : axis == "xx" ? "transverse "
                            : axis == "yy" ? "longitudinal "
                                           : "";
    return way.empty() && !axis.empty() ? kind + " " + axis : way + kind;
}

AxisWords axis_words(const std::string& name) {
    static constexpr std::pair<std::string_view, std::string_view> units[] = {
        {"_kg_m3", "kg/m³"}, {"_MPa", "MPa"}, {"_kPa", "kPa"},   {"_GPa", "GPa"}, {"_kN", "kN"}, {"_mm", "mm"},
        {"_um", "µm"},       {"_ms", "ms"},   {"_percent", "%"}, {"_C", "°C"},    {"_m", "m"},   {"_s", "s"}};
    const auto dot = name.find('.');
    AxisWords words{dot == std::string::npos ? "" : name.substr(0, dot),
                    dot == std::string::npos ? name : name.substr(dot + 1)};
    for (const auto& [suffix, text] : units) {
        if (words.number.size() > suffix.size() && words.number.ends_with(suffix)) {
            words.number.resize(words.number.size() - suffix.size());
            words.unit = text;
            break;
        }
    }
    for (std::string* part : {&words.of, &words.number}) {
        std::replace(part->begin(), part->end(), '_', ' ');
        std::replace(part->begin(), part->end(), '.', ' ');
    }
    return words;
}

std::string AxisWords::line() const {
    return fmt::format("{}{}{}{}", of, of.empty() ? "" : " ", number, unit.empty() ? "" : " (" + unit + ")");
}

std::string AxisWords::lines() const {
    const std::string in_unit = unit.empty() ? "" : "(" + unit + ")";
    return of.empty() ? number + (unit.empty() ? "" : "\n" + in_unit)
                      : of + "\n" + number + (unit.empty() ? "" : " " + in_unit);
}

std::string parameter_words(const std::string& name) {
    return axis_words(name).line();
}

} // namespace explore::report

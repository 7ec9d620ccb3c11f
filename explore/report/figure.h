// A figure for a paper: what it shows, from which its gnuplot script and its tables are made.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace explore::report {

using Colour = std::uint32_t; // 0xRRGGBB

// Colours of Okabe and Ito, told apart by colour-blind people.
inline constexpr Colour okabe_ito[] = {0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0xE69F00, 0x56B4E9};
inline constexpr Colour black = 0x000000, grey = 0x777777, pale = 0xE4E4E4, white = 0xFFFFFF;
// Of the map cividis (Nunez, Anderton and Renslow 2018, PLoS ONE 13): 0 dark blue, 1 light yellow.
Colour cividis(double share);

enum class Marker { none, circle, open_circle, square, diamond, triangle, star };

struct Line {
    std::vector<double> x{}, y{}; // not a number: a gap
    Colour colour = black;
    double width = 1.0; // points; 0: markers alone
    bool dashed = false;
    Marker marker = Marker::none;
    double marker_size = 1.0;
    std::string name{};          // in the panel's legend; empty: not there
    std::vector<double> error{}; // half length of a bar across each point, along y or `along_x`; empty: none
    bool along_x = false;
};
struct Area { // within a closed line
    std::vector<double> x{}, y{};
    Colour colour = pale;
};
struct Boxes {
    std::vector<double> left{}, right{}, bottom{}, top{};
    std::vector<Colour> colours{}; // one each, or one of all
    bool hatched = false;
};
using Layer = std::variant<Line, Area, Boxes>;

struct Tick {
    double at = 0.0;
    std::string text{};
};

struct PlotAxis {
    std::string label{}; // lines separated by \n
    double low = 0.0, high = 1.0;
    bool log = false;
    std::vector<Tick> ticks{};
    bool labelled = true; // its ticks have their texts
    bool reversed = false;
    bool at_far_side = false; // ticks and label right of the panel, or above
};
// Ticks at round values, at most about so many.
std::vector<Tick> round_ticks(double low, double high, bool log, int most);

struct Note {
    double x = 0.0, y = 0.0; // shares of the panel
    std::string text{};
    bool at_right = false; // of its place: it ends there
    Colour colour = black;
};

struct Panel {
    double left = 0.0, bottom = 0.0, width = 1.0, height = 1.0; // cm of the figure
    PlotAxis x{}, y{};
    std::vector<Layer> layers{}; // the first lowest
    std::string title{};
    bool framed = true;
    bool grid = false;
    std::vector<Note> notes{};
};

// A line in space.
struct Course {
    std::vector<double> x{}, y{}, z{}; // not a number: a gap
    Colour colour = black;
    double width = 1.0; // points; 0: markers alone
    Marker marker = Marker::none;
    double marker_size = 1.0;
};
// A surface over a grid, seen from above; what lies behind it is hidden.
struct Space {
    double left = 0.0, bottom = 0.0, width = 1.0, height = 1.0; // cm of the figure, with the labels of the axes
    PlotAxis x{}, y{}, z{};
    double turned = 30.0;                           // degrees; from 0 to 90 the corner of high x and low y is nearest
    std::vector<double> grid_x{}, grid_y{}, high{}; // x fastest; above the axis: cut off; not a number: a hole
    std::vector<Colour> colours{};                  // one each
    std::vector<Course> lines{};
};
// Of its box as it is drawn: how far the eye stands from the vertical (degrees), and the height over a side.
inline constexpr double space_tilt = 50.0, space_height = 0.69;

// A table beside a figure; cells are text as it stands in the file.
struct DataTable {
    std::string name; // of the file, without .csv
    std::vector<std::string> columns{};
    std::vector<std::vector<std::string>> rows{};
};

struct Figure {
    std::string name;
    double width = 17.0, height = 12.0; // cm
    std::vector<Panel> panels{};
    std::vector<Space> spaces{};
    std::vector<DataTable> tables{};
};

// Named lines of a panel stand in a legend below it, this far down, in one column or, more than three, in two.
inline constexpr double legend_below = 1.05; // cm
std::size_t legend_entries(const Panel& panel);
double legend_height(const Panel& panel); // cm

// A rise over rising places as a smooth line: the monotone cubic (Steffen 1990) of its root, with the sign of the side
// of the lowest, which is nearly straight beside a minimum; of the rise itself where the lowest is an end. As it is
// where there are fewer than three points, or some without a number.
std::pair<std::vector<double>, std::vector<double>> smooth_rise(const std::vector<double>& at,
                                                                const std::vector<double>& rise);

enum class FigureFormat { svg, pdf, png };
inline constexpr std::string_view figure_format_names[] = {"svg", "pdf", "png"};

// Of gnuplot 5.4; it writes `file`. Texts of a study are never commands.
std::string gnuplot_script(const Figure& figure, FigureFormat format, const std::string& file);
std::string csv_text(const DataTable& table);
// A number as a cell; not a number: empty.
std::string cell(double value);
std::string cell(const std::optional<double>& value); // nothing: empty

// A number and its unit, as they stand beside an axis.
struct AxisWords {
    std::string of; // "subgrade"; empty: of nothing more
    std::string number, unit{};
    std::string line() const;  // "subgrade modulus (MPa)"
    std::string lines() const; // the same over two lines
};
// Of "subgrade.modulus_MPa".
AxisWords axis_words(const std::string& name);
std::string parameter_words(const std::string& name);
// "strain_zz" as "vertical strain", "um" as "µm".
std::string quantity_words(const std::string& quantity);
std::string unit_words(const std::string& unit);

} // namespace explore::report

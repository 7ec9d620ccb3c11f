// Shared by the corner figures: parameters as axes, and where the panels stand.
#pragma once

#include "report/figure_key.h"

namespace explore::report {

std::vector<double> numbers_of(const Json& list);

// A parameter as an axis: its place in the unit interval.
struct Parameter {
    std::string name;
    double low = 0.0, high = 1.0;
    bool log = false;
    double from = 0.0, to = 1.0; // what is shown, in the unit interval

    explicit Parameter(const Json& json); // {"name", "min", "max", "scale"}
    double unit(double value) const;
    double physical(double unit) const;
    bool shows(double value) const { return unit(value) >= from - 1e-9 && unit(value) <= to + 1e-9; }
    std::vector<double> units(const std::vector<double>& values) const;
};
std::vector<Parameter> parameters_of(const Json& list);
// Throws std::out_of_range for a name that none of them has.
std::size_t index_of(const std::vector<Parameter>& parameters, const Json& name);

// Where the panels of a corner stand.
struct Corner {
    std::vector<Parameter> parameters;
    double side = 3.0; // of a panel, cm
    static constexpr double gap = 0.25, left = 2.2, bottom = 1.75, above = 0.45, right = 0.5, large = 11.0;

    explicit Corner(const Json& list); // of parameters
    double reach() const;              // of all panels
    double height() const { return bottom + reach() + above; }
    double width() const { return left + reach() + right; }
    PlotAxis axis(std::size_t k, bool named) const;
    Panel panel(std::size_t column, std::size_t row) const;
    // One pair large.
    Panel alone(std::size_t column, std::size_t row) const;
    // The empty corner, from there to the right and top edge.
    double key_left() const { return left + 2.0 * (side + gap) + 0.6; }
    double key_top() const { return bottom + reach(); }
};

// Accepted minima on a pair of parameters, or (no y) on one at that height.
void add_minima(Panel& panel, const Json& minima, const Parameter& x, const Parameter* y, double height = 0.0);
DataTable minima_table(const Json& minima, const std::vector<Parameter>& parameters);
// A bar of the colours, read at its right side.
Panel colour_bar(double left, double bottom, double height, const std::vector<Colour>& colours,
                 const std::vector<Tick>& ticks, const std::string& label);
// The reach of a line of nodes: from half way to the one before to half way to the one after.
std::vector<double> edges_of(const std::vector<double>& lines);

} // namespace explore::report

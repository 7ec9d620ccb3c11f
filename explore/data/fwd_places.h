// The places of a road where plain numbers and sums ("163", "163+10") may be read in several ways.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace explore::data {

// "163" is 163 m and "163+10" 163 km + 10 m, unless the column says otherwise. Where nothing after a plus reaches 20
// and the plain numbers lie among those before it, in an order that goes one way along the road if they do, or the
// column is called "estaca", both count stations of 20 m; so do plain numbers alone in such a column that follow each
// other by one or two. In feet "12+34" is 1234 ft, and plain numbers that lie among
// those before the plus are full stations of 100 ft.
class Places {
public:
    // cells: of one column, with a decimal point. to_m: its unit; none: it states none. is_american: mils, pounds or
    // psi stand beside it.
    Places(const std::vector<std::string>& cells, std::string_view column_name, std::optional<double> to_m,
           bool is_american);

    // Of a cell; nothing: it is no chainage.
    std::optional<double> metres(std::string_view cell) const;
    // Whether the sum in this cell is in feet only because of what stands beside it.
    bool is_sum_in_feet_by_neighbours(std::string_view cell) const;
    // A remark or a question on them; "": nothing is worth saying.
    const std::string& remark() const { return remark_; }

private:
    enum class Meaning { plain, stations, doubtful };
    Meaning meaning(std::string_view column_name) const;
    bool mixes() const { return !plain_.empty() && !sums_.empty(); }
    bool is_in_feet() const;
    double whole() const; // units of what stands before a plus
    double step() const;  // metres of a station

    std::optional<double> to_m_;
    bool is_american_;
    std::vector<double> plain_;
    std::vector<std::pair<double, double>> sums_; // before and after the plus
    std::vector<double> numbers_;                 // all in their order, plain ones and those before a plus
    std::vector<std::optional<double>> after_;    // what follows each; nothing: it is a plain one
    std::string example_, plain_example_;
    Meaning meaning_ = Meaning::plain;
    std::string remark_;
};

} // namespace explore::data

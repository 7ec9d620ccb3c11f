// The meaning of the places of a table where plain numbers and sums ("163", "163+10") may be read in several ways.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace explore::data {

// "163" is 163 m and "163+10" 163 km + 10 m, unless the column says otherwise: where nothing after a plus reaches 20
// and the plain numbers lie among those before it, in an order that goes one way along the road if they do, or the
// column is called "estaca", both count stations of 20 m.
class PlaceForms {
public:
    enum class Meaning {
        plain,            // as they stand
        stations_of_20_m, // 20 x number + metres
        doubtful          // they may be
    };

    // Of the cells of this column, behind so many rows of header.
    PlaceForms(const std::vector<std::vector<std::string>>& rows, std::size_t header, std::size_t column, char decimal);

    Meaning meaning(std::string_view column_name) const;
    bool mixes() const { return !plain_.empty() && !sums_.empty(); }
    const std::string& example() const { return example_; } // a sum

private:
    std::vector<double> plain_;
    std::vector<std::pair<double, double>> sums_;     // before and after the plus
    std::vector<double> as_kilometres_, as_stations_; // all, in metres, in their order
    std::string example_;
};

// Metres of "163" and "163+10" in stations of 20 m; nothing: neither.
std::optional<double> chainage_of_20_m(std::string_view cell);

} // namespace explore::data

// Thicknesses of layers that stations of a road state: columns "base_mm", "Base (cm)", and "base_sd_mm" for the
// standard deviation of their error, beside the deflections or in a table of their own by chainage (cores, radar).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

struct StatedThickness {
    double mm = 0.0;
    std::optional<double> sd_mm{}; // standard deviation of its error
    bool is_from_table = false;    // interpolated between the rows of a table by chainage
};
using StationLayers = std::map<std::string, StatedThickness>; // by the name of the layer

struct LayerColumn {
    std::string layer;
    bool is_error = false; // its standard deviation
    double to_mm = 1.0;
};
// The layer that a column of this name states; nothing: its name does not end in a unit of length.
std::optional<LayerColumn> layer_column(std::string_view name);

struct LayerTable {
    struct Row {
        std::string lane{}; // "": of all lanes
        double chainage_m = 0.0;
        StationLayers layers{};
        int line = 0;
    };
    std::string file;
    std::vector<Row> rows;              // by chainage
    std::vector<std::string> unknown{}; // columns that are none of a layer
    std::string places{};               // what is worth saying of how its places were read
    std::vector<std::string> layers() const;
};
// Columns chainage_m (or km, ...), layers, and lane where it has one. Throws pave::Error.
LayerTable read_layer_table(const std::string& file);

// Linear between the rows on both sides that state the layer (its error too); before the first and beyond the last that
// of the nearest. Nothing: no row of this lane states it.
std::optional<StatedThickness> thickness_at(const LayerTable& table, const std::string& layer, const std::string& lane,
                                            double chainage_m);

} // namespace explore::data

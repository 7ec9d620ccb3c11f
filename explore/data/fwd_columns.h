// The columns of a survey table, known by their names.
//
// A name is a word and a unit: load_kN, "Load (kN)", LOAD [lbf], D300_um, "D12in (mils)". Upper and lower case, blanks
// and hyphens do not count.
#pragma once

#include "data/fwd.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

enum class Meaning {
    station,
    lane,
    profile, // the road, section or run
    chainage,
    drop,
    radius,
    diameter,
    pressure,
    load,
    air,
    surface,
    asphalt,
    latitude,
    longitude,
    date,
    time,
    comment,
    deflection
};

struct FwdColumn {
    Meaning meaning;
    std::string name;              // as the file has it
    std::size_t at = 0;            // its cell in a line
    std::optional<double> to_si{}; // factor of its unit; nothing: no unit is stated, or none is needed
    bool is_fahrenheit = false;
    std::size_t rank = 0;             // of its word among those of one meaning; the lowest is meant where several stand
    double offset_mm = 0.0;           // of a deflection
    std::optional<double> constant{}; // in place of cells; in the unit of the column
};

// The content of a column of this name; nothing: not one of the above.
std::optional<FwdColumn> column_named(std::string_view name);

// The unit of a deflection, by its word; nothing: none.
std::optional<double> deflection_unit(std::string_view word);

struct FwdHeader {
    std::vector<FwdColumn> columns;   // each meaning once, profiles apart; the deflections by offset
    std::vector<std::string> unknown; // names that mean nothing here
    struct Layer {
        std::size_t at = 0; // its cell in a line
        std::string name;   // as the file has it
        LayerColumn column;
    };
    std::vector<Layer> layers{}; // columns that may state a thickness
    std::size_t rows = 1;        // of the table that are header: names, then offsets or units of the deflections

    const FwdColumn* find(Meaning meaning) const;
    std::vector<const FwdColumn*> deflections() const;
};

// The header of a table: its first row, and after it rows that hold where numbered sensors (D1, D2, ...) stand or what
// the deflections are measured in. Throws pave::Error for what is missing, ambiguous or appears twice.
FwdHeader read_header(const std::vector<std::vector<std::string>>& rows, const std::vector<int>& lines,
                      const std::string& file, const ColumnMap& columns);

// The names of columns in words, for messages.
std::string known_columns();

} // namespace explore::data

// A spreadsheet's table as cells: its header, its separator and its decimal sign.
#pragma once

#include "data/fwd.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

struct FwdTable {
    std::vector<std::vector<std::string>> rows; // the header first; none of them blank
    std::vector<int> lines;                     // where they stand
    char separator = ',';
    std::size_t above = 0; // lines above the header that are neither blank nor comments
};

// The table whose header is the row, of the first 30, that names the most columns of a survey, by the separator (comma,
// semicolon, tab, bar) that finds the most; at least two, or one of those that a column map names. Nothing: there is
// none. Comments start with # and stand above the header. Throws pave::Error for a quote that never closes.
std::optional<FwdTable> fwd_table(std::string_view text, const std::string& file, const ColumnMap& columns);
bool has_fwd_table(std::string_view text, const ColumnMap& columns);

// Letters, digits and signs of full width as those of ASCII, a minus sign as a hyphen.
std::string with_plain_letters(std::string_view text);

// The decimal sign of the numbers in a file.
class Decimals {
public:
    // separator: a file separated by semicolons or tabs comes from where the comma is the decimal sign.
    explicit Decimals(char separator) : comma_parts_cells_(separator == ',') {}

    void look_at(std::string_view cell, int line, std::string_view column);
    // Throws pave::Error where the file contradicts itself.
    char sign(const std::string& file) const;
    // Where a point may part thousands or decimals and nothing tells which; "": nowhere.
    std::string doubt() const;

private:
    struct Sight {
        int line = 0;
        std::string column;
        std::string cell;
    };
    std::array<Sight, 2> seen_;     // of commas, of points that part decimals
    std::array<Sight, 2> doubtful_; // that may part thousands as well
    bool comma_parts_cells_;
};

// The cell as a program reads it: letters of plain width, no thousands, a decimal point.
std::string with_point(std::string_view cell, char decimal);

} // namespace explore::data

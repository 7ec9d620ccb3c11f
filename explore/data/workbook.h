// Workbooks of spreadsheets (.xlsx: ISO/IEC 29500, a zip archive of XML), read as tables and written from them. Where
// the libraries for it are not installed the program is built without.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

// Whether the bytes are those of a zip archive, which a workbook is.
inline bool is_archive(std::string_view bytes) {
    return bytes.starts_with("PK\x03\x04");
}

struct Sheet {
    std::string name;
    std::string csv; // a line a row, empty ones too, cells separated by commas, numbers with a point
};

// The sheets in their order; nothing: built without. Throws pave::Error for an archive that holds no workbook.
std::optional<std::vector<Sheet>> sheets_of(const std::string& file);

// The bytes of a workbook of one sheet with the rows of a table; numbers are numbers; nothing: built without.
std::optional<std::string> workbook_of(const std::string& csv, const std::string& sheet);

} // namespace explore::data

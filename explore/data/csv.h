// RFC 4180 with comment lines.
#pragma once

#include "base/error.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

struct CsvRow {
    int line = 0; // 1-based, where the row starts
    std::vector<std::string> cells;
};

// Splits text into rows; quoted cells may hold separators, doubled quotes and line breaks. Blank lines and lines that
// start with # are left out (comments: or not); a UTF-8 byte order mark is skipped. Throws pave::Error for a quote that
// never closes.
enum class Comments { anywhere, none };
std::vector<CsvRow> parse_csv(std::string_view text, const std::string& file, char separator = ',',
                              Comments comments = Comments::anywhere);

// A cell as RFC 4180 wants it: quoted when it holds a separator, a quote or a line break, or would be read as a
// comment.
std::string csv_cell(std::string_view text);

// A cell without the blanks around it.
std::string_view trimmed(std::string_view cell);
// ASCII letters in lower case.
std::string lower_case(std::string_view text);

// A cell that must be a number. Throws pave::Error at `place`. The second also takes nan and inf for what they say.
double finite_number(std::string_view cell, const pave::Place& place);
double any_number(std::string_view cell, const pave::Place& place);
// A cell that holds a finite number and nothing else, or nothing.
std::optional<double> number_or_nothing(std::string_view cell);

// A table with a header, as a person writes it or a spreadsheet saves it: cells separated by commas, by semicolons, by
// tabs or by bars, whichever the header has most of (a line sep=; above it says so, too). Where they are no commas and
// no number of the table has a full stop, numbers may have decimal commas.
struct CsvTable {
    std::vector<CsvRow> rows; // the header first; none: nothing but blank lines and comments
    char separator = ',';
    bool decimal_comma = false;

    // Of a cell; throws pave::Error at `place`.
    double number(std::string_view cell, const pave::Place& place) const;
};
CsvTable parse_table(std::string_view text, const std::string& file);

// The whole of a file. Throws pave::Error when it cannot be read, when it is no regular file (a device, a pipe), and
// when it is not text. what: "measurement file".
enum class Encoding {
    utf8,
    of_instruments, // UTF-8, UTF-16, else Windows-1252: all become UTF-8, zero bytes and no-break spaces blanks, lone
                    // carriage returns line ends
    bytes           // whatever they are, no text
};
std::string read_file(const std::string& file, std::string_view what, Encoding encoding = Encoding::utf8);

// By whatever name or link; of texts that no file holds, by their names.
bool is_same_file(const std::string& a, const std::string& b);

// A file that something was made from, as it was then.
struct InputFile {
    std::string path;  // as it was opened
    std::string bytes; // what read_file made of it
};

} // namespace explore::data

// The readings in the files that a program writes.
#pragma once

#include "base/outcome.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace explore::external {

// The key of a response.
struct Wanted {
    std::string label; // of a reading as results call it, of an output its name
    std::string load, quantity;
    double x_mm = 0.0, y_mm = 0.0, depth_mm = 0.0, gauge_mm = 0.0;
    std::optional<double> time_ms{};
    std::string output{}; // the name of an output; empty: measured
};

// Which line: `number`-th after (0: the very) the first or last line with the marker; without a marker of the file,
// from 1.
struct Line {
    std::size_t number = 1;
    std::string marker{};
    bool last = false;
};
// Of "12", "after 'strains'", "3 after last 'strains'", "with 'strain ='". Nothing: it is none of these.
std::optional<Line> line_of(const std::string& text);

// One entry of `outputs`.
struct OutputFile {
    std::string file;
    std::optional<std::size_t> reading{}; // which response; nothing: all that no other entry names
    std::optional<Line> line{};           // one number: in this line,
    std::size_t column = 1;               // the so-manieth number or word between blanks, commas and semicolons
    std::vector<std::string> by{};        // a CSV table: its columns that tell which reading a row is
    std::string value_column{};           // and the one with the value
    std::string at{}; // a JSON pointer: to a number, a list in the order of the readings, or an object
};

// The columns that `by` may name.
const std::vector<std::string>& by_columns();

// The responses in the files in this folder. Failed where one is missing or no number, with which and where.
pave::Outcome<std::vector<double>> read_outputs(const std::vector<OutputFile>& outputs,
                                                const std::vector<Wanted>& wanted, const std::string& folder);

// To another process and back.
nlohmann::json outputs_json(const std::vector<OutputFile>& outputs);
std::vector<OutputFile> outputs_of(const nlohmann::json& json);
nlohmann::json wanted_json(const std::vector<Wanted>& wanted);
std::vector<Wanted> wanted_of(const nlohmann::json& json);

} // namespace explore::external

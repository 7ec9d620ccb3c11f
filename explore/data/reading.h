// One response of a study: a reading that was measured, or one that is requested (an output).
#pragma once

#include "data/noise.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

// other: of a model that is not ours, to which a unit is a name.
enum class Dimension { length, strain, pressure, other };

struct Unit {
    std::string_view name;
    Dimension dimension;
    double to_si;
};
std::span<const Unit> units();
// One of them. Throws std::out_of_range.
const Unit& unit_named(std::string_view name);
// One of them or, with this name, one of another dimension.
Unit any_unit(std::string_view name);

struct Reading {
    std::string load;
    std::string quantity;
    double x_mm = 0.0, y_mm = 0.0, depth_mm = 0.0, gauge_mm = 0.0; // as the file states them
    double value = 0.0;                                            // measured, in `unit`; of an output nothing
    Censored censored = Censored::no;                              // what the value says
    std::optional<double> time_ms{}; // under a load with a history: when; none: the extreme over time
    Unit unit{};                     // of the value; of an output the one it is reported in
    std::optional<double> sigma;     // one standard deviation that the file states, in `unit`
    int drops = 0;                   // that it is the mean of, where its noise hangs on that; 0: not known
    std::string file;
    int line = 0;
    std::string output{}; // the name of an output; empty: measured
    std::string name{};   // that the file gives it, for a model that is not ours; empty: it is known by its place
    // The error as it is assumed: stated, by the study's rule, or taken from others.
    Noise noise{};

    bool is_measured() const { return output.empty(); }
    double measured() const { return value * unit.to_si; }      // SI
    double in_unit(double si) const { return si / unit.to_si; } // what a report says of a response
    std::string group() const { return load + "." + quantity; } // "fwd.deflection"
    // "fwd.deflection@200,0,0", with its time "fwd.deflection@200,0,0,12.4ms", or the output's name.
    std::string label() const;
    std::string label_with_unit() const; // "fwd.deflection@200,0,0 [mm]"
    // Where it is read, without its load and time: "deflection at 300 mm", "strain_zz 112.5 mm deep at 170 mm".
    // Readings of one place have the same words, and only those.
    std::string place_words() const;
    std::string words() const; // with both: "deflection at 300 mm under fwd", "... under fwd at 12.4 ms"
};

// Reads the measurement format of this project: RFC 4180 with a header
// load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma; lines that start with # are comments; sigma may be
// empty; a value may be a limit, "<12" or ">2000" (Censored). Columns may come in any order; the ones named must all be
// there and, but for time_ms, no others. text: of a file that messages call `file`. Throws pave::Error.
std::vector<Reading> measurements_of(std::string_view text, const std::string& file);
// The same of readings of a model that is not ours: any units, and of the columns value alone must be there. A further
// one, name, says how messages and results call a reading.
std::vector<Reading> named_measurements_of(std::string_view text, const std::string& file);

// The header line of that format, and a reading as a row of it.
std::string_view measurement_header();
std::string measurement_row(const Reading& reading);

// The same of readings of which some have a time: a header and a row each, with the column time_ms.
bool has_times(std::span<const Reading> readings);
std::string measurement_rows(std::span<const Reading> readings);

} // namespace explore::data

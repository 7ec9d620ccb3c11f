// How field files write what was measured: numbers and what stands in place of one, places along a road, positions on
// the globe, times of day, units.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace explore::data {

// Marks of instruments and spreadsheets for "not measured": nothing, -, N0, N/A, nan, null, #VALUE!, ...
bool is_nil(std::string_view cell);

// A finite number; nothing for everything else. A plus sign may lead.
std::optional<double> measured(std::string_view cell);
// The same with a decimal point or comma.
std::optional<double> measured_with_comma(std::string_view cell);

inline constexpr double foot_m = 0.3048;

// Metres along the road from "340", "12+340" (kilometres + metres), "ZK0+160", "K12+340.5"; where the unit is the foot,
// "12+34" are stations of 100 ft: 1234 ft. Nothing where what follows the plus makes another whole. to_m: metres in the
// unit of a plain number.
std::optional<double> chainage(std::string_view cell, double to_m);

// Degrees from "48.97", "-2.5", "2.5W", "W2.5" or "48°58'26.1930"N"; south and west negative.
std::optional<double> degrees(std::string_view text);

// Hours from midnight, from "09:31", "9:31:20", "0931", "1:30 PM", "13h30", "13.30 Uhr", with a date before it, or from
// the days of a spreadsheet ("0.5625"); nothing: not to be read.
std::optional<double> hour_of_day(std::string_view time);

// Celsius of Fahrenheit.
constexpr double celsius(double fahrenheit) {
    return (fahrenheit - 32.0) / 1.8;
}

// kPa of a force in kN that spreads evenly under a plate, radius in mm.
double plate_pressure_kPa(double force_kN, double radius_mm);

// Factors to SI. Words in any case, with hyphens, blanks and a plural s.
struct NamedUnit {
    std::string_view name;
    double to_si;
};
std::span<const NamedUnit> length_units();
std::span<const NamedUnit> force_units();
std::span<const NamedUnit> pressure_units();
std::optional<double> factor_of(std::span<const NamedUnit> units, std::string_view word);
std::string names_of(std::span<const NamedUnit> units);

// Lower case without blanks, hyphens, dots, commas, colons, underscores and a plural s: "kilo-Newtons" and "kilonewton"
// are one word.
std::string plain_word(std::string_view text);

} // namespace explore::data

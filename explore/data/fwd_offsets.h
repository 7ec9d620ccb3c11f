// The places of sensors as the header of a table of drops states them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::data {

// "d300", "d(300)", "d-200", "d12in": where the sensor stands, in mm.
std::optional<double> sensor_offset_mm(std::string_view base);
// "D0 (furlong)", a deflection in a unit that is not known.
bool is_deflection_in_another_unit(std::string_view name);

// Millimetres in the unit that a row of offsets states beside them: "Offset (cm)".
double offset_unit_mm(const std::vector<std::string>& row);
// A cell of such a row, in mm: "200", or "200 mm" in a unit of its own; nothing: it is no place.
std::optional<double> place_mm(std::string_view cell, double unit_mm);

} // namespace explore::data

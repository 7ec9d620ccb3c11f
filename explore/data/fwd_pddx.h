// AASHTO's Pavement Deflection Data Exchange (.ddx, .pddx, .pdx), versions 1 and 2: sections in brackets, KEY = values.
//
//     [Pavement Deflection Data Exchange File]   DelimiterSymbol, DecimalSymbol
//     [Units]                 LoadPlateRadiusUnits, LoadUnits (force or pressure), DeflectionUnits, TemperatureUnits,
//                             SensorLocationUnits, TestLocationUnits
//     [Device Configuration]  LoadPlateRadius, NumberOfDeflectionSensors, DeflectionSensorXAxisDistances,
//                             DeflectionSensorYAxisDistances, TemperatureSensorUse
//     [Test Location i]       TestLocation, TestLane, TestTemperatures, DropData1 (or DropData_1) = load, deflections
//
// Names in any case; other sections and keys are passed over. Source: FHWA-HRT-07-040, appendix C.
#pragma once

#include "data/fwd.h"

namespace explore::data {

bool recognises_fwd_pddx(std::string_view text, const ColumnMap& columns);

// Throws pave::Error: file, line, key, found, allowed.
FwdFile read_fwd_pddx(std::string_view text, const std::string& file, const ColumnMap& columns);

inline constexpr FwdFormat fwd_pddx = {"PDDX", "the first section is [Pavement Deflection Data Exchange File]",
                                       recognises_fwd_pddx, read_fwd_pddx};

} // namespace explore::data

// Condition classes of a bowl: E. Horak, "Benchmarking the structural condition of flexible pavements with deflection
// bowl parameters", J. SAICE 50(2), 2008; also South African Pavement Engineering Manual, chapter 10 (2014).
//
//                     granular base       bituminous base     cemented base
//     D0 [um]         500  750            400  600            200  400
//     RoC [m]         100   50            250  100            150   80
//     SCI (BLI) [um]  200  400            200  400            100  300
//     BDI (MLI) [um]  100  200            100  200             50  100
//     BCI (LLI) [um]   50  100             50  100             40   80
//
// The first number parts sound from warning, the second warning from severe. For a bowl under 40 kN on a plate of 150
// mm radius (566 kPa), roads of Southern Africa; deflections are taken there in proportion to the pressure.
#pragma once

#include "data/bowl_indices.h"

#include <array>

namespace explore::data {

enum class BaseKind { granular, bituminous, cemented };
inline constexpr std::array<std::string_view, 3> base_kinds = {"granular", "bituminous", "cemented"};

enum class Condition { sound, warning, severe };
inline constexpr std::array<std::string_view, 3> condition_words = {"sound", "warning", "severe"};

inline constexpr double condition_pressure_kPa = 40.0 / (0.15 * 0.15 * 3.14159265358979323846); // of 40 kN on 150 mm

struct ConditionClasses {
    std::optional<Condition> d0{}, roc{}, sci{}, bdi{}, bci{}; // nothing: no sensors from which to tell, another plate
};
// indices: at condition_pressure_kPa.
ConditionClasses condition_of(const BowlIndices& indices, BaseKind base);

} // namespace explore::data

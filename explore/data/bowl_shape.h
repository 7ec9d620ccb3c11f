// The shape of deflection bowls: whether they fall with the distance from the load, and how smoothly.
#pragma once

#include "data/bowl_faults.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace explore::data {

using Bowl = std::vector<BowlPoint>; // of one load, from near to far

std::vector<Bowl> bowls_of(const std::vector<BowlPoint>& readings);
// Of the readings, without their sign.
double largest(const Bowl& bowl);
// Of all sensors, rising.
std::vector<double> offsets_of(const std::vector<Bowl>& bowls);

// BowlPoint* or const BowlPoint*, as the bowl is.
template <class OneBowl>
auto at(OneBowl& bowl, double offset) -> decltype(bowl.data()) {
    constexpr double same = 1e-4; // m
    const auto found = std::find_if(bowl.begin(), bowl.end(),
                                    [&](const BowlPoint& reading) { return std::abs(reading.offset - offset) < same; });
    return found == bowl.end() ? nullptr : &*found;
}

// The first place where it rises; none: it falls.
std::optional<std::pair<std::size_t, std::size_t>> first_rise(const Bowl& bowl);
// Whether bowls rise from one sensor to another under all loads together, each by too little to be sure of.
bool rise_together(const std::vector<Bowl>& bowls, double near, double far);
bool all_fall(const std::vector<Bowl>& bowls);

// The distance, so that the logarithm of a bowl is nearly straight in it.
double stretched(const BowlPoint& reading);
// How much the logarithm bends from sensor to sensor, squared, on average.
double roughness(const std::vector<Bowl>& bowls);

} // namespace explore::data

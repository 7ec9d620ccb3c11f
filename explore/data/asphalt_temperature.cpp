#include "data/asphalt_temperature.h"

#include <cmath>
#include <numbers>

namespace explore::data {
namespace {

// A day's wave of 18 hours with its lowest point held in between.
double wave(double hour, double centre) {
    const double begin = centre - 4.5;
    const double past = hour < begin + 18.0 - 24.0 ? hour + 24.0 : hour;
    return past < begin ? -1.0 : std::sin(2.0 * std::numbers::pi * (past - centre) / 18.0);
}

} // namespace

std::optional<double> measured_asphalt_C(std::optional<double> asphalt_C, std::optional<double> surface_C) {
    constexpr double near_zero = 2.0;
    const bool is_measured = asphalt_C && (*asphalt_C != 0.0 || (surface_C && std::abs(*surface_C) < near_zero));
    return is_measured ? asphalt_C : std::nullopt;
}

double bells3(double surface_C, double air_of_day_before_C, double hour, double depth_mm) {
    return 0.95 + 0.892 * surface_C +
           (std::log10(depth_mm) - 1.25) *
               (-0.448 * surface_C + 0.621 * air_of_day_before_C + 1.83 * wave(hour, 15.5)) +
           0.042 * surface_C * wave(hour, 13.5);
}

double modulus_factor(double from_C, double to_C) {
    return std::pow(10.0, modulus_slope * (to_C - from_C));
}

} // namespace explore::data

#include "data/noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::data {
namespace {

// The absolute part that h has at least, as a share of the relative part at the measured value.
constexpr double least_absolute = 0.1;

} // namespace

double Noise::deviation(double value) const {
    return std::hypot(std::hypot(absolute, drift), relative * value);
}

double Noise::own_deviation(double value) const {
    return std::hypot(absolute,
                      std::sqrt(std::max(0.0, relative * relative - common_relative * common_relative)) * value);
}

double Noise::residual(double model, double measured) const {
    const double fixed = std::hypot(absolute, drift);
    if (relative == 0.0) {
        return (model - measured) / fixed;
    }
    const double floor = std::max(fixed, least_absolute * relative * std::abs(measured));
    const double bias = 0.5 * relative * relative * measured / std::hypot(floor, relative * measured);
    return (std::asinh(relative * model / floor) - std::asinh(relative * measured / floor)) / relative - bias;
}

double Noise::slope(double model, double measured) const {
    const double fixed = std::hypot(absolute, drift);
    if (relative == 0.0) {
        return 1.0 / fixed;
    }
    return 1.0 / std::hypot(std::max(fixed, least_absolute * relative * std::abs(measured)), relative * model);
}

bool is_one_sensor(const NoisePlace& a, const NoisePlace& b) {
    return a.load == b.load && a.load >= 0 && a.quantity == b.quantity && a.x == b.x && a.y == b.y &&
           a.depth == b.depth;
}

double own_correlation(const NoisePlace& a, const NoisePlace& b, double length, double time) {
    if (a.load != b.load || a.load < 0 || a.quantity != b.quantity || a.time.has_value() != b.time.has_value() ||
        (length <= 0.0 && time <= 0.0)) {
        return 0.0;
    }
    // How far apart they are, in units of what keeps errors alike.
    const auto over = [](double difference, double scale) {
        return difference == 0.0 ? 0.0 : scale > 0.0 ? difference / scale : std::numeric_limits<double>::infinity();
    };
    const double distance = std::hypot(a.x - b.x, a.y - b.y, a.depth - b.depth);
    const double difference = a.time ? std::abs(*a.time - *b.time) : 0.0;
    return std::exp(-over(distance, length) - over(difference, time));
}

std::string_view sign_of(Censored censored) {
    return censored == Censored::no ? "" : censored == Censored::below ? "<" : ">";
}

} // namespace explore::data

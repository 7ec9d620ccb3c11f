#include "problem/student.h"

#include <cmath>
#include <numbers>

namespace explore::problem {

double student_row(double z, double degrees) {
    return std::copysign(std::sqrt((degrees + 1.0) * std::log1p(z * z / degrees)), z);
}

double student_row_slope(double z, double degrees) {
    constexpr double next_to_nothing = 1e-8; // the row is linear there, to the last bit
    return std::abs(z) < next_to_nothing ? std::sqrt((degrees + 1.0) / degrees)
                                         : (degrees + 1.0) * z / ((degrees + z * z) * student_row(z, degrees));
}

double student_weight(double z, double degrees) {
    return (degrees + 1.0) / (degrees + z * z);
}

double student_information(double degrees) {
    return (degrees + 1.0) / (degrees + 3.0);
}

double student_log_peak(double degrees) {
    return std::lgamma(0.5 * (degrees + 1.0)) - std::lgamma(0.5 * degrees) - 0.5 * std::log(degrees * std::numbers::pi);
}

double student_draw(double u, double v, double degrees) {
    return std::sqrt(degrees * std::expm1(-2.0 / degrees * std::log(u))) * std::cos(2.0 * std::numbers::pi * v);
}

} // namespace explore::problem

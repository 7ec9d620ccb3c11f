#include "data/rounding.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace explore::data {

namespace {

// All are multiples, of at least three different ones, to what a decimal file keeps of them.
bool are_different_multiples(const std::vector<double>& values, double step) {
    constexpr double tolerance = 2e-3; // of the step
    constexpr std::size_t different = 3;
    std::set<long long> multiples;
    for (const double value : values) {
        const double count = value / step;
        if (std::abs(count) > 1e12 || std::abs(count - std::round(count)) > tolerance) {
            return false;
        }
        multiples.insert(std::llround(count));
    }
    return multiples.size() >= different;
}

} // namespace

double rounding_step(const std::vector<double>& values) {
    constexpr std::size_t least = 6;
    if (values.size() < least) {
        return 0.0;
    }
    double largest = 0.0;
    for (const double value : values) {
        largest = std::max(largest, std::abs(value));
    }
    double found = 0.0;
    constexpr int finest = 7; // powers of ten below the largest value
    const int top = static_cast<int>(std::floor(std::log10(std::max(largest, 1e-300))));
    for (int power = top; power >= top - finest; --power) {
        for (const double digit : {5.0, 2.5, 2.0, 1.0}) {
            for (const double unit : {1.0, 25.4}) {
                const double step = digit * unit * std::pow(10.0, power);
                if (step > found && are_different_multiples(values, step)) {
                    found = step;
                }
            }
        }
        if (found > 10.0 * std::pow(10.0, power)) { // none of a finer power is larger
            break;
        }
    }
    return found;
}

} // namespace explore::data

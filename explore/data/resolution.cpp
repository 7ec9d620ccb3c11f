#include "data/resolution.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace explore::data {
namespace {

constexpr double mil_um = 25.4;
constexpr double finest_um = 0.0999; // 0.1, but for rounding
constexpr double coarsest_um = 100.0;
constexpr double by_chance = 1e-4;
constexpr double by_chance_of_one = 1e-7; // station, of many
constexpr double nearly_all = 0.9;        // a cell mended by hand does not make a file exact

bool are_multiples(const std::vector<double>& values, double step, double share) {
    const auto count = std::count_if(values.begin(), values.end(), [&](double um) {
        const double steps = um / step;
        return std::abs(steps - std::round(steps)) <= 1e-6 + 1e-12 * std::abs(steps);
    });
    return static_cast<double>(count) >= share * static_cast<double>(values.size());
}

// The largest step, in this unit, that this share of the values are multiples of and that is no chance; 0: none.
double coarsest(const std::vector<double>& values, double unit_um, double share, double chance) {
    struct Step {
        double size, over_finer; // of tens over ones, of fives over twos, of twos over ones
    };
    constexpr std::array<Step, 3> steps = {{{10.0, 10.0}, {5.0, 2.5}, {2.0, 2.0}}};
    const auto n = static_cast<double>(values.size());
    for (double power = 10.0; 10.0 * power * unit_um >= finest_um; power /= 10.0) {
        for (const Step& step : steps) {
            const double um = power * step.size * unit_um;
            if (um <= coarsest_um && um >= finest_um && n * std::log(step.over_finer) >= -std::log(chance) &&
                are_multiples(values, um, share)) {
                return um;
            }
        }
    }
    return 0.0;
}

std::vector<double> values_of(const std::vector<const FwdStation*>& stations) {
    std::vector<double> values;
    for (const FwdStation* s : stations) {
        for (const FwdDrop& d : s->drops) {
            for (const FwdReading& r : d.readings) {
                if (r.deflection_um > 0.0 && std::isfinite(r.deflection_um)) {
                    values.push_back(r.deflection_um);
                }
            }
        }
    }
    return values;
}

double coarsest(const std::vector<double>& values, double share, double chance) {
    return std::max(coarsest(values, 1.0, share, chance), coarsest(values, mil_um, share, chance));
}

} // namespace

double resolution_um(const std::vector<const FwdStation*>& stations) {
    return coarsest(values_of(stations), nearly_all, by_chance);
}

double own_resolution_um(const FwdStation& station) {
    return coarsest(values_of({&station}), 1.0, by_chance_of_one);
}

std::string resolution_words(double um) {
    const double mils = um / mil_um;
    const auto is_near = [](double a, double b) { return std::abs(a / b - 1.0) < 1e-6; };
    if (is_near(um, 10.0)) {
        return "whole hundredths of a millimetre";
    }
    if (is_near(um, 100.0)) {
        return "whole tenths of a millimetre";
    }
    if (is_near(um, 1.0)) {
        return "whole micrometres";
    }
    if (is_near(mils, 1.0)) {
        return "whole mils";
    }
    // A step that is round in mils alone was stated in them.
    const double of_decade = mils / std::pow(10.0, std::floor(std::log10(mils) + 1e-9));
    const bool in_mils = is_near(of_decade, 1.0) || is_near(of_decade, 2.0) || is_near(of_decade, 5.0);
    return in_mils ? fmt::format("in steps of {} mil", pave::figure(mils))
                   : fmt::format("in steps of {} um", pave::figure(um));
}

double rounding_variance(double resolution_um, double scatter_um, int drops) {
    if (!(resolution_um > 0.0)) {
        return 0.0;
    }
    constexpr int harmonics = 100;
    const double square = std::pow(resolution_um, 2);
    const double turn = 2.0 * std::numbers::pi * scatter_um / resolution_um;
    double alike = 0.0; // covariance of the rounding errors of two drops
    for (int k = 1; k <= harmonics; ++k) {
        alike += square / (2.0 * std::numbers::pi * std::numbers::pi * k * k) * std::exp(-std::pow(turn * k, 2));
    }
    // Those beyond: the sum of 1 / k^2 from there on.
    alike += square / (2.0 * std::numbers::pi * std::numbers::pi * (harmonics + 0.5)) *
             std::exp(-std::pow(turn * harmonics, 2));
    return alike + (square / 12.0 - alike) / drops;
}

} // namespace explore::data

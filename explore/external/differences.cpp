#include "external/differences.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::external {
namespace {

constexpr double widest = 0.03;    // step, where noise asks for more
constexpr double narrowest = 1e-5; // of central differences, where it asks for less
constexpr double length = 0.3;     // over which responses bend, of the unit cube: assumed

// A noise below this (numbers with all their digits) lets one-sided differences be good to some 1e-6.
constexpr double exact = 1e-12;

} // namespace

std::string Differences::words() const {
    const std::string kind = central ? "central" : "one-sided";
    const std::string cost = central ? "two runs" : "one run";
    return fmt::format("Derivatives are by {} differences in steps of {:.2g} of the ranges, {} a parameter: {}.", kind,
                       step, cost,
                       noise > 0.0 ? fmt::format("the model's own noise is some {:.1g} of how much its responses "
                                                 "change over the ranges, by {} runs at the start",
                                                 noise, runs)
                                   : "its noise could not be estimated at the study's own values");
}

std::optional<double> noise_of(std::vector<double> values) {
    const std::size_t n = values.size() - 1;
    std::vector<double> level;
    std::vector<char> changes_sign;
    double gamma = 1.0;
    for (std::size_t k = 1; k <= n; ++k) {
        double sum = 0.0;
        bool up = false;
        bool down = false;
        std::size_t same = 0;
        for (std::size_t j = 0; j + k <= n; ++j) {
            values[j] = values[j + 1] - values[j];
            sum += values[j] * values[j];
            up = up || values[j] > 0.0;
            down = down || values[j] < 0.0;
            same += values[j] == 0.0 ? 1 : 0;
        }
        if (k == 1 && 2 * same >= n) { // steps too small to be seen
            return std::nullopt;
        }
        gamma *= 0.5 * static_cast<double>(k) / static_cast<double>(2 * k - 1);
        level.push_back(std::sqrt(gamma * sum / static_cast<double>(n + 1 - k)));
        changes_sign.push_back(up && down ? 1 : 0);
    }
    for (std::size_t k = 0; k + 2 < level.size(); ++k) {
        const auto [least, most] = std::minmax({level[k], level[k + 1], level[k + 2]});
        if (least > 0.0 && most <= 4.0 * least && changes_sign[k] != 0) {
            return level[k];
        }
    }
    return std::nullopt;
}

Differences estimate_differences(const RunAt& run, const std::vector<double>& start) {
    Differences result;
    const auto at = [&](double distance) {
        std::vector<double> point = start;
        for (double& coordinate : point) {
            coordinate += coordinate > 0.5 ? -distance : distance;
        }
        ++result.runs;
        return run(point);
    };
    const auto here = at(0.0);
    constexpr double far = 0.1;
    const auto there = here ? at(far) : std::nullopt;
    if (!there) {
        return result;
    }
    const std::size_t count = here->size();
    std::vector<double> scale(count); // change over the whole range
    for (std::size_t i = 0; i < count; ++i) {
        scale[i] = std::abs((*there)[i] - (*here)[i]) / far;
    }
    constexpr int points = 6;
    std::vector<double> found(count, 0.0);
    std::vector<char> open(count);
    std::transform(scale.begin(), scale.end(), open.begin(), [](double s) { return s > 0.0 ? 1 : 0; });
    for (const double distance : {1e-6, 1e-4, 1e-2 / points}) {
        if (std::none_of(open.begin(), open.end(), [](char c) { return c != 0; })) {
            break;
        }
        std::vector<std::vector<double>> line{*here};
        for (int p = 1; p <= points; ++p) {
            auto values = at(p * distance);
            if (!values) {
                return result;
            }
            line.push_back(std::move(*values));
        }
        for (std::size_t i = 0; i < count; ++i) {
            if (open[i] == 0) {
                continue;
            }
            std::vector<double> values;
            std::transform(line.begin(), line.end(), std::back_inserter(values), [&](const auto& v) { return v[i]; });
            if (const auto noise = noise_of(std::move(values))) {
                found[i] = *noise / scale[i];
                open[i] = 0;
            }
        }
    }
    std::vector<double> noises;
    std::copy_if(found.begin(), found.end(), std::back_inserter(noises), [](double noise) { return noise > 0.0; });
    if (noises.empty()) {
        return result;
    }
    const auto middle = noises.begin() + static_cast<std::ptrdiff_t>(noises.size() / 2);
    std::nth_element(noises.begin(), middle, noises.end());
    result.noise = *middle;
    result.central = result.noise > exact;
    // Where the error by curvature and that by noise are equal, of responses that bend over `length`.
    result.step = result.central ? std::clamp(length * std::cbrt(3.0 * result.noise), narrowest, widest)
                                 : 2.0 * length * std::sqrt(std::max(result.noise, 1e-14));
    return result;
}

Stencil stencil_at(double at, const Differences& d) {
    const double h = d.step;
    const double inward = at > 0.5 ? -h : h;
    if (!d.central) {
        return {{at + inward}, {1.0 / inward}};
    }
    if (at - h < 0.0 || at + h > 1.0) { // of second order to one side
        return {{at + inward, at + 2.0 * inward}, {2.0 / inward, -0.5 / inward}};
    }
    return {{at + h, at - h}, {0.5 / h, -0.5 / h}};
}

} // namespace explore::external

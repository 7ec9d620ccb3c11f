#include "external/differences.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace explore::external {
namespace {

constexpr double widest = 0.03;    // step, where noise asks for more
constexpr double narrowest = 1e-5; // of central differences, where it asks for less
constexpr double length = 0.3;     // over which responses bend, of the unit cube: assumed

// A noise below this (numbers with all their digits) lets one-sided differences be good to some 1e-6.
constexpr double exact = 1e-12;

// As far as the point of this number on the way to a distance: not by round numbers, at which printed digits are exact.
constexpr double off_grid = 0.7320508075688772; // sqrt(3) - 1

double length_of(const std::vector<double>& v) {
    return std::sqrt(std::inner_product(v.begin(), v.end(), v.begin(), 0.0));
}

// The narrowest step, of the first and those five times the one before, whose slopes agree with those of the next; a
// further one then keeps what the model rounds away below a fiftieth. slopes_by: of the responses, by differences in
// such steps; nothing: a run has no answer. alike: by what share of them they may differ.
double seen_step(double first, double alike,
                 const std::function<std::optional<std::vector<double>>(double)>& slopes_by) {
    constexpr double wider = 5.0;
    const auto widest_slopes = slopes_by(widest);
    if (!widest_slopes || length_of(*widest_slopes) == 0.0) { // a parameter that does nothing here
        return first;
    }
    double step = first;
    auto slopes = slopes_by(step);
    while (step < widest) {
        const double next = std::min(widest, wider * step);
        auto further = next == widest ? widest_slopes : slopes_by(next);
        if (!slopes || !further) {
            return step;
        }
        std::vector<double> change = *further;
        for (std::size_t i = 0; i < change.size(); ++i) {
            change[i] -= (*slopes)[i];
        }
        if (length_of(*slopes) > 0.0 && length_of(change) < alike * length_of(*further)) {
            return step == first ? first : next;
        }
        step = next;
        slopes = std::move(further);
    }
    return widest;
}

} // namespace

std::string Differences::words() const {
    const std::string kind = central ? "central" : "one-sided";
    const std::string cost = central ? "two runs" : "one run";
    const auto [least, most] = std::minmax_element(steps.begin(), steps.end());
    const std::string size =
        *least == *most ? fmt::format("{:.2g}", *most) : fmt::format("{:.2g} to {:.2g}", *least, *most);
    return fmt::format("Derivatives are by {} differences in steps of {} of the ranges, {} a parameter: {}.", kind,
                       size, cost,
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
    result.steps.assign(start.size(), 1e-3);
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
        std::vector<std::vector<double>> line;
        for (int p = 0; p <= points; ++p) {
            auto values = at((p + off_grid) * off_grid * distance);
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
    const auto slopes_by = [&](std::size_t k, double step) -> std::optional<std::vector<double>> {
        Differences own = result;
        own.steps[k] = step;
        const Stencil stencil = stencil_at(start[k], own, k);
        std::vector<double> slopes(count, 0.0);
        for (std::size_t s = 0; s < stencil.at.size(); ++s) {
            std::vector<double> point = start;
            point[k] = stencil.at[s];
            ++result.runs;
            const auto values = run(point);
            if (!values) {
                return std::nullopt;
            }
            for (std::size_t i = 0; i < count; ++i) {
                slopes[i] += stencil.weights[s] * ((*values)[i] - (*here)[i]);
            }
        }
        return slopes;
    };
    // Wider where a coordinate by itself is not seen. One-sided steps are for models without noise, of which this one
    // is none then.
    const auto widen = [&] {
        const bool is_exact = !result.central;
        for (std::size_t k = 0; k < start.size(); ++k) {
            const double first = result.steps[k];
            result.steps[k] = seen_step(first, is_exact ? 1e-3 : 0.02, [&](double step) { return slopes_by(k, step); });
            if (is_exact && result.steps[k] > first) {
                result.central = true;
                result.steps.assign(start.size(), narrowest);
                break;
            }
        }
        for (std::size_t k = 0; is_exact && result.central && k < start.size(); ++k) {
            result.steps[k] = seen_step(narrowest, 0.02, [&](double step) { return slopes_by(k, step); });
        }
        return result;
    };
    std::vector<double> noises;
    std::copy_if(found.begin(), found.end(), std::back_inserter(noises), [](double noise) { return noise > 0.0; });
    if (noises.empty()) {
        return widen();
    }
    const auto middle = noises.begin() + static_cast<std::ptrdiff_t>(noises.size() / 2);
    std::nth_element(noises.begin(), middle, noises.end());
    result.noise = *middle;
    result.central = result.noise > exact;
    // Where the error by curvature and that by noise are equal, of responses that bend over `length`.
    const double step = result.central ? std::clamp(length * std::cbrt(3.0 * result.noise), narrowest, widest)
                                       : 2.0 * length * std::sqrt(std::max(result.noise, 1e-14));
    result.steps.assign(start.size(), step);
    return widen();
}

Stencil stencil_at(double at, const Differences& d, std::size_t k) {
    const double h = d.steps[k];
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

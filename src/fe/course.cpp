#include "fe/course.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace pave::fe {
namespace {

// Weights on the values and slopes of a cubic at the ends of a unit interval.
using CubicWeights = std::array<double, 4>; // value, slope; value, slope

CubicWeights weights_at(double x) {
    const double y = 1.0 - x;
    return {y * y * (1.0 + 2.0 * x), x * y * y, x * x * (3.0 - 2.0 * x), -x * x * y};
}

// The same of its slope.
CubicWeights slopes_at(double x) {
    return {6.0 * x * (x - 1.0), (1.0 - x) * (1.0 - 3.0 * x), 6.0 * x * (1.0 - x), x * (3.0 * x - 2.0)};
}

// Where such a cubic, with value a and slope da to value b and slope db, is largest.
double place_of_largest(double a, double da, double b, double db) {
    double place = a > b ? 0.0 : 1.0;
    double most = std::max(a, b);
    // Its derivative: c0 + c1 x + c2 x^2
    const double c0 = da;
    const double c1 = 6.0 * (b - a) - 4.0 * da - 2.0 * db;
    const double c2 = 3.0 * (da + db) - 6.0 * (b - a);
    const double root = c1 * c1 - 4.0 * c0 * c2;
    if (root < 0.0) {
        return place;
    }
    const double q = -(c1 + std::copysign(std::sqrt(root), c1)) / 2.0;
    for (const double x : {q / c2, c0 / q}) {
        if (x > 0.0 && x < 1.0) {
            const double value = a + x * (c0 + x * (c1 / 2.0 + x * c2 / 3.0));
            if (value > most) {
                most = value;
                place = x;
            }
        }
    }
    return place;
}

// A weight on what a course holds of one instant.
struct Weight {
    Eigen::Index instant;
    bool on_slope;
    double weight;
};

// The slope at an instant as weights: the course's own, or half the difference of the values beside it. -1: at rest.
void add_slope(const Course& course, Eigen::Index instant, double weight, std::vector<Weight>& to) {
    if (instant < 0) {
        return;
    }
    if (course.slopes.size() > 0) {
        to.push_back({instant, true, weight});
        return;
    }
    const bool is_last = instant + 1 == course.values.cols();
    const double share = is_last ? weight : weight / 2.0;
    to.push_back({is_last ? instant : instant + 1, false, share});
    if (instant > 0) {
        to.push_back({instant - 1, false, -share});
    }
}

double weighted(const Course& course, Eigen::Index reading, const std::vector<Weight>& weights) {
    double sum = 0.0;
    for (const Weight& w : weights) {
        sum += w.weight * (w.on_slope ? course.slopes : course.values)(reading, w.instant);
    }
    return sum;
}

Followed followed(const Course& course, Eigen::Index reading, const std::vector<Weight>& weights) {
    Followed f;
    f.value = weighted(course, reading, weights);
    f.rates.setZero(course.d_values.empty() ? 0 : course.d_values.front().cols());
    for (const Weight& w : weights) {
        const auto instant = static_cast<std::size_t>(w.instant);
        f.rates += w.weight * (w.on_slope ? course.d_slopes : course.d_values)[instant].row(reading);
    }
    return f;
}

} // namespace

std::size_t History::largest() const {
    return static_cast<std::size_t>(std::max_element(factors.begin(), factors.end()) - factors.begin());
}

History haversine(double duration, int steps) {
    History history{.step = duration / steps, .factors = {}};
    for (int i = 1; i <= steps; ++i) {
        const double sine = i < steps ? std::sin(std::numbers::pi * i / steps) : 0.0;
        history.factors.push_back(sine * sine);
    }
    return history;
}

Course::Course(Eigen::Index readings, std::size_t instants, Eigen::Index variations, bool with_slopes)
    : values(Eigen::MatrixXd::Zero(readings, static_cast<Eigen::Index>(instants))),
      d_values(instants, Eigen::MatrixXd::Zero(readings, variations)) {
    if (with_slopes) {
        slopes = values;
        d_slopes = d_values;
    }
}

Course::Course(Eigen::MatrixXd value, Eigen::MatrixXd d_value) : values(std::move(value)) {
    d_values.push_back(std::move(d_value));
}

Followed at_instant(const Course& course, Eigen::Index reading, std::size_t instant) {
    return followed(course, reading, {{static_cast<Eigen::Index>(instant), false, 1.0}});
}

Followed at_time(const Course& course, Eigen::Index reading, double steps, double& slope) {
    const auto last = static_cast<double>(course.values.cols());
    slope = 0.0;
    if (steps <= 0.0 || steps >= last) {
        return steps <= 0.0 ? followed(course, reading, {})
                            : at_instant(course, reading, static_cast<std::size_t>(course.values.cols() - 1));
    }
    const double whole = std::floor(steps);
    const auto i = static_cast<Eigen::Index>(whole); // the instant after; before it i - 1, or the start
    const auto combine = [&](const CubicWeights& share) {
        std::vector<Weight> weights;
        if (i > 0) {
            weights.push_back({i - 1, false, share[0]});
        }
        add_slope(course, i - 1, share[1], weights);
        weights.push_back({i, false, share[2]});
        add_slope(course, i, share[3], weights);
        return weights;
    };
    slope = weighted(course, reading, combine(slopes_at(steps - whole)));
    return followed(course, reading, combine(weights_at(steps - whole)));
}

Followed peak(const Course& course, Eigen::Index reading, double direction) {
    std::vector<Weight> slope;
    std::vector<Weight> at_peak;
    double most = 0.0;
    double before = 0.0;
    double d_before = 0.0;
    for (Eigen::Index i = 0; i < course.values.cols(); ++i) {
        slope.clear();
        add_slope(course, i, 1.0, slope);
        const double now = direction * course.values(reading, i);
        const double d_now = direction * weighted(course, reading, slope);
        const auto share = weights_at(place_of_largest(before, d_before, now, d_now));
        const double here = share[0] * before + share[1] * d_before + share[2] * now + share[3] * d_now;
        if (here > most) {
            most = here;
            at_peak.clear();
            if (i > 0) {
                at_peak.push_back({i - 1, false, share[0]});
            }
            add_slope(course, i - 1, share[1], at_peak);
            at_peak.push_back({i, false, share[2]});
            add_slope(course, i, share[3], at_peak);
        }
        before = now;
        d_before = d_now;
    }
    return followed(course, reading, at_peak);
}

} // namespace pave::fe

// Readings followed over the time of a load, and the one number that stands for each.
//
// A load at rest, a section that relaxes and one whose inertia answers are cases of it: the first has one instant, the
// others one at the end of every step. What else is read of a sensor over time is another functional of the same
// course.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace pave::fe {

// How a load acts in time: the factor on it at the ends of equal steps, linear in between. Before and after, nothing
// acts.
struct History {
    double step = 0.0; // s
    std::vector<double> factors;

    double duration() const { return step * static_cast<double>(factors.size()); }
    // The first step at the end of which the load is largest.
    std::size_t largest() const;
};

// sin^2(pi t / duration) in equal steps.
History haversine(double duration, int steps);

// A load as it was recorded, in steps: its mean factor in each of them, so that every impulse is kept.
struct Pulse {
    double step = 0.0; // s
    std::vector<double> means;
};

// Instant i is the end of step i; before the first everything is at rest and zero.
struct Course {
    Eigen::MatrixXd values;                // a row a reading, a column an instant
    std::vector<Eigen::MatrixXd> d_values; // of every instant: a row a reading, a column a variation
    // Rates of these per step, where the solution has them; empty: they are taken from the values beside.
    Eigen::MatrixXd slopes;
    std::vector<Eigen::MatrixXd> d_slopes;

    Course() = default;
    Course(Eigen::Index readings, std::size_t instants, Eigen::Index variations, bool with_slopes);
    // The one instant of a load that acts so slowly that nothing moves or relaxes meanwhile.
    Course(Eigen::MatrixXd value, Eigen::MatrixXd d_value);
};

// A number and its derivatives by the variations.
struct Followed {
    double value = 0.0;
    Eigen::RowVectorXd rates;
};

Followed at_instant(const Course& course, Eigen::Index reading, std::size_t instant);

// A reading so many steps after the start, by the cubic between the instants beside; `slope`: its rate per step. Zero
// before the start, and after the end as at it.
Followed at_time(const Course& course, Eigen::Index reading, double steps, double& slope);

// The extreme of a reading in a direction (1 or -1): of direction times the reading, the largest value since it was at
// rest, which is zero at least. Between instants the reading is the cubic of their values and slopes, so that the
// extreme is continuous in all that the course depends on; its place is stationary, for derivatives.
Followed peak(const Course& course, Eigen::Index reading, double direction);

} // namespace pave::fe

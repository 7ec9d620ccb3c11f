// The load path: an ordinary differential equation in the load factor, followed from 0 to 1 with error control.
#pragma once

#include "base/outcome.h"
#include "fe/deadline.h"

#include <cmath>
#include <utility>
#include <vector>

namespace pave::fe {

struct PathSteps {
    int accepted = 0;
    int rejected = 0;
};

inline Failure stiffness_not_definite() {
    return {Status::failed, "the stiffness matrix of the section is not positive definite: a layer has lost its "
                            "stiffness along the load path"};
}

// State: zero at the start, with add(factor, rate) that adds a multiple of its rate (of the same type).
template <class State>
class LoadPath {
public:
    // The embedded pair of Bogacki and Shampine (1989), order 3(2): three rates a step, the last of a step is the first
    // of the next.
    static constexpr int stages = 4;

    // The path so far and its rates.
    State now, trial;
    State slope[stages];

    // Begins anew; size: what State::set_zero takes.
    template <class... Size>
    void set_zero(Size... size) {
        now.set_zero(size...);
        trial.set_zero(size...);
        for (State& s : slope) {
            s.set_zero(size...);
        }
    }

    // rate(state, i) sets slope[i] to d(state)/d(load factor), false: the stiffness there is not positive definite.
    // error(gaps) is that of a step to `trial`, relative to what is reached, where gaps[i] times slope[i] add up to
    // the difference of the two solutions. accepted(load factor): `now` and slope[0] belong to it, `trial`
    // and slope[stages - 1] to the load factor before; called at 0 too, which has none before.
    template <class Rate, class Error, class Accepted>
    Outcome<PathSteps> follow(double tolerance, const Deadline& deadline, Rate rate, Error error, Accepted accepted) {
        const Failure not_definite = stiffness_not_definite();
        if (!rate(now, 0)) {
            return not_definite;
        }
        accepted(0.0);
        // Steps are 2^-level, and start at multiples of themselves: the path changes only when a step is accepted or
        // not.
        constexpr long whole = 1L << finest_level;
        PathSteps steps;
        long position = 0;
        int level = first_level;
        while (position < whole) {
            const long step = whole >> level;
            const double h = load_factor(static_cast<double>(position + step) / whole) -
                             load_factor(static_cast<double>(position) / whole);
            for (int i = 1; i < stages; ++i) {
                trial = now;
                for (int j = 0; j < i; ++j) {
                    if (const double f = h * a[i][j]; f != 0.0) {
                        trial.add(f, slope[j]);
                    }
                }
                if (deadline.has_passed()) {
                    return Deadline::failure();
                }
                if (!rate(trial, i)) {
                    return not_definite;
                }
            }
            double gaps[stages];
            for (int i = 0; i < stages; ++i) {
                gaps[i] = h * difference[i];
            }
            const double relative = error(gaps);
            if (!(relative <= tolerance)) {
                ++steps.rejected;
                if (++level > finest_level) {
                    return Failure{Status::failed,
                                   "the load path cannot be followed to the tolerance: the modulus changes too "
                                   "abruptly with stress for these parameters"};
                }
                continue;
            }
            ++steps.accepted;
            position += step;
            std::swap(now, trial);
            std::swap(slope[0], slope[stages - 1]);
            accepted(load_factor(static_cast<double>(position) / whole));
            const bool easy = relative < tolerance * std::pow(0.5, order + 1.0);
            if (easy && level > coarsest_level && position % (2 * step) == 0) {
                --level;
            }
        }
        return steps;
    }

private:
    static constexpr double a[stages][stages] = {{}, {1.0 / 2.0}, {0.0, 3.0 / 4.0}, {2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0}};
    static constexpr double difference[stages] = {2.0 / 9.0 - 7.0 / 24.0, 1.0 / 3.0 - 1.0 / 4.0, 4.0 / 9.0 - 1.0 / 3.0,
                                                  -1.0 / 8.0};
    static constexpr double order = 3.0;

    static constexpr int coarsest_level = 2; // steps of 1/4
    static constexpr int first_level = 3;    // the first step tried is 1/8
    static constexpr int finest_level = 14;

    // The load factor as a function of the path coordinate s in [0, 1]. The soil is nearly unstressed at the start and
    // its modulus changes with the logarithm of the load: equal steps in s are small steps in load there.
    static double load_factor(double s) {
        constexpr double growth = 4.0;
        return std::expm1(growth * s) / std::expm1(growth);
    }
};

} // namespace pave::fe

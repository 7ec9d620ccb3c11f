// The load path: an ordinary differential equation in the load factor, followed from 0 to 1 in a fixed sequence of
// steps. What it ends in is as smooth in every parameter as the laws are, and its derivatives with the steps held are
// the true ones.
#pragma once

#include "base/outcome.h"
#include "fe/deadline.h"

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

namespace pave::fe {

inline Failure stiffness_not_definite() {
    return {Status::failed, "the stiffness matrix of the section is not positive definite: a layer has lost its "
                            "stiffness along the load path"};
}

// The load factor after i of n steps: short ones first, where the soil is nearly unstressed and its modulus changes
// most.
inline double load_factor_after(int i, int n) {
    return std::pow(static_cast<double>(i) / n, 1.75);
}

// State: zero at the start, with set_sum(from, factors, rates): itself becomes another plus multiples of rates, all of
// the same type.
template <class State>
class LoadPath {
public:
    // Rates a step. Of the formulas of third order with three (Kutta 1901) the one with the nodes of Radau's
    // quadrature: where stress grows with the load, so that the modulus is a function of the load, it is of fifth
    // order.
    static constexpr int stages = 3;

    // The path so far and its rates.
    State now, trial;
    State slope[stages];

    const State& rate_before() const { return slope[1]; }

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
    // ended(load factor): `now` and slope[0] belong to it, `trial` and rate_before() to the load factor before; called
    // at 0 too, which has none before. rate_at_end: whether slope[0] is wanted at the end, where no step needs it.
    template <class Rate, class Ended>
    std::optional<Failure> follow(int steps, bool rate_at_end, const Deadline& deadline, Rate rate, Ended ended) {
        if (!rate(now, 0)) {
            return stiffness_not_definite();
        }
        ended(0.0);
        for (int step = 0; step < steps; ++step) {
            const double end = load_factor_after(step + 1, steps);
            const double h = end - load_factor_after(step, steps);
            for (int i = 1; i < stages; ++i) {
                set_trial(h, of_rates[i - 1], i);
                if (deadline.has_passed()) {
                    return Deadline::failure();
                }
                if (!rate(trial, i)) {
                    return stiffness_not_definite();
                }
            }
            set_trial(h, of_rates[stages - 1], stages);
            std::swap(now, trial);
            std::swap(slope[0], slope[1]);
            if ((step + 1 < steps || rate_at_end) && !rate(now, 0)) {
                return stiffness_not_definite();
            }
            ended(end);
        }
        return std::nullopt;
    }

private:
    // trial = now + h times the sum of the first `count` rates by these factors.
    void set_trial(double h, const std::array<double, stages>& factors_of_h, int count) {
        std::array<double, stages> factors{};
        std::array<const State*, stages> rates{};
        for (int j = 0; j < count; ++j) {
            factors[j] = h * factors_of_h[j];
            rates[j] = &slope[j];
        }
        const auto size = static_cast<std::size_t>(count);
        trial.set_sum(now, {factors.data(), size}, {rates.data(), size});
    }

    static constexpr double root_6 = 2.449489742783178;
    static constexpr double c2 = (6.0 - root_6) / 10.0;
    static constexpr double c3 = (6.0 + root_6) / 10.0;
    static constexpr double a32 = c3 * (c3 - c2) / (c2 * (2.0 - 3.0 * c2)); // third order
    static constexpr std::array<double, stages> of_rates[stages] = {
        {c2}, {c3 - a32, a32}, {1.0 / 9.0, (16.0 + root_6) / 36.0, (16.0 - root_6) / 36.0}};
};

} // namespace pave::fe

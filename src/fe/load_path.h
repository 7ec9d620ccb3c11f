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

// The load factor after i of n steps. The soil is nearly unstressed at the start, and its modulus changes with
// the logarithm of the load: steps grow evenly, to exp(growth) times the first.
inline double load_factor_after(int i, int n) {
    constexpr double growth = 2.5;
    return i == n ? 1.0 : std::expm1(growth * i / n) / std::expm1(growth);
}

// State: zero at the start, with set_sum(from, factors, rates): itself becomes another plus multiples of rates, all of
// the same type.
template <class State>
class LoadPath {
public:
    // The formula of third order of Bogacki and Shampine (1989): three rates a step, the last of a step is the first of
    // the next.
    static constexpr int stages = 4;

    // The path so far and its rates.
    State now, trial;
    State slope[stages];

    const State& rate_before() const { return slope[stages - 1]; }

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
                std::array<double, stages> factors{};
                std::array<const State*, stages> rates{};
                std::size_t count = 0;
                for (int j = 0; j < i; ++j) {
                    if (const double f = h * a[i][j]; f != 0.0) {
                        factors[count] = f;
                        rates[count++] = &slope[j];
                    }
                }
                trial.set_sum(now, {factors.data(), count}, {rates.data(), count});
                if (deadline.has_passed()) {
                    return Deadline::failure();
                }
                const bool at_end = step + 1 == steps && i + 1 == stages;
                if ((!at_end || rate_at_end) && !rate(trial, i)) {
                    return stiffness_not_definite();
                }
            }
            std::swap(now, trial);
            std::swap(slope[0], slope[stages - 1]);
            ended(end);
        }
        return std::nullopt;
    }

private:
    static constexpr double a[stages][stages] = {{}, {1.0 / 2.0}, {0.0, 3.0 / 4.0}, {2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0}};
};

} // namespace pave::fe

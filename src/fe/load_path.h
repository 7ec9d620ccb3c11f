#pragma once
#include "base/outcome.h"
#include "fe/deadline.h"
#include <cmath>
#include <cstdlib>
#include <string>
#include <optional>
#include <utility>
namespace pave::fe {
inline Failure stiffness_not_definite() {
    return {Status::failed, "the stiffness matrix of the section is not positive definite: a layer has lost its "
                            "stiffness along the load path"};
}
inline double env(const char* n, double d) { const char* s = std::getenv(n); return s ? std::atof(s) : d; }
inline double load_factor_after(int i, int n) {
    static const double growth = env("PATH_GROWTH", 2.5), power = env("PATH_POWER", 0), mix = env("PATH_MIX", 0);
    const double s = double(i) / n;
    if (i == n) return 1.0;
    if (power > 0) return mix * s + (1 - mix) * std::pow(s, power);
    return std::expm1(growth * s) / std::expm1(growth);
}
struct Tab { int m; double a[7][7]; };
inline const Tab& tab() {
    static const Tab tabs[] = {
        {4, {{}, {1.0 / 2.0}, {0.0, 3.0 / 4.0}, {2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0}}},
        {7, {{}, {0.2}, {3.0/40, 9.0/40}, {44.0/45, -56.0/15, 32.0/9}, {19372.0/6561, -25360.0/2187, 64448.0/6561, -212.0/729},
             {9017.0/3168, -355.0/33, 46732.0/5247, 49.0/176, -5103.0/18656}, {35.0/384, 0, 500.0/1113, 125.0/192, -2187.0/6784, 11.0/84}}},
        {7, {{}, {0.161}, {-0.008480655492356989, 0.335480655492357}, {2.8971530571054935, -6.359448489975075, 4.3622954328695815},
             {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525},
             {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383},
             {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081, 2.324710524099774}}},
        {5, {{}, {0.4}, {-3.0/20, 3.0/4}, {19.0/44, -15.0/44, 10.0/11}, {11.0/72, 25.0/72, 25.0/72, 11.0/72}}},
    };
    static const int which = int(env("PATH_METHOD", 0));
    return tabs[which];
}
template <class State>
class LoadPath {
public:
    static constexpr int stages = 7;
    State now, trial;
    State slope[stages];
    const State& rate_before() const { return slope[tab().m - 1]; }
    template <class... Size>
    void set_zero(Size... size) {
        now.set_zero(size...);
        trial.set_zero(size...);
        for (State& s : slope) s.set_zero(size...);
    }
    template <class Rate, class Ended>
    std::optional<Failure> follow(int steps, const Deadline& deadline, Rate rate, Ended ended) {
        const Tab& t = tab();
        if (!rate(now, 0)) return stiffness_not_definite();
        ended(0.0);
        for (int step = 0; step < steps; ++step) {
            const double end = load_factor_after(step + 1, steps);
            const double h = end - load_factor_after(step, steps);
            for (int i = 1; i < t.m; ++i) {
                trial = now;
                for (int j = 0; j < i; ++j)
                    if (const double f = h * t.a[i][j]; f != 0.0) trial.add(f, slope[j]);
                if (deadline.has_passed()) return Deadline::failure();
                if (!rate(trial, i)) return stiffness_not_definite();
            }
            std::swap(now, trial);
            std::swap(slope[0], slope[t.m - 1]);
            ended(end);
        }
        return std::nullopt;
    }
};
} // namespace pave::fe

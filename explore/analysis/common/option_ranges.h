// Allowed values of the options of analyses, for every way to call one.
#pragma once

#include "run/budget.h"

namespace explore::analysis::allowed {

struct Whole {
    int low = 0, high = 0;
};
struct Real {
    double low = 0.0, high = 0.0;
};

inline constexpr Whole threads{1, 4096};
inline constexpr Real model_error{0.01, 100.0}; // %

inline constexpr Real budget{run::least_budget, run::most_budget}; // s, of a whole analysis

inline constexpr Whole fit_explore{1, 1'000'000};
inline constexpr Whole fit_starts{1, 10'000};
inline constexpr Whole fit_evaluations{1, 100'000}; // of one search
inline constexpr Whole map_points{1, 10'000'000};
inline constexpr Whole unique_explore{1, 100'000};
inline constexpr Whole unique_verify{1, 10'000};
inline constexpr Whole unique_searches{1, 50'000};
inline constexpr Whole sample_draws{400, 1'000'000};
inline constexpr Whole sample_confirm{1, 1'000'000};
inline constexpr Whole diagnose_explore{1, 100'000};
inline constexpr Whole diagnose_starts{1, 10'000};
inline constexpr Whole diagnose_bootstrap{1, 100'000};
inline constexpr Whole compare_explore{1, 1'000'000};
inline constexpr Whole compare_verify{1, 100'000};
inline constexpr Real sensitivity_range{0.1, 100.0}; // %
inline constexpr Whole sensitivity_points{2, 1001};
inline constexpr Whole sensitivity_samples{0, 1'000'000};
inline constexpr Real design_reliability{50.0, 97.5}; // %, within the 95 % range
inline constexpr Real design_years{0.1, 200.0};

} // namespace explore::analysis::allowed

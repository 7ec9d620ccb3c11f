// Quantiles and variances that intervals and tests share.
#pragma once

namespace explore::inference {

inline constexpr double two_sided_95 = 1.959963984540054;   // of the standard normal
inline constexpr double chi2_95 = 3.841458820694124;        // of chi2 with one degree of freedom
inline constexpr double chi2_95_of_two = 5.991464547107979; // with two: -2 ln 0.05
inline constexpr double box_variance = 1.0 / 12.0;          // of a parameter anywhere in its range, unit coordinates

} // namespace explore::inference

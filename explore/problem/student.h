// Errors of Student's t distribution with nu degrees of freedom and scale 1: normal in the middle, with heavier tails,
// so that a single wrong reading cannot pull an answer far (Lange, Little and Taylor 1989, Journal of the American
// Statistical Association 84).
#pragma once

namespace explore::problem {

// A row whose square is -2 ln(density of z / density of 0), with the sign of z:
//     sign(z) sqrt((nu + 1) ln(1 + z^2 / nu)).
// It grows without end, but ever more slowly, so least squares of such rows is the most likely answer.
double student_row(double z, double degrees);
// Its derivative by z: sqrt((nu + 1) / nu) at 0, and falling to 0 on both sides.
double student_row_slope(double z, double degrees);
// (nu + 1) / (nu + z^2): what z^2 counts in the weighted least squares with the same answer, where normal noise of
// that scale has 1.
double student_weight(double z, double degrees);
// Fisher's information on a shift of z: (nu + 1) / (nu + 3), 1 of the standard normal.
double student_information(double degrees);
// The logarithm of the density of 0.
double student_log_peak(double degrees);
// A draw, of two independent numbers uniform in (0, 1) (Bailey 1994, Mathematics of Computation 62, 779).
double student_draw(double u, double v, double degrees);

} // namespace explore::problem

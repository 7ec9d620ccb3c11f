// Readings of which only a limit is known (data::Censored), of normal errors: with z the residual of the model against
// the limit in standard deviations, the reading lies below it with the probability Phi(-z), above it with Phi(z)
// (Tobin 1958, Econometrica 26).
#pragma once

#include "data/noise.h"

namespace explore::problem {

// The signed deviance residual: a row whose square is -2 ln of that probability,
//     below: sqrt(-2 ln Phi(-z)),   above: -sqrt(-2 ln Phi(z)).
// It is next to 0 where the model lies on the side that is known, z far on the other, and smooth between, so least
// squares of such rows is the most likely answer.
double censored_row(double z, data::Censored side);
// Its derivative by z: from row^2 = -2 ln Phi(-z), 2 row row' = 2 phi(z) / Phi(-z), so with the inverse of Mills' ratio
// m(z) = phi(z) / Phi(-z) it is m(z) / row; above: m(-z) / |row|.
double censored_row_slope(double z, data::Censored side);
// The information of the reading on a shift of z: -d^2 ln Phi(-z) / dz^2 = m (m - z), from 0 on the side that is known
// to 1 on the other, where it counts as much as a reading with a value.
double censored_information(double z, data::Censored side);

} // namespace explore::problem

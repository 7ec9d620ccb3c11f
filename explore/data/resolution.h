// The step in which a file states its deflections, and what that hides.
#pragma once

#include "data/fwd.h"

#include <string>

namespace explore::data {

// In um: the largest of 1, 2 or 5 times a power of ten, in micrometres or mils, that nine in ten deflections are
// multiples of. 0: none of 0.1 um or more, or too few readings to tell it from chance (1 in 10,000 against the next
// finer step).
double resolution_um(const std::vector<const FwdStation*>& stations);
// Of one of many stations: the same of all its deflections, and 1 in 10,000,000.
double own_resolution_um(const FwdStation& station);

// Steps beyond which rounding is more than a sensor errs by anyway [um].
inline constexpr double fine_um = 2.0;

// "whole hundredths of a millimetre", "steps of 5 um", "whole mils".
std::string resolution_words(double resolution_um);

// Variance [um^2] that rounding to steps q adds to the mean of n repeated readings which scatter by s [um] before they
// are rounded:
//     c + (q^2 / 12 - c) / n,   c = sum over k of q^2 / (2 pi^2 k^2) exp(-(2 pi k s / q)^2),
// c the covariance of the rounding errors of two of them, from the Fourier series of what rounding takes off, whatever
// the value is (Widrow 1956 on the characteristic function of rounding). Errors of readings that scatter by much less
// than a step are the same in all of them, of those that scatter by more independent.
double rounding_variance(double resolution_um, double scatter_um, int drops);

} // namespace explore::data

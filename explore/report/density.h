// Where weighted points of a square are densest.
#pragma once

#include "report/contours.h"

#include <span>

namespace explore::report {

// The border of the region that holds a share (0.95) of the mass of points in the unit square and is the smallest such
// one: there their density exceeds the level that this share of the points exceeds, each by the other points. The
// density is that of normal kernels with the covariance of the points times n^(-1/3), n the effective number of points
// (Scott 2015, Multivariate Density Estimation, 6.3), mirrored at the edges of the square. None for less than ten
// points. weight: not negative, of any sum.
std::vector<Contour> densest_region(std::span<const double> x, std::span<const double> y,
                                    std::span<const double> weight, double share);

} // namespace explore::report

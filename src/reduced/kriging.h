// Interpolation of scattered values by a Gaussian process.
#pragma once

#include <Eigen/Core>

namespace pave::reduced {

// value(x) = mean + sum over samples of k(|x - place| by lengths) factor, k the Matern kernel of order 5/2, which has
// continuous second derivatives (Rasmussen and Williams 2006, eq. 4.17).
struct Kriging {
    Eigen::VectorXd lengths; // of each coordinate
    Eigen::MatrixXd places;  // coordinates x samples, each divided by its length
    Eigen::VectorXd factors; // of each sample
    double mean = 0.0;
    double spacing = 0.0; // distance, in lengths, within which nine samples of ten have another one

    // The value at x; with `gradient`, its derivatives by x.
    double at(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const;
    // Distance from x to the nearest sample by the spacing of the samples, at least 1: beyond it the value is a guess.
    double reach(const Eigen::VectorXd& x) const;
};

// Of samples at places (coordinates x samples, each coordinate about from -1 to 1). The lengths and the noise are those
// with the least sum of squares of what the samples are missed by when each is left out in turn (eq. 5.12 there).
Kriging krige(const Eigen::MatrixXd& places, const Eigen::VectorXd& values);

} // namespace pave::reduced

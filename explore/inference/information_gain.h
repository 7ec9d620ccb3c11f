// The information in one more reading, by how widely draws of the unknowns spread its predicted value.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace explore::inference {

// Expected information [bits] of a reading with normal noise about unknowns that are known by draws: the entropy of the
// reading less that of its noise (Lindley 1956, doi 10.1214/aoms/1177728069), by the density of normal kernels about
// all other values (Hall and Morton 1993, doi 10.1007/BF00773669), each as wide as its neighbours are far (Breiman,
// Meisel and Purcell 1977). That of the reading's linear part over all draws, and what the sample says that its
// curvature adds or takes: of a normal posterior and a linear reading ln(1 + s^2) / (2 ln 2), s its standard deviation
// in units of the noise, to some hundredths of a bit. draws: a row each, in any coordinates; sample: some of the rows;
// predicted: the reading of each of the sample, in standard deviations of its noise.
double information_gain(const Eigen::MatrixXd& draws, const std::vector<Eigen::Index>& sample,
                        const Eigen::VectorXd& predicted);

} // namespace explore::inference

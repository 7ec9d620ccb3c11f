// Structures of errors beside independent ones of the stated size: hypotheses on the noise, judged to first order
// around the fit of the study's model.
#pragma once

#include "data/noise.h"
#include "hypotheses/evidence.h"

#include <string>

namespace explore::hypotheses {

// A fit to first order: residuals in units of the stated noise, and their derivatives by the unit coordinates that are
// free to follow them.
struct LinearFit {
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
};

struct NoiseStructure {
    std::string key;              // "common", "correlated", "heavy-tailed"
    double size = 0.0;            // the most probable: share of the value; m; degrees of freedom
    double low = 0.0, high = 0.0; // 95 %, of the sizes that are thought of
    bool ends = false;            // the range reaches the largest of them
    Eigen::MatrixXd covariance{}; // of the coordinates there, by the stated size; empty: as without it
    double chi2 = 0.0;            // of the whitened residuals there, by the stated size; heavy tails: of weighted ones
    Evidence evidence;            // averaged over the sizes that are thought of
};

// Errors that the readings of a load share, of a share of their values, beside the stated ones or as a part of them;
// common: d(residuals)/d(ln value) of all readings of one load, a column each load.
NoiseStructure common_errors(const LinearFit& fit, const Eigen::MatrixXd& common, const NoisePrior& noise);
// Errors of readings of one quantity under one load that are alike the nearer they are (data::own_correlation).
NoiseStructure correlated_errors(const LinearFit& fit, const std::vector<data::NoisePlace>& places,
                                 const NoisePrior& noise);
// Student's t distribution with four degrees of freedom.
NoiseStructure heavy_tails(const LinearFit& fit, const NoisePrior& noise);

} // namespace explore::hypotheses

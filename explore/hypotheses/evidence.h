// The marginal likelihood of a hypothesis, by Laplace's approximation around its fit, with the size of the noise
// unknown.
//
// With n residuals r in units of the stated noise, fitted by d coordinates x with prior density p(x),
//     ln E(k) = -n ln k - S / (2 k^2) + ln[p(x) (2 pi)^(d/2)] - 1/2 ln det(J'J / k^2 + P)
// where the noise is k times what is stated: S the sum of squares at the fit, J the derivatives of r, P the precision
// of the prior. k is 1 with probability `as_stated`; else its logarithm is normal around 0 (but for n ln(sqrt(2 pi)),
// the same for all).
#pragma once

#include <Eigen/Dense>

#include <vector>

namespace explore::hypotheses {

// Prior knowledge of the size of the noise.
struct NoisePrior {
    double as_stated = 0.5;      // probability
    double log_deviation = 0.35; // of ln k, else: twice the stated noise is two of it
};
// Where none is stated and the unit is what a fit leaves: any size.
NoisePrior any_noise();

// Prior knowledge of coordinates, at the fit.
struct Prior {
    Eigen::MatrixXd precision; // as it is felt where the data say nothing
    double log_volume = 0.0;   // ln[p(x) (2 pi)^(d/2)]

    // Parameters that may lie anywhere in their ranges.
    static Prior of_parameters(Eigen::Index count);
    // Adds the size of an effect: Cauchy's distribution around `null` with `typical` at its half width, within 0 to 1
    // (unit coordinates), on one side where null is an end.
    void add_size(double null, double typical, double size);
    // Adds the size of a layout of sensors as a whole: normal around the whole move, by as much as sensors stand off
    // it.
    void add_layout(double null, double whole, double size);
    // The part of the posterior of a size that lies within its range, by its deviation.
    void cut_off(double size, double deviation);
    // Adds coordinates with a normal prior. away: from its mean.
    void add_normal(const Eigen::MatrixXd& precision, const Eigen::VectorXd& away);
};

struct Evidence {
    double as_stated = 0.0;                   // ln E(1)
    double any_size = 0.0;                    // ln of E averaged over the prior of k that is not 1
    double log = 0.0;                         // ln of both together
    double noise = 1.0;                       // the most probable k where it is free
    double by_data = 1.0;                     // what these data alone say of it, and
    double noise_low = 1.0, noise_high = 1.0; // between what (95 %)
};

// sum: S; rows: n; jacobian: J. log_determinant: ln det of what whitened the residuals, 0 where they are as stated.
Evidence evidence(double sum, Eigen::Index rows, const Eigen::MatrixXd& jacobian, const Prior& prior,
                  const NoisePrior& noise, double log_determinant = 0.0);

// ln of the sum of exponentials.
double log_sum(const std::vector<double>& logarithms);

} // namespace explore::hypotheses

// Average over models that may lack something, for a quantity that nobody measured, to first order. Around a point, in
// standard deviations of the noise,
//     z(u, c) = z + J du + A dc,   z(u, c) ~ N(0, I),   u ~ N(1/2, 1/12),   c ~ N(none, R R'),
// u the parameters in unit coordinates and c what the model may lack: the size of an effect, or the coefficients of a
// correction. A hypothesis then has a marginal likelihood, and gives ln|output| a normal distribution; several are
// averaged by their likelihoods (Hoeting et al. 1999, Statistical Science 14, 382).
#pragma once

#include <Eigen/Dense>

#include <vector>

namespace explore::diagnose {

// A model at a point, with its derivatives by all coordinates: parameters first, then what the model may lack.
struct Slopes {
    Eigen::VectorXd at;          // unit coordinates
    Eigen::VectorXd residuals;   // in standard deviations
    Eigen::MatrixXd rows;        // residuals by coordinates
    Eigen::VectorXd outputs;     // ln|value|
    Eigen::MatrixXd output_rows; // outputs by coordinates
};

struct Said {
    double log_evidence = 0.0; // ln of the marginal likelihood, but for -rows/2 ln(2 pi)
    double left = 0.0;         // sum of squares of the residuals at `best`
    Eigen::VectorXd mean;      // of ln|output|, and the standard deviation
    Eigen::VectorXd deviation;
    Eigen::VectorXd best; // most probable coordinates
};

// parameters: how many of the coordinates. none: the others where nothing is lacking; reach: R, square and regular.
Said say(const Slopes& slopes, Eigen::Index parameters, const Eigen::VectorXd& none, const Eigen::MatrixXd& reach);

// Where the distribution function of a mixture of normal distributions is p. Weights sum to 1; a deviation may be 0.
double mixture_quantile(const std::vector<double>& weights, const std::vector<double>& means,
                        const std::vector<double>& deviations, double p);

} // namespace explore::diagnose

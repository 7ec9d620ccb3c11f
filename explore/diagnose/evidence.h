// Does a smooth correction of the model explain what a fit leaves, and how strong is it? To first order, in standard
// deviations of the noise:
//     z = M e + A c,   e ~ N(0, I),   c ~ N(0, s^2 C),
// z the residuals and A what the correction's coefficients c change in them (with the sign of z), both as far as no
// parameter follows them (M), C the prior correlation of the coefficients, s the strength. s is where the marginal
// likelihood of z is largest, which is the restricted likelihood of the readings (Patterson and Thompson 1971,
// Biometrika 58, 545; as a smoothing parameter Wahba 1990, Spline Models for Observational Data).
#pragma once

#include "diagnose/screening.h"

namespace explore::diagnose {

// The correlation of coefficients side by side, falling by this from each to the next: the first-order roughness
// penalty with a level that is held too.
inline constexpr double neighbour_correlation = 0.6;
Eigen::MatrixXd prior_correlation(std::size_t coefficients);

// A channel: one place of the model where a correction may act.
class ChannelEvidence {
public:
    // change: A, residuals by coefficients.
    explicit ChannelEvidence(const Eigen::MatrixXd& change);

    struct Estimate {
        double strength = 0.0;  // s; 0: nothing speaks for it
        double log_ratio = 0.0; // ln of the marginal likelihood there, over that without the correction; not below 0
    };
    // free: rows less the directions that parameters follow. estimated: the noise is of unknown size, and z in any
    // unit.
    Estimate estimate(const Eigen::VectorXd& z, bool estimated, int free) const;
    // ln of the ratio at a strength.
    double log_ratio(const Eigen::VectorXd& z, double strength, bool estimated, int free) const;

private:
    double log_ratio_of(const Eigen::VectorXd& projected, double rest, double strength, bool estimated, int free) const;

    static double log_ratio_of(double explained, double log_determinant, double rest, bool estimated, int free);

    Eigen::MatrixXd directions_; // orthonormal: eigenvectors of A C A'
    Eigen::VectorXd weights_;    // its eigenvalues
    // At the strengths that an estimate looks at first:
    Eigen::MatrixXd shares_; // of every weight, what it explains of what lies in its direction
    Eigen::VectorXd log_determinants_;
};

// A channel that is in the model already.
struct Accepted {
    std::size_t channel = 0;
    double strength = 0.0;
};

struct ChannelTest {
    double strength = 0.0;
    double log_ratio = 0.0;
    double p_familywise = 1.0; // that noise alone makes the largest of all channels as large
};

// Tests every channel beside those that are accepted; these themselves have no result. changes: A of each channel,
// before what parameters follow is taken out. residuals: as if no correction were in the model. The largest of all
// under noise alone is simulated with 9,999 draws, so no p is below 1e-4.
std::vector<ChannelTest> test_channels(const Eigen::VectorXd& residuals, const std::vector<Eigen::MatrixXd>& changes,
                                       const std::vector<Accepted>& accepted, const inference::Nuisance& nuisance,
                                       bool estimated, std::uint64_t seed);

// The strengths of accepted channels together: each at its best beside the others, in turn.
void estimate_strengths(const Eigen::VectorXd& residuals, const std::vector<Eigen::MatrixXd>& changes,
                        std::vector<Accepted>& accepted, const inference::Nuisance& nuisance, bool estimated);

} // namespace explore::diagnose

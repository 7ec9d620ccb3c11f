#include "diagnose/evidence.h"

#include "base/random.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd prior_correlation(std::size_t coefficients) {
    const auto k = static_cast<Index>(coefficients);
    MatrixXd c(k, k);
    for (Index i = 0; i < k; ++i) {
        for (Index j = 0; j < k; ++j) {
            c(i, j) = std::pow(neighbour_correlation, static_cast<double>(std::abs(i - j)));
        }
    }
    return c;
}

namespace {

// Of the logarithm of a modulus: from what nobody would see to a factor of 4.5 as one standard deviation.
constexpr double weakest = 0.02;
constexpr double strongest = 1.5;
constexpr int steps = 18;
const double step_ratio = std::pow(strongest / weakest, 1.0 / steps);

double grid_strength(Index i) {
    return weakest * std::pow(step_ratio, i);
}

} // namespace

ChannelEvidence::ChannelEvidence(const MatrixXd& change) {
    const MatrixXd factor = prior_correlation(static_cast<std::size_t>(change.cols())).llt().matrixL();
    const Eigen::JacobiSVD<MatrixXd> svd(change * factor, Eigen::ComputeThinU);
    directions_ = svd.matrixU();
    weights_ = svd.singularValues().cwiseAbs2();
    shares_.resize(steps + 1, weights_.size());
    log_determinants_.resize(steps + 1);
    for (Index i = 0; i <= steps; ++i) {
        const Eigen::ArrayXd more = std::pow(grid_strength(i), 2) * weights_.array();
        shares_.row(i) = more / (1.0 + more);
        log_determinants_[i] = more.log1p().sum();
    }
}

double ChannelEvidence::log_ratio_of(double explained, double log_determinant, double rest, bool estimated, int free) {
    const double likelihood = estimated ? -free * std::log1p(-std::min(explained / rest, 1.0 - 1e-12)) : explained;
    return (likelihood - log_determinant) / 2.0;
}

double ChannelEvidence::log_ratio_of(const VectorXd& projected, double rest, double strength, bool estimated,
                                     int free) const {
    const Eigen::ArrayXd more = strength * strength * weights_.array();
    const double explained = (projected.array().square() * more / (1.0 + more)).sum();
    return log_ratio_of(explained, more.log1p().sum(), rest, estimated, free);
}

double ChannelEvidence::log_ratio(const VectorXd& z, double strength, bool estimated, int free) const {
    return log_ratio_of(directions_.transpose() * z, z.squaredNorm(), strength, estimated, free);
}

ChannelEvidence::Estimate ChannelEvidence::estimate(const VectorXd& z, bool estimated, int free) const {
    const VectorXd projected = directions_.transpose() * z;
    const double rest = z.squaredNorm();
    Estimate best;
    const auto look_at = [&](double strength, double value) {
        if (value > best.log_ratio) {
            best = {strength, value};
        }
    };
    const VectorXd explained = shares_ * projected.cwiseAbs2();
    for (Index i = 0; i <= steps; ++i) {
        look_at(grid_strength(i), log_ratio_of(explained[i], log_determinants_[i], rest, estimated, free));
    }
    if (best.strength > 0.0) {
        double step = step_ratio;
        for (int i = 0; i < 5; ++i) {
            step = std::sqrt(step);
            const double middle = best.strength;
            for (const double strength : {middle / step, std::min(strongest, middle * step)}) {
                look_at(strength, log_ratio_of(projected, rest, strength, estimated, free));
            }
        }
    }
    return best;
}

namespace {

// The transform that makes independent what noise and these corrections do together: (I + sum of s^2 A C A')^(-1/2).
MatrixXd whitening(const std::vector<MatrixXd>& changes, const std::vector<Accepted>& accepted, Index rows) {
    MatrixXd covariance = MatrixXd::Identity(rows, rows);
    for (const Accepted& a : accepted) {
        const MatrixXd& change = changes[a.channel];
        covariance += a.strength * a.strength * change * prior_correlation(static_cast<std::size_t>(change.cols())) *
                      change.transpose();
    }
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(covariance).operatorInverseSqrt();
}

MatrixXd beyond(const inference::Nuisance& nuisance, MatrixXd change) {
    for (Index k = 0; k < change.cols(); ++k) {
        change.col(k) = nuisance.beyond(change.col(k));
    }
    return change;
}

std::vector<MatrixXd> beyond(const inference::Nuisance& nuisance, const std::vector<MatrixXd>& changes) {
    std::vector<MatrixXd> list;
    list.reserve(changes.size());
    for (const MatrixXd& change : changes) {
        list.push_back(beyond(nuisance, change));
    }
    return list;
}

} // namespace

std::vector<ChannelTest> test_channels(const VectorXd& residuals, const std::vector<MatrixXd>& changes,
                                       const std::vector<Accepted>& accepted, const inference::Nuisance& nuisance,
                                       bool estimated, std::uint64_t seed) {
    const Index rows = residuals.size();
    const int free = static_cast<int>(rows) - nuisance.rank();
    std::vector<ChannelTest> tests(changes.size());
    if (free < 1) {
        return tests;
    }
    const std::vector<MatrixXd> seen = beyond(nuisance, changes);
    const MatrixXd whiten = whitening(seen, accepted, rows);
    std::vector<std::size_t> open;
    std::vector<ChannelEvidence> evidence;
    for (std::size_t c = 0; c < changes.size(); ++c) {
        if (std::none_of(accepted.begin(), accepted.end(), [&](const Accepted& a) { return a.channel == c; })) {
            open.push_back(c);
            evidence.emplace_back(whiten * seen[c]);
        }
    }
    const VectorXd z = whiten * nuisance.beyond(residuals);
    for (std::size_t i = 0; i < open.size(); ++i) {
        const auto estimate = evidence[i].estimate(z, estimated, free);
        tests[open[i]].strength = estimate.strength;
        tests[open[i]].log_ratio = estimate.log_ratio;
    }
    constexpr int draws = 9999;
    std::vector<int> above(open.size(), 0);
    const pave::RandomStream random(seed, 7);
    VectorXd noise(rows);
    for (int draw = 0; draw < draws; ++draw) {
        for (Index i = 0; i < rows; ++i) {
            noise[i] = random.normal(static_cast<std::uint64_t>(draw) * static_cast<std::uint64_t>(rows) +
                                     static_cast<std::uint64_t>(i));
        }
        const VectorXd drawn = nuisance.beyond(noise); // whitened already: what is accepted is part of the noise
        double largest = 0.0;
        for (const ChannelEvidence& own : evidence) {
            largest = std::max(largest, own.estimate(drawn, estimated, free).log_ratio);
        }
        for (std::size_t i = 0; i < open.size(); ++i) {
            above[i] += largest >= tests[open[i]].log_ratio ? 1 : 0;
        }
    }
    for (std::size_t i = 0; i < open.size(); ++i) {
        tests[open[i]].p_familywise = (above[i] + 1.0) / (draws + 1.0);
    }
    return tests;
}

void estimate_strengths(const VectorXd& residuals, const std::vector<MatrixXd>& changes,
                        std::vector<Accepted>& accepted, const inference::Nuisance& nuisance, bool estimated) {
    const Index rows = residuals.size();
    const std::vector<MatrixXd> seen = beyond(nuisance, changes);
    const VectorXd z = nuisance.beyond(residuals);
    const int sweeps = accepted.size() > 1 ? 5 : 1;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        for (std::size_t a = 0; a < accepted.size(); ++a) {
            std::vector<Accepted> others = accepted;
            others.erase(others.begin() + static_cast<std::ptrdiff_t>(a));
            const MatrixXd whiten = whitening(seen, others, rows);
            const ChannelEvidence own(whiten * seen[accepted[a].channel]);
            const auto estimate = own.estimate(whiten * z, estimated, static_cast<int>(rows) - nuisance.rank());
            if (estimate.strength > 0.0) {
                accepted[a].strength = estimate.strength;
            }
        }
    }
}

} // namespace explore::diagnose

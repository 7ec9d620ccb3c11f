// The distance between responses and measurements: residuals whose root of the sum of squares is the misfit f.
#pragma once

#include "data/noise.h"

#include <Eigen/Dense>
#include <span>
#include <string_view>
#include <vector>

namespace explore::problem {

enum class MisfitKind {
    log,      // g(model) - g(measured), g(v) = asinh(v / (2 s)): the logarithm where |v| >> s, odd and monotone
    relative, // (model - measured) / |measured|
    weighted, // (model - measured) / scale
    noise     // in standard deviations of the stated noise (data/noise.h)
};
// Misfits that a study may choose.
inline constexpr std::string_view misfit_names[] = {"log", "relative", "weighted"};
constexpr std::string_view to_string(MisfitKind kind) {
    return kind == MisfitKind::noise ? "noise" : misfit_names[static_cast<int>(kind)];
}

// Of kind `noise` residuals are independent whatever the stated correlation: with r in units of the standard deviations
// and R = L L' their correlation matrix, the residuals are L^-1 r (generalised least squares, Aitken 1935, Proceedings
// of the Royal Society of Edinburgh 55), times the factors. R is that at the measured values:
//     R_ij = (s_i s_j rho_ij + c_i c_j v_i v_j + w_i w_j) / (d_i d_j),   d_i^2 = s_i^2 + (c_i v_i)^2 + w_i^2,
// i and j of one load, s own_deviation, rho own_correlation, c common_relative, v the measured value, w the drift, of
// one sensor. Each L^-1 r belongs to its reading as
// what the readings before it do not tell of it. Other kinds compare every reading by itself.
//
// Noise of Student's t distribution (data::Noise::degrees): these independent residuals z, in units of the noise, are t
// distributed, and a row is student_row(z) (problem/student.h), whose square is -2 ln of their density but for a
// constant. With a correlation that is L times independent t errors, not a multivariate t distribution: each reading
// may be wrong alone.
//
// Readings of which a limit is known, of kind `noise` with independent normal errors alone: a row is
// censored_row(z) (problem/censored.h).
class Misfit {
public:
    // One residual: which response it compares with what.
    struct Term {
        std::size_t response = 0; // index of the response
        double measured = 0.0;    // SI
        double scale = 1.0;       // s for log, |measured| for relative, sigma for weighted
        double factor = 1.0; // of the residual: the square root of its weight; shapes the fit, says nothing of noise
        data::Noise noise{};
        data::NoisePlace place{};
        data::Censored censored = data::Censored::no;
    };
    // Throws std::invalid_argument for kind `noise` with a correlation matrix that is not positive definite.
    Misfit(MisfitKind kind, std::vector<Term> terms);

    std::size_t size() const { return terms_.size(); }
    MisfitKind kind() const { return kind_; }
    std::span<const Term> terms() const { return terms_; }

    Eigen::VectorXd residuals(std::span<const double> responses) const;
    // One by one, before L^-1: of each reading alone, for who looks at readings and not at sums of squares.
    Eigen::VectorXd single_residuals(std::span<const double> responses) const;
    // d(single residual i)/d(its response).
    Eigen::VectorXd slopes(std::span<const double> responses) const;

    bool is_student() const { return kind_ == MisfitKind::noise && !terms_.empty() && terms_[0].noise.degrees > 0.0; }
    // How many readings are limits.
    std::size_t censored() const;
    // One each row: residuals() before student_row or censored_row, in units of the noise.
    Eigen::VectorXd standard_residuals(std::span<const double> responses) const;
    // d(residuals() i)/d(whitened single residual i): 1 of normal noise.
    Eigen::VectorXd loss_slopes(std::span<const double> responses) const;
    // Its substitute where a reading's mean information counts: the root of student_information or of
    // censored_information; 1 of normal noise.
    Eigen::VectorXd loss_information(std::span<const double> responses) const;

    // Of kind `noise` with factors of 1: the logarithm of the density of the measured values [SI] is this less half the
    // sum of the squares of residuals(). On the scale of data::Noise the density is that of the standard normal, so its
    // slope at the measured values, the inverse of their standard deviations, is all that is left; no response is in
    // it.
    double log_normaliser() const;

    // The readings' estimate of the standard normal number by which the drift of each sensor is multiplied, where a
    // model has these responses: the mean and the standard deviation given them (Robinson 1991, Statistical Science 6,
    // 15), in the order of the sensors' first readings.
    struct Drift {
        std::size_t term = 0; // the first of the sensor
        double mean = 0.0;
        double deviation = 1.0;
    };
    std::vector<Drift> drifts(std::span<const double> responses) const;

    bool is_correlated() const { return !blocks_.empty(); }
    // rows: one each reading, of single residuals or what changes with them; to those of residuals().
    Eigen::MatrixXd whitened(Eigen::MatrixXd rows) const;

private:
    // Readings whose noise is correlated.
    struct Block {
        std::vector<Eigen::Index> rows;
        Eigen::MatrixXd factor; // L
    };

    MisfitKind kind_;
    std::vector<Term> terms_;
    std::vector<Block> blocks_;
};

} // namespace explore::problem

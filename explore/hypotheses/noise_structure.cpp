#include "hypotheses/noise_structure.h"

#include "inference/quantiles.h"
#include "problem/student.h"

#include <algorithm>
#include <cmath>

namespace explore::hypotheses {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// Of coordinates that are held a little by their ranges, as of every interval.
MatrixXd information_by(const MatrixXd& jacobian) {
    constexpr double weak = 0.01;
    MatrixXd information = jacobian.transpose() * jacobian;
    information.diagonal().array() += weak / inference::box_variance;
    return information;
}

MatrixXd covariance_by(const MatrixXd& jacobian) {
    return information_by(jacobian).llt().solve(MatrixXd::Identity(jacobian.cols(), jacobian.cols()));
}

// The residuals where the coordinates make the best of whitened ones.
VectorXd best_residuals(const VectorXd& residuals, const MatrixXd& jacobian) {
    return residuals - jacobian * information_by(jacobian).llt().solve(jacobian.transpose() * residuals);
}

struct Whitened {
    double chi2 = INFINITY;
    Evidence evidence;
    MatrixXd jacobian{};
};

// Of noise with this covariance, in units of what is stated.
Whitened judge(const LinearFit& fit, const MatrixXd& covariance, const NoisePrior& noise) {
    const Eigen::LLT<MatrixXd> root(covariance);
    if (root.info() != Eigen::Success) {
        Whitened none;
        none.evidence.as_stated = none.evidence.any_size = none.evidence.log = -INFINITY;
        return none;
    }
    const VectorXd residuals = root.matrixL().solve(fit.residuals);
    const MatrixXd jacobian = root.matrixL().solve(fit.jacobian);
    const double log_determinant = 2.0 * MatrixXd(root.matrixL()).diagonal().array().log().sum();
    const double sum = best_residuals(residuals, jacobian).squaredNorm();
    return {sum,
            evidence(sum, residuals.size(), jacobian, Prior::of_parameters(jacobian.cols()), noise, log_determinant),
            jacobian};
}

// Of the sizes, each with its ln of evidence: the ends between which 95 % of the probability lie.
void set_range(NoiseStructure& structure, std::vector<std::pair<double, double>> sizes) {
    std::sort(sizes.begin(), sizes.end());
    std::vector<double> logarithms;
    for (const auto& [size, logarithm] : sizes) {
        logarithms.push_back(logarithm);
    }
    const double all = log_sum(logarithms);
    constexpr double tail = 0.025;
    double gone = 0.0;
    structure.low = structure.high = sizes.back().first;
    for (const auto& [size, logarithm] : sizes) {
        const double before = gone;
        gone += std::exp(logarithm - all);
        structure.low = before < tail && gone >= tail ? size : structure.low;
        if (before < 1.0 - tail && gone >= 1.0 - tail) {
            structure.high = size;
        }
    }
    structure.ends = structure.high == sizes.back().first;
}

// Over sizes with their weights beforehand.
struct Sized {
    double size = 0.0, weight = 1.0;
};
template <class Covariance>
NoiseStructure average(std::string key, const LinearFit& fit, const std::vector<Sized>& sizes, const NoisePrior& noise,
                       const Covariance& covariance) {
    NoiseStructure structure{.key = std::move(key), .size = 0.0, .chi2 = 0.0, .evidence = {}};
    std::vector<double> as_stated;
    std::vector<double> any_size;
    std::vector<double> all;
    std::vector<std::pair<double, double>> of_size;
    double most = -INFINITY;
    double weights = 0.0;
    for (const auto& [size, weight] : sizes) {
        const Whitened own = judge(fit, covariance(size), noise);
        const double log_weight = std::log(weight);
        weights += weight;
        as_stated.push_back(own.evidence.as_stated + log_weight);
        any_size.push_back(own.evidence.any_size + log_weight);
        all.push_back(own.evidence.log + log_weight);
        of_size.emplace_back(size, own.evidence.log);
        if (own.evidence.log > most) { // the size is what the data say of it
            most = own.evidence.log;
            structure.size = size;
            structure.chi2 = own.chi2;
            structure.evidence = own.evidence;
            structure.covariance = covariance_by(own.jacobian);
        }
    }
    set_range(structure, std::move(of_size));
    structure.evidence.as_stated = log_sum(as_stated) - std::log(weights);
    structure.evidence.any_size = log_sum(any_size) - std::log(weights);
    structure.evidence.log = log_sum(all) - std::log(weights);
    return structure;
}

} // namespace

// Beside the stated errors, or a part of them: then the rest is smaller by as much.
NoiseStructure common_errors(const LinearFit& fit, const MatrixXd& common, const NoisePrior& noise) {
    const Index n = fit.residuals.size();
    const MatrixXd signs = common.unaryExpr([](double v) { return v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0; });
    // A load cell, a plate's seat or a wheel's line err by 1 or 2 %, one in a hundred by 5 %: lognormal about 1.5 %,
    // at steps of the logarithm.
    constexpr double usual = 0.015;
    constexpr double spread = 0.5; // of the logarithm
    std::vector<Sized> sizes;
    for (const double size : {0.005, 0.0075, 0.011, 0.016, 0.024, 0.036, 0.054, 0.08, 0.12}) {
        sizes.push_back({size, std::exp(-0.5 * std::pow(std::log(size / usual) / spread, 2))});
    }
    const NoiseStructure more = average("common", fit, sizes, noise, [&](double share) -> MatrixXd {
        return MatrixXd::Identity(n, n) + share * share * common * common.transpose();
    });
    NoiseStructure within = average("common", fit, {{0.25}, {0.5}, {0.75}, {0.9}}, noise, [&](double part) -> MatrixXd {
        return (1.0 - part) * MatrixXd::Identity(n, n) + part * signs * signs.transpose();
    });
    // The part as a share of the values: of the median reading.
    VectorXd lengths = common.rowwise().norm();
    std::sort(lengths.begin(), lengths.end());
    const double median = n > 0 ? lengths[n / 2] : 0.0;
    for (double* part : {&within.size, &within.low, &within.high}) { // in all as large as the noise is found
        *part = median > 0.0 ? within.evidence.noise * std::sqrt(*part) / median : 0.0;
    }
    within.ends = false; // a part of what is stated is no more than that
    NoiseStructure both = within.evidence.log > more.evidence.log ? within : more;
    const auto half = [](double first, double second) { return log_sum({first, second}) - std::log(2.0); };
    both.evidence.as_stated = half(more.evidence.as_stated, within.evidence.as_stated);
    both.evidence.any_size = half(more.evidence.any_size, within.evidence.any_size);
    both.evidence.log = half(more.evidence.log, within.evidence.log);
    return both;
}

NoiseStructure correlated_errors(const LinearFit& fit, const std::vector<data::NoisePlace>& places,
                                 const NoisePrior& noise) {
    return average("correlated", fit, {{0.1}, {0.2}, {0.4}, {0.8}}, noise, [&](double length) {
        const Index n = fit.residuals.size();
        MatrixXd covariance = MatrixXd::Identity(n, n);
        for (std::size_t i = 0; i < places.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                const double tied = data::own_correlation(places[i], places[j], length);
                covariance(static_cast<Index>(i), static_cast<Index>(j)) = tied;
                covariance(static_cast<Index>(j), static_cast<Index>(i)) = tied;
            }
        }
        return covariance;
    });
}

// The likelihood is that of t where the coordinates are most likely; the volume around it that of normal noise whose
// variance carries as much information (Lange, Little and Taylor 1989).
NoiseStructure heavy_tails(const LinearFit& fit, const NoisePrior& noise) {
    constexpr double degrees = 4.0;
    const Index n = fit.residuals.size();
    const double normal_peak = -0.5 * std::log(2.0 * M_PI);
    const double gained = static_cast<double>(n) * (problem::student_log_peak(degrees) - normal_peak);
    NoiseStructure structure{
        .key = "heavy-tailed", .size = degrees, .low = degrees, .high = degrees, .chi2 = 0.0, .evidence = {}};
    const auto log_at = [&](double k) {
        VectorXd residuals = fit.residuals;
        VectorXd weights(n);
        const auto weigh = [&] {
            for (Index i = 0; i < n; ++i) {
                weights[i] = problem::student_weight(residuals[i] / k, degrees);
            }
        };
        constexpr int sweeps = 20;
        for (int sweep = 0; sweep < sweeps; ++sweep) {
            weigh();
            const VectorXd roots = weights.cwiseSqrt();
            const VectorXd before = roots.cwiseProduct(fit.residuals);
            const MatrixXd jacobian = roots.asDiagonal() * fit.jacobian;
            residuals = best_residuals(before, jacobian).cwiseQuotient(roots);
        }
        weigh();
        double sum = 0.0;
        for (Index i = 0; i < n; ++i) {
            sum += std::pow(problem::student_row(residuals[i] / k, degrees), 2);
        }
        const MatrixXd informed = std::sqrt(problem::student_information(degrees)) / k * fit.jacobian;
        const Evidence volume = evidence(0.0, 0, informed, Prior::of_parameters(informed.cols()), noise);
        structure.chi2 = k == 1.0 ? weights.dot(residuals.cwiseAbs2()) : structure.chi2;
        return gained - static_cast<double>(n) * std::log(k) - 0.5 * sum + volume.as_stated;
    };
    structure.evidence.as_stated = log_at(1.0);
    constexpr double step = 0.1;
    constexpr double reach = 3.0;
    const int steps = static_cast<int>(reach * noise.log_deviation / step);
    std::vector<double> logarithms;
    double most = -INFINITY;
    for (int i = -steps; i <= steps; ++i) {
        const double z = i * step / noise.log_deviation;
        const double k = std::exp(i * step);
        logarithms.push_back(log_at(k) - 0.5 * z * z);
        if (logarithms.back() > most) {
            most = logarithms.back();
            structure.evidence.noise = k;
        }
    }
    structure.evidence.any_size = log_sum(logarithms) + std::log(step / (noise.log_deviation * std::sqrt(2.0 * M_PI)));
    structure.evidence.log = noise.as_stated > 0.0
                                 ? log_sum({std::log(noise.as_stated) + structure.evidence.as_stated,
                                            std::log(1.0 - noise.as_stated) + structure.evidence.any_size})
                                 : structure.evidence.any_size;
    return structure;
}

} // namespace explore::hypotheses

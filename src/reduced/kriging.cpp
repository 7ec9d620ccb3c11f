#include "reduced/kriging.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pave::reduced {
namespace {

// The kernel at a distance of r lengths, and its derivative by r divided by r.
struct Kernel {
    double value, slope;
};
Kernel kernel(double squared) {
    const double r = std::sqrt(5.0 * squared);
    const double decay = std::exp(-r);
    return {(1.0 + r + r * r / 3.0) * decay, -5.0 / 3.0 * (1.0 + r) * decay};
}

Eigen::MatrixXd kernels(const Eigen::MatrixXd& scaled) {
    const Eigen::Index n = scaled.cols();
    Eigen::MatrixXd k(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
        for (Eigen::Index i = 0; i < n; ++i) {
            k(i, j) = kernel((scaled.col(i) - scaled.col(j)).squaredNorm()).value;
        }
    }
    return k;
}

// Of nine samples of ten the distance to the nearest other one is at most this.
double spacing_of(const Eigen::MatrixXd& scaled) {
    std::vector<double> nearest;
    for (Eigen::Index i = 0; i < scaled.cols(); ++i) {
        double least = std::numeric_limits<double>::infinity();
        for (Eigen::Index j = 0; j < scaled.cols(); ++j) {
            least = i == j ? least : std::min(least, (scaled.col(i) - scaled.col(j)).squaredNorm());
        }
        nearest.push_back(std::sqrt(least));
    }
    const auto at = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() * 9 / 10);
    std::nth_element(nearest.begin(), at, nearest.end());
    return *at;
}

} // namespace

double Kriging::at(const Eigen::VectorXd& x, Eigen::VectorXd* gradient) const {
    const Eigen::VectorXd here = x.cwiseQuotient(lengths);
    if (gradient != nullptr) {
        gradient->setZero(x.size());
    }
    double value = mean;
    for (Eigen::Index i = 0; i < places.cols(); ++i) {
        const Kernel own = kernel((here - places.col(i)).squaredNorm());
        value += own.value * factors[i];
        if (gradient != nullptr) {
            *gradient += own.slope * factors[i] * (here - places.col(i)).cwiseQuotient(lengths);
        }
    }
    return value;
}

double Kriging::reach(const Eigen::VectorXd& x) const {
    const double nearest = std::sqrt((places.colwise() - x.cwiseQuotient(lengths)).colwise().squaredNorm().minCoeff());
    return spacing > 0.0 && std::isfinite(spacing) ? std::max(1.0, nearest / spacing) : 1.0;
}

Kriging krige(const Eigen::MatrixXd& places, const Eigen::VectorXd& values) {
    Kriging best;
    best.mean = values.mean();
    const Eigen::VectorXd centred = values.array() - best.mean;
    double least = std::numeric_limits<double>::infinity();
    const auto attempt = [&](const Eigen::VectorXd& lengths, double noise) {
        const Eigen::MatrixXd scaled = lengths.cwiseInverse().asDiagonal() * places;
        Eigen::MatrixXd k = kernels(scaled);
        k.diagonal().array() += noise;
        const Eigen::LLT<Eigen::MatrixXd> factor(k);
        if (factor.info() != Eigen::Success) {
            return false;
        }
        const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(k.rows(), k.cols()));
        const Eigen::VectorXd factors = inverse * centred;
        const double missed = factors.cwiseQuotient(inverse.diagonal()).squaredNorm();
        if (!(missed < least)) {
            return false;
        }
        least = missed;
        best.lengths = lengths;
        best.places = scaled;
        best.factors = factors;
        return true;
    };
    Eigen::VectorXd lengths = Eigen::VectorXd::Constant(places.rows(), 2.0);
    double noise = 1e-2;
    attempt(lengths, noise);
    // One at a time, a step up or down, until none helps.
    constexpr double length_step = 1.6, noise_step = 4.0;
    constexpr double least_noise = 1e-8, most_length = 50.0;
    for (bool better = true; better;) {
        better = false;
        for (const double sign : {-1.0, 1.0}) {
            for (Eigen::Index i = 0; i < lengths.size(); ++i) {
                Eigen::VectorXd other = lengths;
                other[i] *= std::pow(length_step, sign);
                if (other[i] < most_length && attempt(other, noise)) {
                    lengths = other;
                    better = true;
                }
            }
            const double other = noise * std::pow(noise_step, sign);
            if (other > least_noise && attempt(lengths, other)) {
                noise = other;
                better = true;
            }
        }
    }
    best.spacing = spacing_of(best.places);
    return best;
}

} // namespace pave::reduced

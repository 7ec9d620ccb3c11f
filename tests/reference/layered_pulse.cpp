#include "reference/layered_pulse.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace pave::reference {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

// Young's modulus at a frequency.
Complex modulus_of(const MovingLayer& layer, Complex w) {
    const Complex iw = Complex(0.0, 1.0) * w;
    const Complex slow = iw * layer.fading_time;
    return layer.modulus * (1.0 - layer.fading_share / (1.0 + slow) + iw * layer.damping_time);
}

// u_r, u_z, sigma_zz, sigma_rz of the four waves of a layer at a depth below its top: downward P and SV, upward P and
// SV, each 1 where it enters the layer.
struct Waves {
    Complex alpha, beta, mu, w2_rho, w2_cs2;
    double k, thickness;

    Waves(const MovingLayer& layer, Complex w, double wavenumber) : k(wavenumber), thickness(layer.thickness) {
        const Complex e = modulus_of(layer, w);
        const double nu = layer.poisson;
        mu = e / (2.0 * (1.0 + nu));
        const Complex lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
        w2_rho = w * w * layer.density;
        w2_cs2 = w2_rho / mu;
        alpha = std::sqrt(k * k - w2_rho / (lambda + 2.0 * mu)); // the root with a positive real part
        beta = std::sqrt(k * k - w2_cs2);
    }
    Eigen::Matrix4cd at(double z) const {
        Eigen::Matrix4cd f;
        for (int up = 0; up < 2; ++up) {
            const double sign = up == 0 ? -1.0 : 1.0;
            const double far = up == 0 ? z : thickness - z;
            const Complex p = std::exp(-alpha * far);
            const Complex s = std::exp(-beta * far);
            f.col(2 * up) << -k * p, sign * alpha * p, (2.0 * mu * k * k - w2_rho) * p,
                -mu * k * 2.0 * sign * alpha * p;
            f.col(2 * up + 1) << -k * sign * beta * s, k * k * s, 2.0 * mu * k * k * sign * beta * s,
                -mu * k * (2.0 * k * k - w2_cs2) * s;
        }
        return f;
    }
};

// u_z of the surface for sigma_zz = -1 there.
Complex compliance(std::span<const MovingLayer> layers, bool half_space, Complex w, double k) {
    const auto n = static_cast<Eigen::Index>(layers.size());
    const Eigen::Index unknowns = 4 * n - (half_space ? 2 : 0);
    Eigen::MatrixXcd a = Eigen::MatrixXcd::Zero(unknowns, unknowns);
    Eigen::VectorXcd b = Eigen::VectorXcd::Zero(unknowns);
    std::vector<Waves> waves;
    for (const MovingLayer& layer : layers) {
        waves.emplace_back(layer, w, k);
    }
    const auto width = [&](Eigen::Index layer) { return half_space && layer == n - 1 ? 2 : 4; };
    a.block(0, 0, 2, width(0)) = waves[0].at(0.0).bottomRows(2).leftCols(width(0));
    b[0] = -1.0;
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
        a.block(2 + 4 * i, 4 * i, 4, 4) =
            waves[static_cast<std::size_t>(i)].at(waves[static_cast<std::size_t>(i)].thickness);
        a.block(2 + 4 * i, 4 * i + 4, 4, width(i + 1)) =
            -waves[static_cast<std::size_t>(i + 1)].at(0.0).leftCols(width(i + 1));
    }
    if (!half_space) {
        a.block(unknowns - 2, unknowns - 4, 2, 4) = waves.back().at(waves.back().thickness).topRows(2);
    }
    for (Eigen::Index row = 0; row < unknowns; ++row) { // displacements and stresses to one size
        const double scale = a.row(row).cwiseAbs().maxCoeff();
        a.row(row) /= scale;
        b[row] /= scale;
    }
    const Eigen::VectorXcd amplitude = a.partialPivLu().solve(b);
    return (waves[0].at(0.0).row(1).leftCols(width(0)) * amplitude.head(width(0)))(0);
}

// The integral of J1(k a) J0(k r) / k over all k.
double under_circle(double a, double r) {
    const double x = r < a ? r * r / (a * a) : a * a / (r * r);
    const double second = r < a ? -0.5 : 0.5;
    const double third = r < a ? 1.0 : 2.0;
    double term = 1.0;
    double sum = 1.0;
    for (int i = 0; i < 4000; ++i) { // Gauss's series of F(1/2, second; third; x)
        term *= (0.5 + i) * (second + i) / ((third + i) * (1.0 + i)) * x;
        sum += term;
    }
    return r < a ? sum : a / (2.0 * r) * sum;
}

} // namespace

std::vector<std::vector<double>> layered_pulse(std::span<const MovingLayer> layers, bool half_space, double radius,
                                               double pressure, double duration, std::span<const double> radii,
                                               std::span<const double> times) {
    const double period = 2.0 * *std::max_element(times.begin(), times.end());
    const double fading = 7.0 / period;
    const int frequencies = static_cast<int>(12.0 * period / duration);
    constexpr double step = 0.08;
    constexpr double most = 90.0;
    std::vector<std::vector<double>> u(radii.size(), std::vector<double>(times.size(), 0.0));
    std::vector<double> at_infinity;
    for (const double r : radii) {
        at_infinity.push_back(under_circle(radius, r));
    }
    for (int f = 0; f < frequencies; ++f) {
        const Complex w(2.0 * pi * f / period, -fading);
        Complex pulse = 0.0;
        constexpr int parts = 4000;
        for (int i = 1; i < parts; ++i) {
            const double t = duration * i / parts;
            const double s = std::sin(pi * t / duration);
            pulse += s * s * std::exp(Complex(0.0, -1.0) * w * t) * (duration / parts);
        }
        // For large k the layer on top, at rest.
        const double nu = layers[0].poisson;
        const Complex limit = 2.0 * (1.0 - nu * nu) / modulus_of(layers[0], w);
        std::vector<Complex> sum(radii.size());
        for (std::size_t i = 0; i < radii.size(); ++i) {
            sum[i] = limit * at_infinity[i];
        }
        for (double k = step / 2.0; k < most; k += step) {
            const Complex beyond = compliance(layers, half_space, w, k) - limit / k;
            for (std::size_t i = 0; i < radii.size(); ++i) {
                sum[i] += beyond * std::cyl_bessel_j(1.0, k * radius) * std::cyl_bessel_j(0.0, k * radii[i]) * step;
            }
        }
        for (std::size_t i = 0; i < radii.size(); ++i) {
            const Complex transform = pressure * radius * pulse * sum[i];
            for (std::size_t t = 0; t < times.size(); ++t) {
                const double share = f == 0 ? 1.0 : 2.0;
                u[i][t] += share * (transform * std::exp(Complex(0.0, 1.0) * w * times[t])).real() / period;
            }
        }
    }
    return u;
}

} // namespace pave::reference

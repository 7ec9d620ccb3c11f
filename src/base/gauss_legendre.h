// Gauss-Legendre quadrature.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace pave {

// Nodes and weights on [-1, 1] that integrate polynomials up to degree 2 n - 1, in decreasing order of the nodes; by
// Newton's method on the Legendre polynomial.
inline std::vector<std::pair<double, double>> gauss_legendre(int n) {
    std::vector<std::pair<double, double>> rule;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
        double slope = 1.0;
        for (int iteration = 0; iteration < 8; ++iteration) {
            double p = 1.0;
            double before = 0.0;
            for (int k = 1; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
                before = p;
                p = next;
            }
            slope = n * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        rule.emplace_back(x, 2.0 / ((1.0 - x * x) * slope * slope));
    }
    return rule;
}

} // namespace pave

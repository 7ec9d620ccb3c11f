#include "fe/axisymmetric_q8.h"

#include <numbers>

namespace pave::fe {

Eigen::Matrix<double, 8, 1> AxisymmetricQ8::shape(const Position& at) {
    const double xi = at[0];
    const double eta = at[1];
    Eigen::Matrix<double, 8, 1> n;
    for (int i = 0; i < 4; ++i) {
        const auto [cx, cy] = local[i];
        n[i] = (1 + cx * xi) * (1 + cy * eta) * (cx * xi + cy * eta - 1) / 4;
    }
    n[4] = (1 - xi * xi) * (1 - eta) / 2;
    n[5] = (1 + xi) * (1 - eta * eta) / 2;
    n[6] = (1 - xi * xi) * (1 + eta) / 2;
    n[7] = (1 - xi) * (1 - eta * eta) / 2;
    return n;
}

Eigen::Matrix<double, 2, 8> AxisymmetricQ8::shape_gradient(const Position& at) {
    const double xi = at[0];
    const double eta = at[1];
    Eigen::Matrix<double, 2, 8> g;
    for (int i = 0; i < 4; ++i) {
        const auto [cx, cy] = local[i];
        g(0, i) = cx * (1 + cy * eta) * (2 * cx * xi + cy * eta) / 4;
        g(1, i) = cy * (1 + cx * xi) * (cx * xi + 2 * cy * eta) / 4;
    }
    g.col(4) << -xi * (1 - eta), -(1 - xi * xi) / 2;
    g.col(5) << (1 - eta * eta) / 2, -(1 + xi) * eta;
    g.col(6) << -xi * (1 + eta), (1 - xi * xi) / 2;
    g.col(7) << -(1 - eta * eta) / 2, -(1 - xi) * eta;
    return g;
}

std::array<AxisymmetricQ8::Position, AxisymmetricQ8::gauss> AxisymmetricQ8::gauss_positions() {
    constexpr double g = std::numbers::inv_sqrt3;
    return {Position{-g, -g}, {g, -g}, {g, g}, {-g, g}};
}

AxisymmetricQ8::Point AxisymmetricQ8::point(const Coordinates& x, const Position& position) {
    const auto n = shape(position);
    const auto g = shape_gradient(position);
    const Eigen::Matrix2d jacobian = g * x.transpose(); // rows: derivative by xi, by eta
    const double r = x.row(0).dot(n);
    Point p;
    p.weight = jacobian.determinant() * 2.0 * std::numbers::pi * r;
    p.rows.topRows<2>() = jacobian.inverse() * g;
    p.rows.row(2) = n.transpose() / r;
    return p;
}

double AxisymmetricQ8::depth(const Coordinates& x, const Position& position) {
    return x.row(1).dot(shape(position));
}

} // namespace pave::fe

// The eight-node axisymmetric quadrilateral with 2 x 2 Gauss points.
#pragma once

#include "mechanics/voigt.h"

#include <array>

namespace pave::fe {

// Unknowns of a node: u_r, u_z (z down). Voigt components: rr, tt, zz, rz.
struct AxisymmetricQ8 {
    static constexpr int dim = 2;
    static constexpr int nodes = 8;
    static constexpr int dofs = dim * nodes;
    static constexpr int gauss = 4;
    static constexpr int voigt = 4;
    // Which displacement is downwards.
    static constexpr int down = 1;

    using Coordinates = Eigen::Matrix<double, 2, 8>; // rows r, z
    using Position = Eigen::Vector2d;                // (xi, eta) in [-1, 1]^2
    using Vector = Eigen::Matrix<double, dofs, 1>;   // r and z of node 0, of node 1, ...
    using Stress = mechanics::Voigt<voigt>;
    using Operator = Eigen::Matrix<double, voigt, dofs>;

    static constexpr int local[nodes][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}};

    static Eigen::Matrix<double, 8, 1> shape(const Position& at);
    // Rows: d/dxi, d/deta.
    static Eigen::Matrix<double, 2, 8> shape_gradient(const Position& at);

    // A Gauss point: its weight (volume per radian times 2 pi) and the rows dN/dr, dN/dz, N/r.
    struct Point {
        double weight = 0.0;
        Eigen::Matrix<double, 3, 8> rows;
    };

    static std::array<Position, gauss> gauss_positions();
    static Point point(const Coordinates& x, const Position& position);

    // Position of every Gauss point's depth, from the coordinates.
    static double depth(const Coordinates& x, const Position& position);

    static Stress strain(const Point& p, const Vector& u) {
        const auto ur = Eigen::Map<const Eigen::Matrix<double, 8, 1>, 0, Eigen::InnerStride<2>>(u.data());
        const auto uz = Eigen::Map<const Eigen::Matrix<double, 8, 1>, 0, Eigen::InnerStride<2>>(u.data() + 1);
        const Eigen::Vector3d a = p.rows * ur;
        return {a[0], a[2], p.rows.row(1).dot(uz), a[1] + p.rows.row(0).dot(uz)};
    }

    static Operator strain_operator(const Point& p) {
        Operator b = Operator::Zero();
        for (int i = 0; i < nodes; ++i) {
            b(0, 2 * i) = p.rows(0, i);
            b(1, 2 * i) = p.rows(2, i);
            b(2, 2 * i + 1) = p.rows(1, i);
            b(3, 2 * i) = p.rows(1, i);
            b(3, 2 * i + 1) = p.rows(0, i);
        }
        return b;
    }

    // force += scale * B^T stress
    static void add_force(const Point& p, const Stress& stress, double scale, Vector& force) {
        const Stress s = scale * stress;
        for (int i = 0; i < nodes; ++i) {
            force[2 * i] += p.rows(0, i) * s[0] + p.rows(2, i) * s[1] + p.rows(1, i) * s[3];
            force[2 * i + 1] += p.rows(1, i) * s[2] + p.rows(0, i) * s[3];
        }
    }
};

} // namespace pave::fe

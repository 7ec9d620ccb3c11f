// The twenty-node hexahedron (serendipity) with 2 x 2 x 2 Gauss points.
#pragma once

#include "mechanics/voigt.h"

#include <array>

namespace pave::fe {

// Unknowns of a node: u_x, u_y, u_z (z down). Voigt components: xx, yy, zz, xz, yz, xy.
// Local nodes: 0..3 the corners of the upper face (zeta = -1) around it, 4..7 those below them, 8..11 the middles of
// the upper edges 0-1, 1-2, 2-3, 3-0, 12..15 of the lower ones, 16..19 of the vertical ones.
struct Hex20 {
    static constexpr int dim = 3;
    static constexpr int nodes = 20;
    static constexpr int dofs = dim * nodes;
    static constexpr int gauss = 8;
    static constexpr int voigt = 6;
    // Which displacement is downwards.
    static constexpr int down = 2;

    using Coordinates = Eigen::Matrix<double, 3, nodes>;
    using Position = Eigen::Vector3d;              // (xi, eta, zeta) in [-1, 1]^3
    using Vector = Eigen::Matrix<double, dofs, 1>; // x, y, z of node 0, of node 1, ...
    using Stress = mechanics::Voigt<voigt>;
    using Operator = Eigen::Matrix<double, voigt, dofs>;

    static constexpr int local[nodes][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                            {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, -1, -1}, {1, 0, -1},
                                            {0, 1, -1},   {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},   {0, 1, 1},
                                            {-1, 0, 1},   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0},   {-1, 1, 0}};

    static Eigen::Matrix<double, nodes, 1> shape(const Position& at);
    // Rows: d/dxi, d/deta, d/dzeta.
    static Eigen::Matrix<double, dim, nodes> shape_gradient(const Position& at);

    // A Gauss point: its weight (volume) and the rows dN/dx, dN/dy, dN/dz.
    struct Point {
        double weight = 0.0;
        Eigen::Matrix<double, dim, nodes> rows;
    };

    // Point number 4 i + 2 j + k lies at the i-th position in xi, the j-th in eta, the k-th in zeta.
    static std::array<Position, gauss> gauss_positions();
    static Point point(const Coordinates& x, const Position& position);

    static double depth(const Coordinates& x, const Position& position);

    static Stress strain(const Point& p, const Vector& u);

    static Operator strain_operator(const Point& p) {
        Operator b = Operator::Zero();
        for (int i = 0; i < nodes; ++i) {
            const double x = p.rows(0, i);
            const double y = p.rows(1, i);
            const double z = p.rows(2, i);
            b(0, 3 * i) = b(3, 3 * i + 2) = b(5, 3 * i + 1) = x;
            b(1, 3 * i + 1) = b(4, 3 * i + 2) = b(5, 3 * i) = y;
            b(2, 3 * i + 2) = b(3, 3 * i) = b(4, 3 * i + 1) = z;
        }
        return b;
    }

    // force += scale * B^T stress
    static void add_force(const Point& p, const Stress& stress, double scale, Vector& force);
};

} // namespace pave::fe

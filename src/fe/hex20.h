// The twenty-node hexahedron (serendipity) with 2 x 2 x 2 Gauss points.
#pragma once

#include "mechanics/voigt.h"

#include <array>
#include <numbers>

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

    static Eigen::Matrix<double, nodes, 1> shape(const Position& at) {
        Eigen::Matrix<double, nodes, 1> n;
        for (int i = 0; i < nodes; ++i) {
            double product = 1.0;
            double sum = -2.0;
            for (int d = 0; d < dim; ++d) {
                product *= local[i][d] == 0 ? 1.0 - at[d] * at[d] : 1.0 + local[i][d] * at[d];
                sum += local[i][d] * at[d];
            }
            n[i] = i < 8 ? product * sum / 8.0 : product / 4.0;
        }
        return n;
    }

    // Rows: d/dxi, d/deta, d/dzeta.
    static Eigen::Matrix<double, dim, nodes> shape_gradient(const Position& at) {
        Eigen::Matrix<double, dim, nodes> g;
        for (int i = 0; i < nodes; ++i) {
            double factor[dim];
            double slope[dim];
            double sum = -2.0;
            for (int d = 0; d < dim; ++d) {
                factor[d] = local[i][d] == 0 ? 1.0 - at[d] * at[d] : 1.0 + local[i][d] * at[d];
                slope[d] = local[i][d] == 0 ? -2.0 * at[d] : local[i][d];
                sum += local[i][d] * at[d];
            }
            for (int d = 0; d < dim; ++d) {
                const double others = factor[(d + 1) % dim] * factor[(d + 2) % dim];
                g(d, i) = i < 8 ? others * (slope[d] * sum + factor[d] * local[i][d]) / 8.0 : others * slope[d] / 4.0;
            }
        }
        return g;
    }

    // A Gauss point: its weight (volume) and the rows dN/dx, dN/dy, dN/dz.
    struct Point {
        double weight = 0.0;
        Eigen::Matrix<double, dim, nodes> rows;
    };

    // Point number 4 i + 2 j + k lies at the i-th position in xi, the j-th in eta, the k-th in zeta.
    static std::array<Position, gauss> gauss_positions() {
        constexpr double g = std::numbers::inv_sqrt3;
        std::array<Position, gauss> positions;
        for (int q = 0; q < gauss; ++q) {
            positions[q] = {q & 4 ? g : -g, q & 2 ? g : -g, q & 1 ? g : -g};
        }
        return positions;
    }

    static Point point(const Coordinates& x, const Position& position) {
        const auto g = shape_gradient(position);
        const Eigen::Matrix3d jacobian = g * x.transpose(); // rows: derivative by xi, eta, zeta
        Point p;
        p.weight = jacobian.determinant();
        p.rows = jacobian.inverse() * g;
        return p;
    }

    static double depth(const Coordinates& x, const Position& position) { return x.row(down).dot(shape(position)); }

    static Stress strain(const Point& p, const Vector& u) {
        const auto nodal = Eigen::Map<const Eigen::Matrix<double, dim, nodes>>(u.data());
        const Eigen::Matrix3d h = nodal * p.rows.transpose(); // h(i, j) = du_i/dx_j
        return {h(0, 0), h(1, 1), h(2, 2), h(0, 2) + h(2, 0), h(1, 2) + h(2, 1), h(0, 1) + h(1, 0)};
    }

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
    static void add_force(const Point& p, const Stress& stress, double scale, Vector& force) {
        Eigen::Matrix3d s;
        s << stress[0], stress[5], stress[3], stress[5], stress[1], stress[4], stress[3], stress[4], stress[2];
        Eigen::Map<Eigen::Matrix<double, dim, nodes>> nodal(force.data());
        nodal.noalias() += (scale * s) * p.rows;
    }
};

} // namespace pave::fe

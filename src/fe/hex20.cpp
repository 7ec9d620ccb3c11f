#include "fe/hex20.h"

#include <numbers>

namespace pave::fe {

Eigen::Matrix<double, Hex20::nodes, 1> Hex20::shape(const Position& at) {
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

Eigen::Matrix<double, Hex20::dim, Hex20::nodes> Hex20::shape_gradient(const Position& at) {
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

std::array<Hex20::Position, Hex20::gauss> Hex20::gauss_positions() {
    constexpr double g = std::numbers::inv_sqrt3;
    std::array<Position, gauss> positions;
    for (int q = 0; q < gauss; ++q) {
        positions[q] = {q & 4 ? g : -g, q & 2 ? g : -g, q & 1 ? g : -g};
    }
    return positions;
}

Hex20::Point Hex20::point(const Coordinates& x, const Position& position) {
    const auto g = shape_gradient(position);
    const Eigen::Matrix3d jacobian = g * x.transpose(); // rows: derivative by xi, eta, zeta
    Point p;
    p.weight = jacobian.determinant();
    p.rows = jacobian.inverse() * g;
    return p;
}

double Hex20::depth(const Coordinates& x, const Position& position) {
    return x.row(down).dot(shape(position));
}

Hex20::Stress Hex20::strain(const Point& p, const Vector& u) {
    const auto nodal = Eigen::Map<const Eigen::Matrix<double, dim, nodes>>(u.data());
    const Eigen::Matrix3d h = nodal * p.rows.transpose(); // h(i, j) = du_i/dx_j
    return {h(0, 0), h(1, 1), h(2, 2), h(0, 2) + h(2, 0), h(1, 2) + h(2, 1), h(0, 1) + h(1, 0)};
}

void Hex20::add_force(const Point& p, const Stress& stress, double scale, Vector& force) {
    Eigen::Matrix3d s;
    s << stress[0], stress[5], stress[3], stress[5], stress[1], stress[4], stress[3], stress[4], stress[2];
    Eigen::Map<Eigen::Matrix<double, dim, nodes>> nodal(force.data());
    nodal.noalias() += (scale * s) * p.rows;
}

} // namespace pave::fe

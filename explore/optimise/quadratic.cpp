#include "optimise/quadratic.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace explore::optimise {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// The d that minimises |rows d + rest|^2; rows of full rank by columns.
VectorXd least_squares(const MatrixXd& rows, const VectorXd& rest) {
    return -rows.colPivHouseholderQr().solve(rest);
}

} // namespace

Quadratic Quadratic::of(const MatrixXd& jacobian, const VectorXd& residuals, double damping) {
    const Index m = jacobian.rows();
    const Index n = jacobian.cols();
    std::vector<Index> order(static_cast<std::size_t>(m));
    std::iota(order.begin(), order.end(), 0);
    const VectorXd sizes = jacobian.cwiseAbs().rowwise().maxCoeff();
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return sizes[a] > sizes[b]; });
    MatrixXd rows(m + n, n);
    rows << jacobian(order, Eigen::all), std::sqrt(damping) * MatrixXd::Identity(n, n);
    VectorXd right(m + n);
    right << residuals(order), VectorXd::Zero(n);
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
    Quadratic q;
    const MatrixXd upper = qr.matrixR().topRows(n).triangularView<Eigen::Upper>();
    q.root = upper * qr.colsPermutation().transpose();
    q.rest = (qr.householderQ().adjoint() * right).eval().head(n);
    return q;
}

Quadratic Quadratic::curved(const MatrixXd& curvature) const {
    // In the coordinates z = root d it is |z|^2 / 2, whatever the sizes of the rows.
    const Eigen::PartialPivLU<MatrixXd> lu(root);
    const MatrixXd right = lu.transpose().solve(curvature);          // root^-T C
    const MatrixXd scaled = lu.transpose().solve(right.transpose()); // root^-T C root^-1, symmetric
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
        MatrixXd(MatrixXd::Identity(root.rows(), root.rows()) + 0.5 * (scaled + scaled.transpose())));
    constexpr double least = 0.1; // of what the rows alone have there
    const VectorXd values = eigen.eigenvalues().cwiseAbs().cwiseMax(least);
    const MatrixXd convex = eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
    const Eigen::LLT<MatrixXd> factor(convex);
    Quadratic q;
    q.root = factor.matrixU() * root;
    q.rest = factor.matrixL().solve(rest);
    return q;
}

VectorXd Quadratic::lowest(const VectorXd& low, const VectorXd& high) const {
    const Index n = root.cols();
    VectorXd d = VectorXd::Zero(n);
    const VectorXd g = root.transpose() * rest;
    std::vector<int> held(static_cast<std::size_t>(n), 0); // -1 at low, 1 at high
    for (Index i = 0; i < n; ++i) {
        if (g[i] > 0.0 && low[i] >= 0.0) {
            held[static_cast<std::size_t>(i)] = -1;
        } else if (g[i] < 0.0 && high[i] <= 0.0) {
            held[static_cast<std::size_t>(i)] = 1;
        }
    }
    for (int iteration = 0; iteration < 10 * n + 10; ++iteration) {
        std::vector<Index> open;
        for (Index i = 0; i < n; ++i) {
            if (held[static_cast<std::size_t>(i)] == 0) {
                open.push_back(i);
            }
        }
        VectorXd move = VectorXd::Zero(n);
        if (!open.empty()) {
            const VectorXd found = least_squares(root(Eigen::all, open), root * d + rest);
            move(open) = found;
        }
        // As far as the first bound.
        double length = 1.0;
        Index first = -1;
        for (const Index i : open) {
            const double room = move[i] > 0.0 ? high[i] - d[i] : low[i] - d[i];
            if (std::abs(move[i]) > 0.0 && room / move[i] < length) {
                length = std::max(0.0, room / move[i]);
                first = i;
            }
        }
        d += length * move;
        if (first >= 0) {
            const bool up = move[first] > 0.0;
            d[first] = up ? high[first] : low[first];
            held[static_cast<std::size_t>(first)] = up ? 1 : -1;
            continue;
        }
        // Release the bound that holds back most, by more than rounding.
        const VectorXd slope = root.transpose() * (root * d + rest);
        const VectorXd rounding =
            16.0 * epsilon * root.cwiseAbs().transpose() * (root.cwiseAbs() * d.cwiseAbs() + rest.cwiseAbs());
        Index release = -1;
        double most = 0.0;
        for (Index i = 0; i < n; ++i) {
            const double pull = held[static_cast<std::size_t>(i)] * slope[i];
            if (pull > std::max(most, rounding[i])) {
                most = pull;
                release = i;
            }
        }
        if (release < 0) {
            break;
        }
        held[static_cast<std::size_t>(release)] = 0;
    }
    return d;
}

} // namespace explore::optimise

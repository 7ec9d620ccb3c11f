// Flexible generalised minimal residuals (Saad 1993): for systems that are not symmetric and are given by their product
// with a vector. Flexible, because a preconditioner in single precision is not quite a linear map.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

namespace pave::fe {

// Solves A x = b in place of x = b, to |b - A x| <= tolerance |b|. apply(v) = A v, precondition(v) = M^-1 v, both
// return a vector. Returns the number of steps, or -1 when `max_steps` were not enough.
int gmres(Eigen::VectorXd& x, const auto& apply, const auto& precondition, double tolerance, int max_steps) {
    const double norm = x.norm();
    if (norm == 0.0) {
        return 0;
    }
    std::vector<Eigen::VectorXd> basis{x / norm};
    std::vector<Eigen::VectorXd> directions; // M^-1 basis
    std::vector<Eigen::VectorXd> columns;    // of the Hessenberg matrix, turned to upper triangular as they come
    std::vector<double> cosine;
    std::vector<double> sine;
    std::vector<double> right{norm};
    int steps = 0;
    while (std::abs(right.back()) > tolerance * norm) {
        if (steps == max_steps) {
            return -1;
        }
        directions.push_back(precondition(basis.back()));
        Eigen::VectorXd v = apply(directions.back());
        Eigen::VectorXd h = Eigen::VectorXd::Zero(steps + 2);
        for (int pass = 0; pass < 2; ++pass) {
            for (int i = 0; i <= steps; ++i) {
                const double part = basis[i].dot(v);
                h[i] += part;
                v -= part * basis[i];
            }
        }
        h[steps + 1] = v.norm();
        if (!std::isfinite(h[steps + 1])) {
            return -1;
        }
        basis.push_back(h[steps + 1] > 0.0 ? Eigen::VectorXd(v / h[steps + 1]) : v);
        for (int i = 0; i < steps; ++i) {
            const double upper = cosine[i] * h[i] + sine[i] * h[i + 1];
            h[i + 1] = cosine[i] * h[i + 1] - sine[i] * h[i];
            h[i] = upper;
        }
        const double length = std::hypot(h[steps], h[steps + 1]);
        if (length == 0.0) {
            return -1;
        }
        cosine.push_back(h[steps] / length);
        sine.push_back(h[steps + 1] / length);
        h[steps] = length;
        right.push_back(-sine.back() * right[steps]);
        right[steps] *= cosine.back();
        columns.push_back(std::move(h));
        ++steps;
    }
    Eigen::VectorXd weight = Eigen::VectorXd::Zero(steps);
    for (int i = steps - 1; i >= 0; --i) {
        double sum = right[i];
        for (int j = i + 1; j < steps; ++j) {
            sum -= columns[j][i] * weight[j];
        }
        weight[i] = sum / columns[i][i];
    }
    x.setZero();
    for (int i = 0; i < steps; ++i) {
        x += weight[i] * directions[i];
    }
    return steps;
}

} // namespace pave::fe

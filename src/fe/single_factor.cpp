#include "fe/single_factor.h"

#include <algorithm>

namespace pave::fe {
namespace {

using Matrix = Eigen::Map<const Eigen::MatrixXf>;
using Vector = Eigen::Map<Eigen::VectorXf>;

// t := A x for the C columns of x, A (rows x columns) by columns.
template <int C>
void product(const float* a, int rows, int columns, const float* x, float* t) {
    using Row = Eigen::Array<float, 1, C>;
    std::fill(t, t + static_cast<std::ptrdiff_t>(rows) * C, 0.0F);
    int j = 0;
    for (; j + 4 <= columns; j += 4) {
        const float* a0 = a + static_cast<std::ptrdiff_t>(j) * rows;
        const float* a1 = a0 + rows;
        const float* a2 = a1 + rows;
        const float* a3 = a2 + rows;
        const Row x0 = Eigen::Map<const Row>(x + j * C);
        const Row x1 = Eigen::Map<const Row>(x + (j + 1) * C);
        const Row x2 = Eigen::Map<const Row>(x + (j + 2) * C);
        const Row x3 = Eigen::Map<const Row>(x + (j + 3) * C);
        for (int i = 0; i < rows; ++i) {
            Eigen::Map<Row>(t + static_cast<std::ptrdiff_t>(i) * C) +=
                a0[i] * x0 + a1[i] * x1 + a2[i] * x2 + a3[i] * x3;
        }
    }
    for (; j < columns; ++j) {
        const float* a0 = a + static_cast<std::ptrdiff_t>(j) * rows;
        const Row x0 = Eigen::Map<const Row>(x + j * C);
        for (int i = 0; i < rows; ++i) {
            Eigen::Map<Row>(t + static_cast<std::ptrdiff_t>(i) * C) += a0[i] * x0;
        }
    }
}

// t := A^T x for the C columns of x.
template <int C>
void transposed_product(const float* a, int rows, int columns, const float* x, float* t) {
    using Row = Eigen::Array<float, 1, C>;
    int j = 0;
    for (; j + 4 <= columns; j += 4) {
        const float* a0 = a + static_cast<std::ptrdiff_t>(j) * rows;
        const float* a1 = a0 + rows;
        const float* a2 = a1 + rows;
        const float* a3 = a2 + rows;
        Row t0 = Row::Zero(), t1 = Row::Zero(), t2 = Row::Zero(), t3 = Row::Zero();
        for (int i = 0; i < rows; ++i) {
            const Row xi = Eigen::Map<const Row>(x + static_cast<std::ptrdiff_t>(i) * C);
            t0 += a0[i] * xi;
            t1 += a1[i] * xi;
            t2 += a2[i] * xi;
            t3 += a3[i] * xi;
        }
        Eigen::Map<Row>(t + j * C) = t0;
        Eigen::Map<Row>(t + (j + 1) * C) = t1;
        Eigen::Map<Row>(t + (j + 2) * C) = t2;
        Eigen::Map<Row>(t + (j + 3) * C) = t3;
    }
    for (; j < columns; ++j) {
        const float* a0 = a + static_cast<std::ptrdiff_t>(j) * rows;
        Row t0 = Row::Zero();
        for (int i = 0; i < rows; ++i) {
            t0 += a0[i] * Eigen::Map<const Row>(x + static_cast<std::ptrdiff_t>(i) * C);
        }
        Eigen::Map<Row>(t + j * C) = t0;
    }
}

template <>
void product<1>(const float* a, int rows, int columns, const float* x, float* t) {
    Vector(t, rows).noalias() = Matrix(a, rows, columns) * Eigen::Map<const Eigen::VectorXf>(x, columns);
}
template <>
void transposed_product<1>(const float* a, int rows, int columns, const float* x, float* t) {
    Vector(t, columns).noalias() = Matrix(a, rows, columns).transpose() * Eigen::Map<const Eigen::VectorXf>(x, rows);
}

} // namespace

template <int C>
void SingleFactor::solve(Block<C>& z) {
    const auto n = static_cast<std::ptrdiff_t>(permutation.size());
    x_.resize(static_cast<std::size_t>(n) * C);
    t_.resize(static_cast<std::size_t>(n) * C);
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        for (int c = 0; c < C; ++c) {
            x_[i * C + c] = static_cast<float>(z(permutation[i], c));
        }
    }
    float* t = t_.data();
    for (const Supernode& s : supernodes) {
        float* x = x_.data() + static_cast<std::ptrdiff_t>(s.first_column) * C;
        const float* diagonal = values.data() + s.start;
        const float* below = diagonal + static_cast<std::ptrdiff_t>(s.columns) * s.columns;
        product<C>(diagonal, s.columns, s.columns, x, t);
        std::copy(t, t + static_cast<std::ptrdiff_t>(s.columns) * C, x);
        if (s.rows_below == 0) {
            continue;
        }
        product<C>(below, s.rows_below, s.columns, x, t);
        const int* row = rows.data() + s.row_start;
        for (int i = 0; i < s.rows_below; ++i) {
            float* to = x_.data() + static_cast<std::ptrdiff_t>(row[i]) * C;
            for (int c = 0; c < C; ++c) {
                to[c] -= t[i * C + c];
            }
        }
    }
    std::vector<float>& sum = sum_;
    for (auto it = supernodes.rbegin(); it != supernodes.rend(); ++it) {
        const Supernode& s = *it;
        float* x = x_.data() + static_cast<std::ptrdiff_t>(s.first_column) * C;
        const float* diagonal = values.data() + s.start;
        const float* below = diagonal + static_cast<std::ptrdiff_t>(s.columns) * s.columns;
        sum.resize(static_cast<std::size_t>(s.columns) * C);
        if (s.rows_below > 0) {
            const int* row = rows.data() + s.row_start;
            for (int i = 0; i < s.rows_below; ++i) {
                const float* from = x_.data() + static_cast<std::ptrdiff_t>(row[i]) * C;
                for (int c = 0; c < C; ++c) {
                    t[i * C + c] = from[c];
                }
            }
            transposed_product<C>(below, s.rows_below, s.columns, t, sum.data());
            for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(s.columns) * C; ++k) {
                x[k] -= sum[k];
            }
        }
        transposed_product<C>(diagonal, s.columns, s.columns, x, sum.data());
        std::copy(sum.begin(), sum.end(), x);
    }
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        for (int c = 0; c < C; ++c) {
            z(permutation[i], c) = x_[i * C + c];
        }
    }
}

template void SingleFactor::solve<1>(Block<1>&);
template void SingleFactor::solve<4>(Block<4>&);
template void SingleFactor::solve<8>(Block<8>&);

} // namespace pave::fe

// Rates by all variations at once. Private to fe/.
#pragma once

#include "fe/sparse_solver.h"

#include <Eigen/Core>
#include <vector>

namespace pave::fe {

// One number a row and variation: of every unknown, or of every reading.
using Rates = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// y += K x, with the values of K on the pattern of its lower triangle.
inline void add_product(const Pattern& lower, const std::vector<double>& values, const Rates& x, Rates& y) {
    const auto add = [count = x.cols()](double value, const double* from, double* to) {
        for (Eigen::Index k = 0; k < count; ++k) {
            to[k] += value * from[k];
        }
    };
    for (int j = 0; j < lower.size; ++j) {
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            const int i = lower.row[k];
            add(values[k], x.row(j).data(), y.row(i).data());
            if (i != j) {
                add(values[k], x.row(i).data(), y.row(j).data());
            }
        }
    }
}

} // namespace pave::fe

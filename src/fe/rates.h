// Rates by all variations at once. Private to fe/.
#pragma once

#include "fe/sparse_solver.h"

#include <Eigen/Core>
#include <vector>

namespace pave::fe {

// One number a row and variation: of every unknown, or of every reading.
using Rates = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The same of C of the columns, from one on.
template <int C>
void add_product_of(const Pattern& lower, const std::vector<double>& values, const Rates& x, Rates& y,
                    Eigen::Index first) {
    using Row = Eigen::Array<double, 1, C>;
    const auto of = [&](auto& rates, int i) { return rates.data() + i * rates.cols() + first; };
    for (int j = 0; j < lower.size; ++j) {
        const Row own = Eigen::Map<const Row>(of(x, j));
        Row row = Eigen::Map<const Row>(of(y, j));
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            const int i = lower.row[k];
            if (i != j) {
                Eigen::Map<Row>(of(y, i)) += values[k] * own;
            }
            row += values[k] * Eigen::Map<const Row>(of(x, i));
        }
        Eigen::Map<Row>(of(y, j)) = row;
    }
}

// y += K x, with the values of K on the pattern of its lower triangle.
inline void add_product(const Pattern& lower, const std::vector<double>& values, const Rates& x, Rates& y) {
    Eigen::Index done = 0;
    for (; x.cols() - done >= 4; done += 4) {
        add_product_of<4>(lower, values, x, y, done);
    }
    for (; x.cols() - done >= 2; done += 2) {
        add_product_of<2>(lower, values, x, y, done);
    }
    if (done < x.cols()) {
        add_product_of<1>(lower, values, x, y, done);
    }
}

} // namespace pave::fe

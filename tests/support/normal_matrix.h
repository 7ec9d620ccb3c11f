// Matrices of standard normal numbers.
#pragma once

#include "base/random.h"

#include <Eigen/Dense>

namespace test {

// Those of the stream from its number `first` on.
inline Eigen::MatrixXd normal_matrix(const pave::RandomStream& random, Eigen::Index rows, Eigen::Index columns,
                                     std::uint64_t first) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(first++); });
}

} // namespace test

// A Cholesky factor rounded to single precision: half the memory to pass over, and as good a preconditioner.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace pave::fe {

// Right-hand sides side by side: C of them to a row, so that one pass over a matrix serves all.
template <int C>
using Block = Eigen::Matrix<double, Eigen::Dynamic, C, C == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// L of P K P^T = L L^T by supernodes: columns that share the rows below them.
class SingleFactor {
public:
    struct Supernode {
        int first_column = 0;
        int columns = 0;
        int rows_below = 0;
        std::size_t row_start = 0; // into rows: the rows below
        std::size_t start = 0;     // into values: inverse of the diagonal block, then the block below; both by columns
    };

    std::vector<int> permutation; // row i of P K P^T is row permutation[i] of K
    std::vector<Supernode> supernodes;
    std::vector<int> rows;
    std::vector<float> values;

    // z := (L L^T)^-1 z in the order of K. C: 1, 4 or 8.
    template <int C>
    void solve(Block<C>& z);

private:
    std::vector<float> x_;   // permuted right-hand sides
    std::vector<float> t_;   // of the rows below one supernode
    std::vector<float> sum_; // of the columns of one supernode
};

} // namespace pave::fe

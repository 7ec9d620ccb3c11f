// Sparse Cholesky factors of matrices of one pattern, by dense blocks.
#pragma once

#include "fe/aligned.h"

#include <Eigen/Dense>
#include <span>
#include <vector>

namespace pave::fe {

// Lower triangle (or full matrix) of a square sparse matrix by columns, rows sorted.
struct Pattern {
    int size = 0;
    std::vector<int> column_start; // size + 1
    std::vector<int> row;
};

// Right-hand sides side by side: C of them to a row, so that one pass over a matrix serves all.
template <int C>
using Block = Eigen::Matrix<double, Eigen::Dynamic, C, C == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// Where everything of the factor L of P K P^T = L L^T lies. Immutable, one for all factors of a pattern.
struct FactorStructure {
    // Columns that share the rows below them. They are eliminated together, in a dense front whose rows are the columns
    // of the supernode and then the rows below; what is left of the front is added to that of the parent.
    struct Supernode {
        int first_column = 0;
        int columns = 0;
        int rows_below = 0;
        bool is_constant = false; // so are all below it in the tree
        int parent = -1;
        int first_child = -1;
        int next_sibling = -1;
        std::size_t row_start = 0;   // into rows: the columns, then the rows below
        std::size_t entry_start = 0; // into entry_value and entry_place; those of the next one end them
        std::size_t first_panel = 0;
        std::size_t first_run = 0;
        std::size_t kept_start = 0; // into what is kept of constant fronts with a parent that is not
        int front_rows() const { return columns + rows_below; }
        // From a column of the front to the next: whole vectors of any processor, an odd number of them, so that
        // columns do not compete for the same places of its cache.
        std::ptrdiff_t stride() const { return ((front_rows() + 7) / 8 | 1) * 8; }
    };
    // A few columns of a supernode, as they are stored.
    struct Panel {
        int first_column = 0;
        int columns = 0;
        int rows_below = 0;
        std::size_t row_start = 0; // into rows: the rows below
        std::size_t start = 0;     // into the values: inverse of the diagonal block, then the block below; by columns
    };

    // Neighbouring rows below a supernode that are neighbours in its parent's front, too.
    struct Run {
        int first = 0; // of the rows below
        int rows = 0;
        int place = 0; // of the first one, in the parent's front
    };

    FactorStructure() = default;
    // The order of elimination (row i of P K P^T is row order[i] of K), the first column of every supernode and one
    // past the last, and the rows of each, its own columns first. Children come before their parent, and next to each
    // other. constant: of each unknown, whether its column of K stays the same along a sequence of matrices.
    FactorStructure(const Pattern& lower, std::vector<int> order, const std::vector<int>& first_columns,
                    const std::vector<std::vector<int>>& rows_of, const std::vector<bool>& constant);

    // Multiplications and additions that eliminate what is not constant.
    double changing_operations() const;

    std::vector<int> permutation;
    std::vector<Supernode> supernodes; // and one more, which only ends the last one's entries, panels and runs
    std::vector<Panel> panels;
    std::vector<Run> runs;
    std::vector<int> rows;
    std::vector<int> entry_value; // number of an entry of K, and its place in the front of its supernode
    std::vector<int> entry_place;
    std::vector<int> place_in_parent; // of every row below, at its place in rows: its row in the parent's front
    std::size_t values = 0;           // numbers in the factor
    std::size_t largest_front = 0;    // numbers
    std::size_t largest_stack = 0;    // numbers of the fronts that wait for their parents
    std::size_t kept = 0;             // numbers of the constant fronts that are kept
};

namespace lanes {
struct Kernels;
}

// Multifrontal elimination (Duff and Reid 1983). Scalar: double, or float for a preconditioner: half the memory to pass
// over.
template <class Scalar>
class SupernodalFactor {
public:
    // Both must outlive the object. kernels: of a factor in double precision; nullptr: those of the processor.
    SupernodalFactor(const Pattern& lower, const FactorStructure& structure, const lanes::Kernels* kernels = nullptr);

    // Of a matrix with one value for each entry of the pattern. first: of a sequence; the matrices that follow have
    // the same constant columns. False where the matrix is found not to be positive definite, in single precision also
    // where it is so by less than that can tell.
    bool factorize(std::span<const double> values, bool first);

    // z := (L L^T)^-1 z in the order of K. C: 1, 4 or 8.
    template <int C>
    void solve(Block<C>& z);

private:
    using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
    using Numbers = std::vector<Scalar, AlignedAllocator<Scalar>>;

    bool eliminate(std::span<const double> values, bool constant);
    bool eliminate_front(const FactorStructure::Supernode& node);
    void store_panels(const FactorStructure::Supernode& node);
    template <int C>
    void substitute();
    void in_panels(const auto& forth, const auto& back, auto... scratch);

    const Pattern& lower_;
    const FactorStructure& structure_;
    const lanes::Kernels& kernels_;
    Numbers values_;
    Numbers front_;
    Numbers stack_;
    Numbers kept_;
    Numbers x_;   // permuted right-hand sides
    Numbers t_;   // of the rows below one panel
    Numbers sum_; // of the columns of one panel
};

} // namespace pave::fe

// Sparse direct solvers on a fixed pattern: Cholesky (CHOLMOD) and LU (UMFPACK). One object a thread.
#pragma once

#include "fe/single_factor.h"

#include <memory>
#include <span>
#include <vector>

namespace pave::fe {

// Lower triangle (or full matrix) of a square sparse matrix by columns, rows sorted.
struct Pattern {
    int size = 0;
    std::vector<int> column_start; // size + 1
    std::vector<int> row;
};

// Fill-reducing order and structure of the Cholesky factor of one pattern, shared by all threads. Immutable.
class CholeskyAnalysis {
public:
    explicit CholeskyAnalysis(const Pattern& lower);
    ~CholeskyAnalysis();
    CholeskyAnalysis(const CholeskyAnalysis&) = delete;
    CholeskyAnalysis& operator=(const CholeskyAnalysis&) = delete;

    // How many this process has made: one a mesh, whatever the number of threads and runs.
    static int made();

private:
    friend class SparseCholesky;
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// Cholesky factorisation of a symmetric positive definite matrix given by its lower triangle.
class SparseCholesky {
public:
    // Both must outlive the object; the analysis is of this pattern.
    SparseCholesky(const Pattern& lower, const CholeskyAnalysis& analysis);
    ~SparseCholesky();
    SparseCholesky(const SparseCholesky&) = delete;
    SparseCholesky& operator=(const SparseCholesky&) = delete;

    // False when the matrix is not positive definite. values: one for each entry of the pattern.
    bool factorize(std::span<const double> values);

    // x := K^-1 x for `columns` right-hand sides stored one after the other.
    void solve(double* x, int columns);

    // The factor of the last matrix, rounded.
    void round_to(SingleFactor& single) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// LU factorisation of an unsymmetric matrix given in full.
class SparseLu {
public:
    explicit SparseLu(const Pattern& full);
    ~SparseLu();
    SparseLu(const SparseLu&) = delete;
    SparseLu& operator=(const SparseLu&) = delete;

    // False when the matrix is singular.
    bool factorize(std::span<const double> values);
    // x := K^-1 x
    void solve(double* x, int columns);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

} // namespace pave::fe

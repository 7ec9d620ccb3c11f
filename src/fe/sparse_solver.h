// Sparse direct solvers on a fixed pattern: Cholesky (CHOLMOD) and LU (UMFPACK). One object a thread.
#pragma once

#include "fe/model.h"

#include <memory>
#include <span>

namespace pave::fe {

// Cholesky factorisation of a symmetric positive definite matrix given by its lower triangle.
class SparseCholesky {
public:
    // Analyses the pattern once. The pattern must outlive the object.
    explicit SparseCholesky(const Pattern& lower);
    ~SparseCholesky();
    SparseCholesky(const SparseCholesky&) = delete;
    SparseCholesky& operator=(const SparseCholesky&) = delete;

    // False when the matrix is not positive definite. values: one for each entry of the pattern.
    bool factorize(std::span<const double> values);

    // x := K^-1 x for `columns` right-hand sides stored one after the other.
    void solve(double* x, int columns);

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

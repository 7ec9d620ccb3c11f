// SuiteSparse for the sparse direct solvers: the analysis of a pattern (CHOLMOD), and LU (UMFPACK).
#pragma once

#include "fe/supernodal_factor.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pave::fe {

// "CHOLMOD 3.0.14"
std::string sparse_solver_version();

// Fill-reducing order and structure of the Cholesky factor of one pattern, shared by all threads. Immutable.
class CholeskyAnalysis {
public:
    // constant: of each unknown, whether its column stays the same along a sequence of matrices. first: of each,
    // whether it is eliminated before all others (constrained minimum degree); empty: the order is CHOLMOD's, the
    // better of minimum degree and nested dissection.
    CholeskyAnalysis(const Pattern& lower, const std::vector<bool>& constant, const std::vector<bool>& first = {});

    const FactorStructure& structure() const { return structure_; }

    // How many this process has made: one a mesh, whatever the number of threads and runs.
    static int made();

private:
    FactorStructure structure_;
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

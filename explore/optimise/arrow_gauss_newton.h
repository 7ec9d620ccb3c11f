// Least squares over many blocks of residuals that have some of their unknowns in common, as the stations of a road
// have a material: the normal matrix is an arrow.
#pragma once

#include "optimise/local_search.h"

namespace explore::optimise {

// A block of residuals and its unknowns.
struct ArrowBlock {
    std::vector<int> common; // of each unknown: which of the common ones it is; own_unknown: this block's alone
};
inline constexpr int own_unknown = -1;

// Fills the sample of one block at its unknowns in unit coordinates: residuals, and their derivatives by each. Limits
// are not used. Called from many threads at once; else as Objective.
using ArrowObjective = std::function<Answer(std::size_t block, std::span<const double> unit, Sample& sample)>;
// Calls body(i) for every i in [0, count), in any order and at the same time.
using ForEach = std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

struct ArrowResult {
    std::vector<std::vector<double>> unit; // of every block, the best computed; empty: the start has no answer
    std::vector<double> squares;           // sum of squared residuals of each block there
    std::vector<Eigen::MatrixXd> normal;   // J'J of each block there, over its unknowns
    int rounds = 0;                        // evaluations of every block
    bool converged = false, stopped = false;
    std::string ended; // in words
};

// The steps of gauss_newton() (Levenberg-Marquardt in the unit cube, damping after Nielsen 1999, without the secant
// matrix) over all unknowns at once. Each block's own unknowns are eliminated first, so that a step costs a small
// factorisation a block and one of the common unknowns (Schur complement); what is kept of a block is its normal
// matrix. Damping counts a common unknown once for every block that has it. Bounds hold by a primal-dual active set
// (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13). Blocks are added up in their order: the result does not
// depend on the order or number of calls at the same time.
//
// start: the unknowns of every block; those in common must agree. settings: as of gauss_newton; max_evaluations counts
// rounds.
ArrowResult arrow_gauss_newton(const std::vector<ArrowBlock>& blocks, std::vector<std::vector<double>> start,
                               const ArrowObjective& objective, const ForEach& for_each,
                               const SearchSettings& settings);

// The covariance of the unknowns by the normal matrices, for residuals of unit variance.
struct ArrowCovariance {
    Eigen::MatrixXd information;         // of the common unknowns, the others free: the Schur complement
    Eigen::MatrixXd common;              // its inverse
    std::vector<Eigen::MatrixXd> blocks; // covariance of the unknowns of each block, common and own
};
// Every unknown gets an information of 1e-6 besides (a standard deviation of a thousand boxes), so that one that no
// residual sees has a covariance too.
ArrowCovariance arrow_covariance(const std::vector<ArrowBlock>& blocks, const std::vector<Eigen::MatrixXd>& normal);

} // namespace explore::optimise

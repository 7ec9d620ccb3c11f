// A sequence of symmetric positive definite systems on one pattern, as a load path poses them: each matrix is near the
// one before.
#pragma once

#include "fe/sparse_solver.h"

#include <Eigen/Dense>

namespace pave::fe {

// Scalar: double, every matrix is factorised; float, conjugate gradients preconditioned by the factor of an earlier
// matrix of the sequence, and a matrix is factorised when that no longer pays. Where single precision cannot carry a
// matrix (stiffness that differs by some seven decades), the rest of the sequence takes factors in double precision.
template <class Scalar>
class SymmetricSystem {
public:
    // The pattern and its analysis must outlive the object.
    SymmetricSystem(const Pattern& lower, const CholeskyAnalysis& analysis);

    // Begins a sequence: nothing that was solved before has an influence on what follows.
    // tolerance: error of a solution in the energy norm, relative to the solution (float).
    // constants_hold: the columns that the analysis takes for constant are so in the whole sequence.
    void begin(double tolerance, bool constants_hold);

    // The matrix of the moment, one value for each entry of the pattern; must stay until the next one. False when it is
    // found not to be positive definite.
    bool set_matrix(std::span<const double> values);

    // x := K^-1 x for the columns of x. guesses: matrices with as many rows whose columns, all together, may span
    // something near the answers (the answers of earlier systems). False when K is found not to be positive definite.
    bool solve(Eigen::Ref<Eigen::MatrixXd> x, std::span<const Eigen::Map<const Eigen::MatrixXd>> guesses);

    // For solvers of systems near this one (float): the product with the matrix of the moment, and with the
    // inverse of the factor at hand.
    Eigen::VectorXd product(const Eigen::VectorXd& x) const;
    Eigen::VectorXd preconditioned(Eigen::VectorXd x);
    // Says how many steps such a solver took with the factor; -1: too many, the matrix of the moment is factorised now.
    // False when it is found not to be positive definite.
    bool took_steps(int steps);

    int factorizations() const { return factorizations_; } // since begin()
    int iterations() const { return iterations_; }         // since begin(), all columns together count once

private:
    // y := K x
    template <int C>
    void multiply(const Block<C>& x, Block<C>& y) const;
    bool factorize();
    // K x for a matrix of any number of columns.
    Eigen::MatrixXd image(const Eigen::MatrixXd& x) const;
    // z := inverse of the factor at hand z
    template <int C>
    void apply_factor(Block<C>& z);
    // C columns of x from `first` on, those beyond its end zero. start: what to begin with instead of zero, where it
    // has columns, and its product with K.
    template <int C>
    bool solve_block(Eigen::Ref<Eigen::MatrixXd> x, Eigen::Index first, const Eigen::MatrixXd& start,
                     const Eigen::MatrixXd& image_of_start);
    // x: where it starts, and the solution; image: its product with K, empty of zero. False: no solution.
    template <int C>
    bool iterate(const Block<C>& b, const Block<C>& image, Block<C>& x);

    const Pattern& lower_;
    const FactorStructure& structure_;
    SupernodalFactor<Scalar> factor_;
    std::unique_ptr<SupernodalFactor<double>> precise_factor_; // made when first needed
    std::span<const double> values_;
    double tolerance_ = 0.0;
    bool constants_hold_ = false;
    bool is_precise_ = false; // the factor at hand is precise_factor_
    bool has_factor_ = false;
    bool factor_is_own_ = false;   // of the matrix of the moment
    bool factor_is_stale_ = false; // factorise the next matrix
    int factorizations_ = 0;
    int iterations_ = 0;
};

} // namespace pave::fe

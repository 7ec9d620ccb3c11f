#include "fe/symmetric_system.h"

#include <cmath>
#include <type_traits>

namespace pave::fe {
namespace {

// A solve that takes more steps than this makes the next matrix be factorised; one that takes more than the second, its
// own. A factorisation costs about as much as twenty steps.
constexpr int many_steps = 12;
constexpr int too_many_steps = 30;

template <int C>
using Lanes = Eigen::Array<double, 1, C>;

// Column by column: a . b, a += factor b, a *= factor.
template <int C>
Lanes<C> dot(const Block<C>& a, const Block<C>& b) {
    Lanes<C> sum = Lanes<C>::Zero();
    if constexpr (C == 1) {
        sum[0] = a.dot(b);
    } else {
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
            sum += a.row(i).array() * b.row(i).array();
        }
    }
    return sum;
}
template <int C>
void add(Block<C>& a, const Lanes<C>& factor, const Block<C>& b) {
    if constexpr (C == 1) {
        a += factor[0] * b;
    } else {
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
            a.row(i).array() += factor * b.row(i).array();
        }
    }
}
template <int C>
void scale(Block<C>& a, const Lanes<C>& factor) {
    if constexpr (C == 1) {
        a *= factor[0];
    } else {
        for (Eigen::Index i = 0; i < a.rows(); ++i) {
            a.row(i).array() *= factor;
        }
    }
}

} // namespace

template <class Scalar>
SymmetricSystem<Scalar>::SymmetricSystem(const Pattern& lower, const CholeskyAnalysis& analysis)
    : lower_(lower),
      factor_(lower, analysis.structure()) {}

template <class Scalar>
void SymmetricSystem<Scalar>::begin(double tolerance, bool constants_hold) {
    tolerance_ = tolerance;
    constants_hold_ = constants_hold;
    has_factor_ = false;
    factor_is_stale_ = false;
    factorizations_ = 0;
    iterations_ = 0;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::factorize() {
    const bool is_first = factorizations_ == 0 || !constants_hold_;
    ++factorizations_;
    has_factor_ = factor_.factorize(values_, is_first);
    factor_is_own_ = has_factor_;
    factor_is_stale_ = false;
    return has_factor_;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::set_matrix(std::span<const double> values) {
    values_ = values;
    factor_is_own_ = false;
    const bool serves = std::is_same_v<Scalar, float> && has_factor_ && !factor_is_stale_;
    return serves || factorize();
}

template <class Scalar>
template <int C>
void SymmetricSystem<Scalar>::multiply(const Block<C>& x, Block<C>& y) const {
    using Row = Lanes<C>;
    y.setZero(x.rows(), C);
    for (int j = 0; j < lower_.size; ++j) {
        const int first = lower_.column_start[j]; // the diagonal entry
        const Row xj = Eigen::Map<const Row>(x.data() + static_cast<std::ptrdiff_t>(j) * C);
        Row sum = values_[first] * xj;
        for (int k = first + 1; k < lower_.column_start[j + 1]; ++k) {
            const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(lower_.row[k]) * C;
            Eigen::Map<Row>(y.data() + i) += values_[k] * xj;
            sum += values_[k] * Eigen::Map<const Row>(x.data() + i);
        }
        Eigen::Map<Row>(y.data() + static_cast<std::ptrdiff_t>(j) * C) += sum;
    }
}

template <class Scalar>
Eigen::VectorXd SymmetricSystem<Scalar>::product(const Eigen::VectorXd& x) const {
    Block<1> y;
    multiply<1>(x, y);
    return y;
}

template <class Scalar>
Eigen::VectorXd SymmetricSystem<Scalar>::preconditioned(Eigen::VectorXd x) {
    factor_.template solve<1>(x);
    return x;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::took_steps(int steps) {
    if (steps < 0) {
        return factorize();
    }
    iterations_ += steps;
    factor_is_stale_ = steps > many_steps;
    return true;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::solve(Eigen::Ref<Eigen::MatrixXd> x,
                                    std::span<const Eigen::Map<const Eigen::MatrixXd>> guesses) {
    bool ok = true;
    for (Eigen::Index first = 0; ok && first < x.cols();) {
        const Eigen::Index left = x.cols() - first;
        if (left == 1) {
            ok = solve_block<1>(x, first, guesses);
            first += 1;
        } else if (left <= 4) {
            ok = solve_block<4>(x, first, guesses);
            first += 4;
        } else {
            ok = solve_block<8>(x, first, guesses);
            first += 8;
        }
    }
    return ok;
}

template <class Scalar>
template <int C>
bool SymmetricSystem<Scalar>::solve_block(Eigen::Ref<Eigen::MatrixXd> matrix, Eigen::Index first,
                                          std::span<const Eigen::Map<const Eigen::MatrixXd>> guesses) {
    const Eigen::Index n = matrix.rows();
    const Eigen::Index columns = std::min<Eigen::Index>(C, matrix.cols() - first);
    const auto load = [&](const auto& from, Block<C>& to) {
        to.setZero(n, C);
        to.leftCols(columns) = from.middleCols(first, columns);
    };
    Block<C> b;
    load(matrix, b);
    if constexpr (std::is_same_v<Scalar, double>) {
        factor_.template solve<C>(b);
        matrix.middleCols(first, columns) = b.leftCols(columns);
        return b.allFinite();
    }
    Block<C> r;
    r = b;
    Block<C> x = Block<C>::Zero(n, C);
    Block<C> z;
    Block<C> q;
    if (!guesses.empty() && !factor_is_own_) {
        // The best combination of the guesses in the energy norm (a Galerkin projection). They lie close to each other:
        // made orthogonal, they keep the small system well posed.
        const std::size_t count = guesses.size();
        std::vector<Block<C>> basis(count);
        std::vector<Block<C>> image(count);
        for (std::size_t k = 0; k < count; ++k) {
            load(guesses[k], basis[k]);
            const Lanes<C> whole = dot<C>(basis[k], basis[k]).sqrt();
            for (int pass = 0; pass < 2; ++pass) {
                for (std::size_t l = 0; l < k; ++l) {
                    add<C>(basis[k], -dot<C>(basis[l], basis[k]), basis[l]);
                }
            }
            const Lanes<C> norm = dot<C>(basis[k], basis[k]).sqrt();
            scale<C>(basis[k], (norm > 1e-12 * whole).select(norm.inverse(), Lanes<C>::Zero()));
            multiply<C>(basis[k], image[k]);
        }
        const auto size = static_cast<Eigen::Index>(count);
        std::vector<Lanes<C>> small(count * count);
        std::vector<Lanes<C>> right(count);
        for (std::size_t k = 0; k < count; ++k) {
            right[k] = dot<C>(basis[k], b);
            for (std::size_t l = 0; l < count; ++l) {
                small[k * count + l] = dot<C>(basis[k], image[l]);
            }
        }
        std::vector<Lanes<C>> weight(count, Lanes<C>::Zero());
        for (Eigen::Index c = 0; c < columns; ++c) {
            Eigen::MatrixXd a(size, size);
            Eigen::VectorXd f(size);
            for (Eigen::Index k = 0; k < size; ++k) {
                f[k] = right[static_cast<std::size_t>(k)][c];
                for (Eigen::Index l = 0; l < size; ++l) {
                    a(k, l) = small[static_cast<std::size_t>(k * size + l)][c];
                }
            }
            const Eigen::VectorXd w = a.completeOrthogonalDecomposition().solve(f);
            for (Eigen::Index k = 0; k < size; ++k) {
                weight[static_cast<std::size_t>(k)][c] = w[k];
            }
        }
        for (std::size_t k = 0; k < count; ++k) {
            add<C>(x, weight[k], basis[k]);
            add<C>(r, -weight[k], image[k]);
        }
    }
    z = r;
    factor_.template solve<C>(z);
    Block<C> p = z;
    Lanes<C> rho = dot<C>(r, z);
    const auto wanting = [&]() -> Eigen::Array<bool, 1, C> { return !(rho <= tolerance_ * tolerance_ * dot<C>(x, b)); };
    auto active = wanting();
    int steps = 0;
    while (active.any()) {
        if (steps == too_many_steps) {
            // With its own factor a definite matrix takes few steps.
            if (factor_is_stale_ || !factorize()) {
                return false;
            }
            factor_is_stale_ = true; // until this solve ends
            z = r;
            factor_.template solve<C>(z);
            p = z;
            rho = dot<C>(r, z);
            steps = 0;
        }
        ++steps;
        ++iterations_;
        multiply<C>(p, q);
        const Lanes<C> curvature = dot<C>(p, q);
        if ((active && !(curvature > 0.0)).any()) {
            return false;
        }
        const Lanes<C> length = active.select(rho / curvature, Lanes<C>::Zero());
        add<C>(x, length, p);
        add<C>(r, -length, q);
        z = r;
        factor_.template solve<C>(z);
        const Lanes<C> next = dot<C>(r, z);
        const Lanes<C> keep = active.select(next / rho, Lanes<C>::Zero());
        scale<C>(p, keep);
        p += z;
        rho = next;
        active = wanting();
    }
    factor_is_stale_ = steps > many_steps;
    matrix.middleCols(first, columns) = x.leftCols(columns);
    return x.allFinite();
}

template class SymmetricSystem<float>;
template class SymmetricSystem<double>;

} // namespace pave::fe

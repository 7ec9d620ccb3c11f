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

// Columns of a matrix in lanes, those beyond its end zero.
template <int C>
void load(const Eigen::Ref<const Eigen::MatrixXd>& from, Eigen::Index first, Eigen::Index columns, Block<C>& to) {
    to.setZero(from.rows(), C);
    to.leftCols(columns) = from.middleCols(first, columns);
}

// f(lanes of a block, first column, columns) for the blocks of so many columns, until one is false.
template <class Scalar, class F>
bool in_blocks(Eigen::Index columns, const F& f) {
    bool ok = true;
    for (Eigen::Index first = 0; ok && first < columns;) {
        const Eigen::Index left = columns - first;
        if (left == 1) {
            ok = f(std::integral_constant<int, 1>(), first, left);
            first += 1;
        } else if (left <= 4 && std::is_same_v<Scalar, float>) { // in double precision eight take no more time
            ok = f(std::integral_constant<int, 4>(), first, left);
            first += 4;
        } else {
            ok = f(std::integral_constant<int, 8>(), first, std::min<Eigen::Index>(8, left));
            first += 8;
        }
    }
    return ok;
}

} // namespace

template <class Scalar>
SymmetricSystem<Scalar>::SymmetricSystem(const Pattern& lower, const CholeskyAnalysis& analysis)
    : lower_(lower),
      structure_(analysis.structure()),
      factor_(lower, structure_) {}

template <class Scalar>
void SymmetricSystem<Scalar>::begin(double tolerance, bool constants_hold) {
    tolerance_ = tolerance;
    constants_hold_ = constants_hold;
    is_precise_ = false;
    has_factor_ = false;
    factor_is_stale_ = false;
    factorizations_ = 0;
    iterations_ = 0;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::factorize() {
    const bool is_first = factorizations_ == 0 || !constants_hold_;
    ++factorizations_;
    has_factor_ = !is_precise_ && factor_.factorize(values_, is_first);
    if (std::is_same_v<Scalar, float> && !has_factor_) {
        is_precise_ = true;
        if (!precise_factor_) {
            precise_factor_ = std::make_unique<SupernodalFactor<double>>(lower_, structure_);
        }
        has_factor_ = precise_factor_->factorize(values_, true);
    }
    factor_is_own_ = has_factor_;
    factor_is_stale_ = false;
    return has_factor_;
}

template <class Scalar>
template <int C>
void SymmetricSystem<Scalar>::apply_factor(Block<C>& z) {
    is_precise_ ? precise_factor_->template solve<C>(z) : factor_.template solve<C>(z);
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
    apply_factor<1>(x);
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
Eigen::MatrixXd SymmetricSystem<Scalar>::image(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd y(x.rows(), x.cols());
    in_blocks<Scalar>(x.cols(), [&](auto lanes, Eigen::Index first, Eigen::Index columns) {
        constexpr int C = decltype(lanes)::value;
        Block<C> in;
        Block<C> out;
        load<C>(x, first, columns, in);
        multiply<C>(in, out);
        y.middleCols(first, columns) = out.leftCols(columns);
        return true;
    });
    return y;
}

template <class Scalar>
bool SymmetricSystem<Scalar>::solve(Eigen::Ref<Eigen::MatrixXd> x,
                                    std::span<const Eigen::Map<const Eigen::MatrixXd>> guesses) {
    Eigen::MatrixXd start;
    Eigen::MatrixXd image_of_start;
    if (std::is_same_v<Scalar, float> && !guesses.empty() && !factor_is_own_) {
        // The best combination of the guesses in the energy norm (a Galerkin projection). They lie close to each other:
        // what they do not tell apart beyond rounding is left out.
        Eigen::Index count = 0;
        for (const auto& guess : guesses) {
            count += guess.cols();
        }
        Eigen::MatrixXd basis(x.rows(), count);
        count = 0;
        for (const auto& guess : guesses) {
            basis.middleCols(count, guess.cols()) = guess;
            count += guess.cols();
        }
        const Eigen::MatrixXd images = image(basis);
        Eigen::MatrixXd gram = basis.transpose() * images;
        const Eigen::VectorXd scale =
            (gram.diagonal().array() > 0.0).select(gram.diagonal().array().rsqrt(), Eigen::ArrayXd::Zero(count));
        gram = scale.asDiagonal() * gram * scale.asDiagonal();
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
        const Eigen::ArrayXd values = eigen.eigenvalues().array();
        const Eigen::VectorXd inverse = (values > 1e-12 * values[count - 1]).select(values.inverse(), 0.0);
        // One product at a time: nested ones take Eigen long to compile.
        Eigen::MatrixXd weights = basis.transpose() * x;
        weights = scale.asDiagonal() * weights;
        weights = eigen.eigenvectors().transpose() * weights;
        weights = inverse.asDiagonal() * weights;
        weights = eigen.eigenvectors() * weights;
        weights = scale.asDiagonal() * weights;
        start = basis * weights;
        image_of_start = images * weights;
    }
    return in_blocks<Scalar>(x.cols(), [&](auto lanes, Eigen::Index first, Eigen::Index) {
        return solve_block<decltype(lanes)::value>(x, first, start, image_of_start);
    });
}

template <class Scalar>
template <int C>
bool SymmetricSystem<Scalar>::solve_block(Eigen::Ref<Eigen::MatrixXd> matrix, Eigen::Index first,
                                          const Eigen::MatrixXd& start, const Eigen::MatrixXd& image_of_start) {
    const Eigen::Index n = matrix.rows();
    const Eigen::Index columns = std::min<Eigen::Index>(C, matrix.cols() - first);
    Block<C> b;
    load<C>(matrix, first, columns, b);
    if constexpr (std::is_same_v<Scalar, double>) {
        apply_factor<C>(b);
        matrix.middleCols(first, columns) = b.leftCols(columns);
        return b.allFinite();
    } else {
        Block<C> x = Block<C>::Zero(n, C);
        Block<C> image;
        if (start.cols() > 0) {
            load<C>(start, first, columns, x);
            load<C>(image_of_start, first, columns, image);
        }
        if (!iterate<C>(b, image, x)) {
            return false;
        }
        matrix.middleCols(first, columns) = x.leftCols(columns);
        return x.allFinite();
    }
}

template <class Scalar>
template <int C>
bool SymmetricSystem<Scalar>::iterate(const Block<C>& b, const Block<C>& image, Block<C>& x) {
    Block<C> r = b;
    Block<C> z;
    Block<C> q;
    if (image.rows() > 0) {
        r -= image;
    }
    z = r;
    apply_factor<C>(z);
    Block<C> p = z;
    Lanes<C> rho = dot<C>(r, z);
    const auto wanting = [&]() -> Eigen::Array<bool, 1, C> {
        return !(rho.abs() <= tolerance_ * tolerance_ * dot<C>(x, b));
    };
    auto active = wanting();
    int steps = 0;
    while (active.any()) {
        if (steps == too_many_steps || (active && rho < 0.0).any()) {
            // With its own factor a definite matrix takes few steps, in double precision if not in single.
            if (factor_is_own_ && is_precise_) {
                return false;
            }
            is_precise_ = is_precise_ || factor_is_own_;
            if (!factorize()) {
                return false;
            }
            z = r;
            apply_factor<C>(z);
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
        apply_factor<C>(z);
        const Lanes<C> next = dot<C>(r, z);
        const Lanes<C> keep = active.select(next / rho, Lanes<C>::Zero());
        scale<C>(p, keep);
        p += z;
        rho = next;
        active = wanting();
    }
    factor_is_stale_ = steps > many_steps;
    return true;
}

template class SymmetricSystem<float>;
template class SymmetricSystem<double>;

} // namespace pave::fe

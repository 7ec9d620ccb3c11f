#include "fe/symmetric_system.h"

#include <cmath>

namespace pave::fe {
namespace {

// A solve that takes more steps than this makes the next matrix be factorised; one that takes more than the second, its
// own. A factorisation costs about as much as twenty steps.
constexpr int many_steps = 12;
constexpr int too_many_steps = 30;

} // namespace

SymmetricSystem::SymmetricSystem(const Pattern& lower, const CholeskyAnalysis& analysis, Route route)
    : lower_(lower),
      route_(route),
      cholesky_(lower, analysis) {}

void SymmetricSystem::begin(double tolerance) {
    tolerance_ = tolerance;
    has_factor_ = false;
    factor_is_stale_ = false;
    factorizations_ = 0;
    iterations_ = 0;
}

bool SymmetricSystem::factorize() {
    ++factorizations_;
    has_factor_ = cholesky_.factorize(values_);
    factor_is_stale_ = false;
    return has_factor_;
}

bool SymmetricSystem::set_matrix(std::span<const double> values) {
    values_ = values;
    return route_ == Route::iterative && has_factor_ && !factor_is_stale_ ? true : factorize();
}

void SymmetricSystem::multiply(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::VectorXd> y) const {
    y.setZero();
    for (int j = 0; j < lower_.size; ++j) {
        const int first = lower_.column_start[j]; // the diagonal entry
        const double xj = x[j];
        double sum = values_[first] * xj;
        for (int k = first + 1; k < lower_.column_start[j + 1]; ++k) {
            const int i = lower_.row[k];
            y[i] += values_[k] * xj;
            sum += values_[k] * x[i];
        }
        y[j] += sum;
    }
}

void SymmetricSystem::precondition(Eigen::Ref<Eigen::MatrixXd> x) {
    cholesky_.solve(x.data(), static_cast<int>(x.cols()));
}

bool SymmetricSystem::solve(Eigen::Ref<Eigen::MatrixXd> x, std::span<const Eigen::Map<const Eigen::MatrixXd>> guesses) {
    if (route_ == Route::direct) {
        precondition(x);
        return true;
    }
    const Eigen::Index n = x.rows();
    const Eigen::Index columns = x.cols();
    const Eigen::MatrixXd b = x;
    Eigen::MatrixXd r = b;
    x.setZero();
    if (!guesses.empty()) {
        // The best combination of the guesses in the energy norm (a Galerkin projection).
        const auto count = static_cast<Eigen::Index>(guesses.size());
        Eigen::MatrixXd basis(n, count);
        Eigen::MatrixXd image(n, count);
        for (Eigen::Index c = 0; c < columns; ++c) {
            for (Eigen::Index k = 0; k < count; ++k) {
                basis.col(k) = guesses[static_cast<std::size_t>(k)].col(c);
                // Guesses lie close to each other: orthogonal ones keep the small system well posed.
                for (int pass = 0; pass < 2; ++pass) {
                    for (Eigen::Index l = 0; l < k; ++l) {
                        basis.col(k) -= basis.col(l).dot(basis.col(k)) * basis.col(l);
                    }
                }
                const double norm = basis.col(k).norm();
                const double whole = guesses[static_cast<std::size_t>(k)].col(c).norm();
                basis.col(k) *= norm > 1e-12 * whole && norm > 0.0 ? 1.0 / norm : 0.0;
                multiply(basis.col(k), image.col(k));
            }
            const Eigen::MatrixXd small = basis.transpose() * image;
            const Eigen::VectorXd weights = small.completeOrthogonalDecomposition().solve(basis.transpose() * b.col(c));
            x.col(c) = basis * weights;
            r.col(c) -= image * weights;
        }
    }
    Eigen::MatrixXd z = r;
    precondition(z);
    Eigen::MatrixXd p = z;
    Eigen::VectorXd q(n);
    Eigen::VectorXd rho(columns);
    std::vector<bool> active(static_cast<std::size_t>(columns));
    const auto any_active = [&] {
        bool any = false;
        for (Eigen::Index c = 0; c < columns; ++c) {
            rho[c] = r.col(c).dot(z.col(c));
            active[static_cast<std::size_t>(c)] = !(rho[c] <= tolerance_ * tolerance_ * x.col(c).dot(b.col(c)));
            any = any || active[static_cast<std::size_t>(c)];
        }
        return any;
    };
    int steps = 0;
    while (any_active()) {
        if (steps == too_many_steps && factor_is_stale_) {
            return false; // with its own factor a definite matrix takes one or two steps
        }
        if (steps == too_many_steps) {
            if (!factorize()) {
                return false;
            }
            factor_is_stale_ = true; // until this solve ends
            z = r;
            precondition(z);
            p = z;
            steps = 0;
            continue;
        }
        ++steps;
        ++iterations_;
        Eigen::VectorXd old = rho;
        for (Eigen::Index c = 0; c < columns; ++c) {
            if (!active[static_cast<std::size_t>(c)]) {
                continue;
            }
            multiply(p.col(c), q);
            const double curvature = p.col(c).dot(q);
            if (!(curvature > 0.0)) {
                return false;
            }
            const double length = rho[c] / curvature;
            x.col(c) += length * p.col(c);
            r.col(c) -= length * q;
        }
        z = r;
        precondition(z);
        for (Eigen::Index c = 0; c < columns; ++c) {
            if (active[static_cast<std::size_t>(c)]) {
                p.col(c) = z.col(c) + (r.col(c).dot(z.col(c)) / old[c]) * p.col(c);
            }
        }
    }
    factor_is_stale_ = steps > many_steps;
    return x.allFinite();
}

} // namespace pave::fe

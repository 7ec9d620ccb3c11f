#include "problem/misfit.h"

#include "problem/censored.h"
#include "problem/student.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace explore::problem {
namespace {

double correlation(const Misfit::Term& a, const Misfit::Term& b) {
    const double own = a.noise.own_deviation(a.measured) * b.noise.own_deviation(b.measured) *
                       data::own_correlation(a.place, b.place, a.noise.correlation_length, a.noise.correlation_time);
    const double common = a.noise.common_relative * a.measured * b.noise.common_relative * b.measured;
    const double drift = data::is_one_sensor(a.place, b.place) ? a.noise.drift * b.noise.drift : 0.0;
    return (own + common + drift) / (a.noise.deviation(a.measured) * b.noise.deviation(b.measured));
}

} // namespace

Misfit::Misfit(MisfitKind kind, std::vector<Term> terms) : kind_(kind), terms_(std::move(terms)) {
    if (kind_ != MisfitKind::noise) {
        return;
    }
    std::map<int, std::vector<Eigen::Index>> loads;
    for (std::size_t i = 0; i < terms_.size(); ++i) {
        const Term& t = terms_[i];
        const data::Noise& n = t.noise;
        if (t.place.load >= 0 &&
            (n.common_relative > 0.0 || n.correlation_length > 0.0 || n.correlation_time > 0.0 || n.drift != 0.0)) {
            loads[t.place.load].push_back(static_cast<Eigen::Index>(i));
        }
    }
    for (auto& [load, rows] : loads) {
        const auto n = static_cast<Eigen::Index>(rows.size());
        Eigen::MatrixXd r = Eigen::MatrixXd::Identity(n, n);
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index j = 0; j < i; ++j) {
                r(i, j) = r(j, i) = correlation(terms_[static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])],
                                                terms_[static_cast<std::size_t>(rows[static_cast<std::size_t>(j)])]);
            }
        }
        const Eigen::LLT<Eigen::MatrixXd> cholesky(r);
        if (cholesky.info() != Eigen::Success) {
            throw std::invalid_argument("the correlation matrix of the noise is not positive definite");
        }
        blocks_.push_back({std::move(rows), cholesky.matrixL()});
    }
}

Eigen::MatrixXd Misfit::whitened(Eigen::MatrixXd rows) const {
    const auto factor = [&](Eigen::Index i) { return terms_[static_cast<std::size_t>(i)].factor; };
    for (const Block& block : blocks_) {
        Eigen::MatrixXd part = rows(block.rows, Eigen::all);
        for (Eigen::Index k = 0; k < part.rows(); ++k) {
            part.row(k) /= factor(block.rows[static_cast<std::size_t>(k)]);
        }
        block.factor.triangularView<Eigen::Lower>().solveInPlace(part);
        for (Eigen::Index k = 0; k < part.rows(); ++k) {
            part.row(k) *= factor(block.rows[static_cast<std::size_t>(k)]);
        }
        rows(block.rows, Eigen::all) = part;
    }
    return rows;
}

double Misfit::log_normaliser() const {
    double sum = 0.0;
    for (const Term& t : terms_) {
        if (t.censored != data::Censored::no) { // a probability, and no density
            continue;
        }
        sum += std::log(t.noise.slope(t.measured, t.measured)) +
               (is_student() ? student_log_peak(t.noise.degrees) : -0.5 * std::log(2.0 * std::numbers::pi));
    }
    for (const Block& block : blocks_) {
        sum -= block.factor.diagonal().array().log().sum();
    }
    return sum;
}

std::vector<Misfit::Drift> Misfit::drifts(std::span<const double> responses) const {
    std::vector<Drift> drifts;
    const Eigen::VectorXd single = single_residuals(responses);
    for (const Block& block : blocks_) {
        const auto term = [&](std::size_t k) -> const Term& { return terms_[static_cast<std::size_t>(block.rows[k])]; };
        std::vector<char> seen(block.rows.size(), 0);
        for (std::size_t first = 0; first < block.rows.size(); ++first) {
            if (seen[first] != 0 || term(first).noise.drift == 0.0) {
                continue;
            }
            Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(block.rows.size()));
            Eigen::VectorXd errors = change; // measured less model
            for (std::size_t k = 0; k < block.rows.size(); ++k) {
                const Term& t = term(k);
                const auto row = static_cast<Eigen::Index>(k);
                errors[row] = -single[block.rows[k]] / t.factor;
                if (data::is_one_sensor(t.place, term(first).place)) {
                    seen[k] = 1;
                    change[row] = t.noise.drift / t.noise.deviation(t.measured);
                }
            }
            block.factor.triangularView<Eigen::Lower>().solveInPlace(change);
            block.factor.triangularView<Eigen::Lower>().solveInPlace(errors);
            drifts.push_back({.term = static_cast<std::size_t>(block.rows[first]),
                              .mean = change.dot(errors),
                              .deviation = std::sqrt(std::max(0.0, 1.0 - change.squaredNorm()))});
        }
    }
    return drifts;
}

Eigen::VectorXd Misfit::residuals(std::span<const double> responses) const {
    Eigen::VectorXd r = single_residuals(responses);
    if (is_correlated()) {
        r = whitened(r);
    }
    for (std::size_t i = 0; is_student() && i < size(); ++i) {
        double& value = r[static_cast<Eigen::Index>(i)];
        const Term& t = terms_[i];
        value = t.factor * student_row(value / t.factor, t.noise.degrees);
    }
    for (std::size_t i = 0; i < size(); ++i) {
        if (const Term& t = terms_[i]; t.censored != data::Censored::no) {
            double& value = r[static_cast<Eigen::Index>(i)];
            value = t.factor * censored_row(value / t.factor, t.censored);
        }
    }
    return r;
}

Eigen::VectorXd Misfit::standard_residuals(std::span<const double> responses) const {
    Eigen::VectorXd z = whitened(single_residuals(responses));
    for (std::size_t i = 0; i < size(); ++i) {
        z[static_cast<Eigen::Index>(i)] /= terms_[i].factor;
    }
    return z;
}

Eigen::VectorXd Misfit::loss_slopes(std::span<const double> responses) const {
    Eigen::VectorXd slope = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(size()));
    if (!is_student() && censored() == 0) {
        return slope;
    }
    const Eigen::VectorXd z = standard_residuals(responses);
    for (std::size_t i = 0; i < size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        if (is_student()) {
            slope[row] = student_row_slope(z[row], terms_[i].noise.degrees);
        } else if (terms_[i].censored != data::Censored::no) {
            slope[row] = censored_row_slope(z[row], terms_[i].censored);
        }
    }
    return slope;
}

Eigen::VectorXd Misfit::loss_information(std::span<const double> responses) const {
    const double each = is_student() ? std::sqrt(student_information(terms_[0].noise.degrees)) : 1.0;
    Eigen::VectorXd root = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(size()), each);
    if (censored() > 0) {
        const Eigen::VectorXd z = standard_residuals(responses);
        for (std::size_t i = 0; i < size(); ++i) {
            if (terms_[i].censored != data::Censored::no) {
                const auto row = static_cast<Eigen::Index>(i);
                root[row] = std::sqrt(censored_information(z[row], terms_[i].censored));
            }
        }
    }
    return root;
}

std::size_t Misfit::censored() const {
    return static_cast<std::size_t>(
        std::count_if(terms_.begin(), terms_.end(), [](const Term& t) { return t.censored != data::Censored::no; }));
}

Eigen::VectorXd Misfit::single_residuals(std::span<const double> responses) const {
    Eigen::VectorXd r(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        const Term& t = terms_[i];
        const double model = responses[t.response];
        double& value = r[static_cast<Eigen::Index>(i)];
        switch (kind_) {
        case MisfitKind::log:
            value = std::asinh(model / (2.0 * t.scale)) - std::asinh(t.measured / (2.0 * t.scale));
            break;
        case MisfitKind::noise: value = t.noise.residual(model, t.measured); break;
        default: value = (model - t.measured) / t.scale;
        }
        value *= t.factor;
    }
    return r;
}

Eigen::VectorXd Misfit::slopes(std::span<const double> responses) const {
    Eigen::VectorXd d(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        const Term& t = terms_[i];
        double& value = d[static_cast<Eigen::Index>(i)];
        switch (kind_) {
        case MisfitKind::log: value = 1.0 / std::hypot(responses[t.response], 2.0 * t.scale); break;
        case MisfitKind::noise: value = t.noise.slope(responses[t.response], t.measured); break;
        default: value = 1.0 / t.scale;
        }
        value *= t.factor;
    }
    return d;
}

} // namespace explore::problem

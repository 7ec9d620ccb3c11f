#include "problem/misfit.h"

#include <cmath>

namespace explore::problem {

Eigen::VectorXd Misfit::residuals(std::span<const double> responses) const {
    Eigen::VectorXd r(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        const Term& t = terms_[i];
        const double model = responses[t.response];
        r[static_cast<Eigen::Index>(i)] =
            t.factor * (kind_ == MisfitKind::log
                            ? std::asinh(model / (2.0 * t.scale)) - std::asinh(t.measured / (2.0 * t.scale))
                            : (model - t.measured) / t.scale);
    }
    return r;
}

Eigen::VectorXd Misfit::slopes(std::span<const double> responses) const {
    Eigen::VectorXd d(static_cast<Eigen::Index>(size()));
    for (std::size_t i = 0; i < size(); ++i) {
        const Term& t = terms_[i];
        d[static_cast<Eigen::Index>(i)] =
            t.factor *
            (kind_ == MisfitKind::log ? 1.0 / std::hypot(responses[t.response], 2.0 * t.scale) : 1.0 / t.scale);
    }
    return d;
}

} // namespace explore::problem

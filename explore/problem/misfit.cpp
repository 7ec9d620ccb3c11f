#include "problem/misfit.h"

#include <cmath>

namespace explore::problem {

Eigen::VectorXd Misfit::residuals(std::span<const double> responses) const {
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

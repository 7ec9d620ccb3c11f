#include "blind/strength.h"

#include "base/units.h"
#include "pavement/effects/catalog.h"
#include "pavement/parameter.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <gsl/gsl_cdf.h>
#include <set>

namespace blind {

Errors errors_of(const Case& c, const VectorXd& own, const VectorXd& common) {
    Eigen::MatrixXd covariance = own.cwiseAbs2().asDiagonal();
    for (Eigen::Index i = 0; i < own.size() && common.any(); ++i) {
        for (Eigen::Index k = 0; k < own.size(); ++k) {
            const Sensor& a = c.sensors[static_cast<std::size_t>(i)];
            const Sensor& b = c.sensors[static_cast<std::size_t>(k)];
            if (a.load == b.load) {
                const double apart = std::hypot(a.x - b.x, a.depth - b.depth) / unit::mm;
                covariance(i, k) =
                    common[i] * common[k] +
                    (a.quantity == b.quantity ? own[i] * own[k] * std::exp(-apart / correlated_mm) : 0.0);
            }
        }
    }
    return {covariance.llt().matrixL()};
}

Eigen::MatrixXd derivatives(const Case& c, const Errors& errors) {
    Eigen::MatrixXd j(errors.size(), static_cast<Eigen::Index>(std::size(fitted)));
    constexpr double step = 0.01;
    for (std::size_t k = 0; k < std::size(fitted); ++k) {
        const Parameter p = find_parameter(c, fitted[k].path, {});
        Case up = c;
        Case down = c;
        p.in(up) *= 1.0 + step;
        p.in(down) /= 1.0 + step;
        const VectorXd above = responses(up);
        const VectorXd below = responses(down);
        if (above.size() == 0 || below.size() == 0) {
            return {};
        }
        j.col(static_cast<Eigen::Index>(k)) = errors.in_units(above - below) / (2.0 * std::log1p(step));
    }
    return j;
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
    return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.cols());
}

VectorXd beyond(const Eigen::MatrixXd& base, const VectorXd& change) {
    return change - base * (base.transpose() * change);
}

double remaining(const Case& c, const VectorXd& plain, const VectorXd& change, const Errors& errors) {
    Case at = c;
    VectorXd left = change;
    for (int iteration = 0; iteration < 5; ++iteration) {
        const Eigen::MatrixXd j = derivatives(at, errors);
        if (j.size() == 0) {
            break;
        }
        VectorXd step = (j.transpose() * j + 1e-3 * Eigen::MatrixXd::Identity(j.cols(), j.cols()))
                            .ldlt()
                            .solve(j.transpose() * left);
        bool better = false;
        for (int half = 0; half < 5 && !better; ++half, step *= 0.5) {
            Case next = at;
            for (std::size_t k = 0; k < std::size(fitted); ++k) {
                const Parameter p = find_parameter(c, fitted[k].path, {});
                const double value = p.get(next) * std::exp(std::clamp(step[static_cast<Eigen::Index>(k)], -1.0, 1.0));
                p.in(next) = std::clamp(value, fitted[k].low, fitted[k].high) * p.to_si;
            }
            const VectorXd there = responses(next);
            if (there.size() == plain.size()) {
                const VectorXd now = change - errors.in_units(there - plain);
                if (now.norm() < left.norm()) {
                    better = true;
                    at = next;
                    left = now;
                }
            }
        }
        if (!better) {
            break;
        }
    }
    return left.norm();
}

void add_ceiling(Json& truth, const Case& c, const Hidden& hidden, const VectorXd& change, double d,
                 const Eigen::MatrixXd& base, const Errors& errors) {
    double lowest = 1.0;
    std::string hardest;
    const auto compare = [&](const std::string& name, const VectorXd& other, bool both_signs) {
        if (other.norm() < 1e-6 * d) {
            return;
        }
        double cosine = change.dot(other) / (change.norm() * other.norm());
        cosine = both_signs ? std::abs(cosine) : cosine;
        const double rate = gsl_cdf_ugaussian_P(d * std::sqrt(std::max(0.0, (1.0 - cosine) / 2.0)));
        if (rate < lowest) {
            lowest = rate;
            hardest = name;
        }
    };
    const VectorXd plain = responses(c);
    for (const Effect* effect : effects()) {
        if (effect == hidden.effect) {
            continue;
        }
        std::vector<AppliedEffect> ways{{}};
        if (effect == find_effect("outlier")) {
            for (Eigen::Index i = 0; i < errors.size(); ++i) {
                compare(std::string(effect->name),
                        beyond(base, errors.in_units(errors.root(i, i) * VectorXd::Unit(errors.size(), i))), true);
            }
            continue;
        }
        if (effect->takes_reading && !effect->takes_quantity) {
            for (int reading = 0; reading < static_cast<int>(c.sensors.size()); ++reading) {
                ways.push_back({.reading = reading});
            }
        } else if (effect->takes_quantity) { // of one instrument: only where it is read over time
            std::set<std::pair<int, Quantity>> groups;
            for (const Sensor& s : c.sensors) {
                groups.emplace(s.load, s.quantity);
            }
            for (const auto& [load, quantity] : groups) {
                ways.push_back({.load = load, .quantity = quantity});
                ways.push_back({.quantity = quantity});
            }
        } else if (effect->takes_load) {
            for (int load = 0; load < static_cast<int>(c.loads.size()); ++load) {
                ways.push_back({.load = load});
            }
        }
        for (AppliedEffect way : ways) {
            way.effect = effect;
            if (!why_impossible(c, way).empty()) {
                continue;
            }
            Case with = c;
            with.effects = {way};
            with.effects[0].size = effect->log_scale ? std::exp(0.3 * std::log(effect->typical))
                                                     : effect->null + 0.5 * (effect->typical - effect->null);
            const VectorXd there = responses(with);
            if (there.size() == plain.size()) {
                compare(std::string(effect->name), beyond(base, errors.in_units(there - plain)),
                        effect->null > effect->low && effect->null < effect->high);
            }
        }
    }
    truth["ceiling"] = lowest;
    truth["hardest"] = hardest;
}

std::optional<Hidden> sized(Draw& draw, const Case& c, Hidden hidden, const VectorXd& plain,
                            const Eigen::MatrixXd& base, const Errors& errors, double wanted) {
    Effect own{};
    own.high = hidden.outside != nullptr ? hidden.outside->most : 0.0;
    const Effect& effect = hidden.outside != nullptr ? own : *hidden.effect;
    const bool up_only = effect.null <= effect.low;
    const bool down_only = effect.null >= effect.high;
    const double side = up_only ? 1.0 : down_only ? -1.0 : draw.chance(0.5) ? 1.0 : -1.0;
    const auto size_at = [&](double share) { // 0 null, 1 the end of the range
        const double end = side > 0.0 ? effect.high : effect.low;
        return effect.log_scale ? std::exp(std::log(effect.null) + share * (std::log(end) - std::log(effect.null)))
                                : effect.null + share * (end - effect.null);
    };
    const auto strength = [&](double share) {
        hidden.size = size_at(share);
        const VectorXd there = responses_with(c, {hidden});
        return there.size() == plain.size() ? beyond(base, errors.in_units(there - plain)).norm() : -1.0;
    };
    double low = 0.0;
    for (const double high : {0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9}) {
        const double found = strength(high);
        if (found < 0.0) {
            return std::nullopt;
        }
        if (found >= wanted) {
            double a = low;
            double b = high;
            for (int i = 0; i < 6; ++i) {
                const double middle = 0.5 * (a + b);
                (strength(middle) >= wanted ? b : a) = middle;
            }
            hidden.size = size_at(b);
            return hidden;
        }
        low = high;
    }
    return std::nullopt;
}

} // namespace blind

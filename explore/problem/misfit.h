// The distance between responses and measurements: residuals whose root of the sum of squares is the misfit f.
#pragma once

#include "data/noise.h"

#include <Eigen/Dense>
#include <span>
#include <string_view>
#include <vector>

namespace explore::problem {

enum class MisfitKind {
    log,      // g(model) - g(measured), g(v) = asinh(v / (2 s)): the logarithm where |v| >> s, odd and monotone
    relative, // (model - measured) / |measured|
    weighted, // (model - measured) / scale
    noise     // in standard deviations of the stated noise (data/noise.h)
};
// What a study may choose.
inline constexpr std::string_view misfit_names[] = {"log", "relative", "weighted"};
constexpr std::string_view to_string(MisfitKind kind) {
    return kind == MisfitKind::noise ? "noise" : misfit_names[static_cast<int>(kind)];
}

class Misfit {
public:
    // One residual: which response it compares with what.
    struct Term {
        std::size_t response = 0; // index of the response
        double measured = 0.0;    // SI
        double scale = 1.0;       // s for log, |measured| for relative, sigma for weighted
        double factor = 1.0; // of the residual: the square root of its weight; shapes the fit, says nothing of noise
        data::Noise noise{};
    };
    Misfit(MisfitKind kind, std::vector<Term> terms) : kind_(kind), terms_(std::move(terms)) {}

    std::size_t size() const { return terms_.size(); }
    MisfitKind kind() const { return kind_; }
    std::span<const Term> terms() const { return terms_; }

    Eigen::VectorXd residuals(std::span<const double> responses) const;
    // d(residual i)/d(its response).
    Eigen::VectorXd slopes(std::span<const double> responses) const;

private:
    MisfitKind kind_;
    std::vector<Term> terms_;
};

} // namespace explore::problem

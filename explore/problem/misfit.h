// The distance between responses and measurements: residuals whose root of the sum of squares is the misfit f.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <string_view>
#include <vector>

namespace explore::problem {

enum class MisfitKind {
    log,      // g(model) - g(measured), g(v) = asinh(v / (2 s)): the logarithm where |v| >> s, odd and monotone
    relative, // (model - measured) / |measured|
    weighted  // (model - measured) / sigma
};
inline constexpr std::string_view misfit_names[] = {"log", "relative", "weighted"};
constexpr std::string_view to_string(MisfitKind kind) {
    return misfit_names[static_cast<int>(kind)];
}

class Misfit {
public:
    // measured: SI values; scale of each: s for log, |measured| for relative, sigma for weighted.
    Misfit(MisfitKind kind, std::vector<double> measured, std::vector<double> scale);

    std::size_t size() const { return measured_.size(); }
    MisfitKind kind() const { return kind_; }
    std::span<const double> measured() const { return measured_; }

    // Residuals of the first size() responses.
    Eigen::VectorXd residuals(std::span<const double> responses) const;
    // d(residual i)/d(response i).
    Eigen::VectorXd slopes(std::span<const double> responses) const;

private:
    MisfitKind kind_;
    std::vector<double> measured_;
    std::vector<double> scale_;
};

} // namespace explore::problem

// Shared by laws of the modulus E(theta, tau) of a cross-anisotropic layer: the directions, the smooth floor thp of
// theta. A law gives E(thp, tau) and its derivatives.
#pragma once

#include "material/law.h"
#include "mechanics/cross_anisotropic.h"

#include <memory>
#include <numbers>

namespace pave::material {

// sigma1 - sigma3 of a triaxial test over the octahedral shear stress.
inline constexpr double deviator_over_tau = 3.0 / std::numbers::sqrt2;

// Rows that laws of theta share: k1 and k2 (range: its usual bounds), Poisson's ratios, the floor of theta.
ParameterInfo scale_info(std::string_view meaning);
ParameterInfo confinement_info(UsualRange range);
ParameterInfo poisson_12_info();
ParameterInfo poisson_31_info();
ParameterInfo tension_smoothing_info();

// The same of what makes a layer cross-anisotropic: modulus_axis, and n, poisson_12, poisson_31, shear_ratio in this
// order; n without a default must be given.
ParameterInfo modulus_axis_info();
std::vector<ParameterInfo> direction_infos(std::optional<double> default_n);
inline constexpr mechanics::CrossAnisotropy::Variable direction_variables[] = {
    mechanics::CrossAnisotropy::Variable::n, mechanics::CrossAnisotropy::Variable::nu12,
    mechanics::CrossAnisotropy::Variable::nu31, mechanics::CrossAnisotropy::Variable::shear_ratio};
// Of the values of those rows.
mechanics::CrossAnisotropy cross_anisotropy(double modulus_axis, std::span<const double> directions);

class StressDependent : public Law {
public:
    std::span<const ParameterInfo> parameters() const final { return infos_; }
    bool stress_dependent() const final { return true; }
    std::span<const std::size_t> scale_parameters() const override;

    Modulus modulus(std::span<const double> p, mechanics::Invariants at) const final;
    double modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus& here,
                              std::size_t i) const final;
    mechanics::Stiffness<6> unit_stiffness(std::span<const double> p, mechanics::Invariants at) const final;
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants at,
                                                      std::size_t i) const final;
    std::string impossible(std::span<const double> p) const override;

protected:
    static constexpr std::size_t first = 1; // of the law's own parameters, after modulus_axis

    // own: the law's parameters; E is proportional to the first, unless the law says otherwise (scale_parameters).
    // isotropic: n and Poisson's ratios have defaults.
    explicit StressDependent(std::vector<ParameterInfo> own, std::optional<double> default_n = {});

    struct Terms {
        double value = 0.0; // E [Pa]
        double d_thp = 0.0;
        double d_tau = 0.0;
    };
    // p: the law's own parameters. thp > 0, tau >= 0 [Pa].
    virtual Terms terms(std::span<const double> p, double thp, double tau) const = 0;
    // dE/dp[i]; value: E there.
    virtual double own_derivative(std::span<const double> p, double thp, double tau, double value,
                                  std::size_t i) const = 0;

private:
    enum Common : std::size_t { n, poisson_12, poisson_31, shear_ratio, delta, eta, common };

    std::size_t place(Common which) const { return first + own_ + which; }
    std::span<const double> own(std::span<const double> p) const { return p.subspan(first, own_); }

    std::size_t own_;
    std::vector<ParameterInfo> infos_;
};

} // namespace pave::material

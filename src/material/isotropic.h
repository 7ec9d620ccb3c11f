// Shared by isotropic laws: a unit stiffness of Poisson's ratio alone.
#pragma once

#include "material/law.h"
#include "mechanics/cross_anisotropic.h"

namespace pave::material {

class Isotropic : public Law {
public:
    mechanics::Stiffness<6> unit_stiffness(std::span<const double> p, mechanics::Invariants) const final {
        return mechanics::CrossAnisotropy::isotropic(p[poisson_]).unit_stiffness();
    }
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants,
                                                      std::size_t i) const final {
        return i == poisson_ ? mechanics::CrossAnisotropy::isotropic_derivative(p[poisson_])
                             : mechanics::Stiffness<6>::Zero();
    }
    std::string impossible(std::span<const double> p) const override {
        return mechanics::CrossAnisotropy::isotropic(p[poisson_]).impossible();
    }

protected:
    // poisson: index of Poisson's ratio among the parameters.
    explicit Isotropic(std::size_t poisson) : poisson_(poisson) {}

private:
    std::size_t poisson_;
};

// Those whose modulus is a number.
class IsotropicLinear : public Isotropic {
public:
    bool stress_dependent() const final { return false; }
    std::span<const std::size_t> scale_parameters() const final { return {&modulus_, 1}; }
    Modulus modulus(std::span<const double> p, mechanics::Invariants) const final { return {.value = p[modulus_]}; }
    double modulus_derivative(std::span<const double>, mechanics::Invariants, const Modulus&,
                              std::size_t i) const final {
        return i == modulus_ ? 1.0 : 0.0;
    }

protected:
    // modulus, poisson: indices of parameters.
    IsotropicLinear(std::size_t modulus, std::size_t poisson) : Isotropic(poisson), modulus_(modulus) {}

private:
    std::size_t modulus_;
};

} // namespace pave::material

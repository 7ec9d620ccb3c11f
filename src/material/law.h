// A material law: a stateless description of its parameters and of the modulus as a function of stress.
//
// The stiffness of a layer is D = E(theta, tau) C, with C the dimensionless cross-anisotropic stiffness, which of most
// laws is the same at any stress. A law is one
// file with one object, named in one line of catalog.cpp; every law is tested from there.
#pragma once

#include "mechanics/voigt.h"

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pave::material {

// The range of a parameter when nothing else is known of the material, in file units.
struct UsualRange {
    double low = 0.0, high = 0.0;
    double start = 0.0;
    bool log = false; // by equal ratios
};

// The modulus is in proportion to (stress/pa + offset)^parameter, pa = 100 kPa.
struct StressPower {
    std::string_view stress; // "theta", "tau", "deviator"
    double offset = 0.0;     // 0 or 1
};

// One number (or choice) of a law as it stands in a study file.
struct ParameterInfo {
    std::string_view key; // with its unit: "modulus_MPa"
    double to_si = 1.0;   // SI value = to_si * file value
    double low = 0.0;     // in file units; outside [low, high] is refused
    double high = 0.0;
    bool low_is_open = false;            // low itself is refused too
    std::optional<double> default_value; // in file units; NaN = "derived from the others"; none = must be given
    std::string_view meaning;
    std::vector<std::string_view> choices; // words instead of a number: the value is the index of the word
    std::optional<UsualRange> usual{};     // of what a fit of the law varies
    std::optional<StressPower> power{};    // of an exponent
    std::string_view alias{};              // what laws with other parameters call the same number
};

// Value of an optional parameter that is not given.
inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

// The modulus never exceeds this (100,000 MPa).
inline constexpr double modulus_limit = 1e11; // Pa

struct Modulus {
    double value = 0.0;   // Pa
    double d_theta = 0.0; // dE/dtheta [-]
    double d_tau = 0.0;   // dE/dtau [-]
    bool limited = false; // the limit was met; derivatives are zero there
};

// Derivatives of C [1/Pa].
struct UnitGradient {
    mechanics::Stiffness<6> d_theta = mechanics::Stiffness<6>::Zero();
    mechanics::Stiffness<6> d_tau = mechanics::Stiffness<6>::Zero();
};

// Of a law whose strain is a function of the stress, the gradient of a complementary energy: with A = C^-1 and
// Q = stress : A : stress, the whole stress,
//     energy = Psi(Q),   strain = A stress / E(Q),   1/E = 2 dPsi/dQ.
// E is the secant modulus from no stress at all; the tangent compliance is (A - h A stress (x) A stress)/E with the
// hardening h = 2 d(ln E)/dQ, positive definite as long as h Q < 1.
class Energy {
public:
    struct Secant {
        double value = 0.0;       // E [Pa]
        double hardening = 0.0;   // [1/Pa2]
        double d_hardening = 0.0; // by Q [1/Pa4]
        bool limited = false;     // the modulus limit was met; the rest is zero there
    };
    struct SecantRate {
        double value = 0.0;
        double hardening = 0.0;
    };

    // p: SI values in the order of the law's parameters(). q: Q [Pa2].
    virtual Secant secant(std::span<const double> p, double q) const = 0;
    // By p[i] at held Q. here: secant(p, q).
    virtual SecantRate secant_rate(std::span<const double> p, double q, const Secant& here, std::size_t i) const = 0;
    // Q where strain : C : strain is this.
    virtual double stress_square(std::span<const double> p, double strain_square) const = 0;
    // Psi [Pa], zero without stress.
    virtual double complementary(std::span<const double> p, double q) const = 0;

protected:
    ~Energy() = default;
};

// One term of a Prony series: a share of the modulus that fades away with a time of relaxation.
struct Relaxation {
    double share = 0.0; // of the modulus that the law gives, which is then the instantaneous one
    double time = 0.0;  // s
};

class Law {
public:
    virtual ~Law() = default;

    virtual std::string_view name() const = 0;
    virtual std::string_view summary() const = 0;
    virtual std::span<const ParameterInfo> parameters() const = 0;

    // False: E depends on the parameters only, and the layer is linear elastic.
    virtual bool stress_dependent() const = 0;

    // Indices of the parameters that E is proportional to, all together.
    virtual std::span<const std::size_t> scale_parameters() const = 0;

    // E at a stress state. p: SI values in the order of parameters().
    virtual Modulus modulus(std::span<const double> p, mechanics::Invariants at) const = 0;
    // dE/dp[i] [SI] at the same state, i an index into parameters(); 0 where E does not depend on it. here: modulus(p,
    // at).
    virtual double modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus& here,
                                      std::size_t i) const = 0;

    // C at a stress state and dC/dp[i] there: the same at all of them, unless the law turns.
    virtual mechanics::Stiffness<6> unit_stiffness(std::span<const double> p, mechanics::Invariants at) const = 0;
    virtual mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants at,
                                                              std::size_t i) const = 0;
    // Whether C follows the stress, and how.
    virtual bool turns() const { return false; }
    virtual UnitGradient unit_stiffness_gradient(std::span<const double> p, mechanics::Invariants at) const;

    // Of a linear law whose stress fades under a held strain: D(t) = E C (1 - sum of share_i (1 - exp(-t/time_i))), and
    // the rates of shares and times by p[i]. None: it does not.
    virtual std::vector<Relaxation> relaxation(std::span<const double> p) const;
    virtual std::vector<Relaxation> relaxation_derivative(std::span<const double> p, std::size_t i) const;
    // Whether there may be such terms.
    virtual bool relaxes() const { return false; }

    // Of a law whose strain derives from one: what its modulus depends on then is the whole stress, and modulus() is
    // that of triaxial compression at the same theta and tau. None: the law gives moduli along a path.
    virtual const Energy* energy() const { return nullptr; }

    // Why these parameters cannot be a material (thermodynamic bounds), or "".
    virtual std::string impossible(std::span<const double> p) const = 0;

    // Index of a key in parameters().
    std::optional<std::size_t> index_of(std::string_view key) const;
};

} // namespace pave::material

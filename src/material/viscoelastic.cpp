#include "material/viscoelastic.h"

#include "base/units.h"
#include "material/isotropic.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::material {
namespace {

constexpr std::size_t terms = 4;
enum : std::size_t { modulus_MPa, poisson, temperature, reference, activation, g1, tau1 };
constexpr std::size_t share_of(std::size_t term) {
    return g1 + 2 * term;
}
constexpr std::size_t time_of(std::size_t term) {
    return tau1 + 2 * term;
}

constexpr double gas_constant = 8.314462618; // J/(mol K)
constexpr double zero_celsius = 273.15;      // K

double inverse_kelvin(double celsius) {
    return 1.0 / (celsius + zero_celsius);
}
double shift(std::span<const double> p) {
    return std::exp(p[activation] / gas_constant * (inverse_kelvin(p[temperature]) - inverse_kelvin(p[reference])));
}

class Viscoelastic final : public IsotropicLinear {
public:
    Viscoelastic() : IsotropicLinear(modulus_MPa, poisson) {}
    std::string_view name() const override { return "viscoelastic"; }
    std::string_view summary() const override {
        return "isotropic linear viscoelasticity: a Prony series, shifted by the temperature";
    }
    std::span<const ParameterInfo> parameters() const override {
        static const ParameterInfo infos[] = {
            {"modulus_MPa",
             unit::MPa,
             0.0,
             1e6,
             true,
             {},
             "instantaneous Young's modulus",
             {},
             UsualRange{3000.0, 40000.0, 15000.0, true}},
            {"poisson", 1.0, -0.99, 0.4999, false, {}, "Poisson's ratio, of all times", {}, {}, {}, "poisson_31"},
            {"temperature_C", 1.0, -60.0, 120.0, false, 20.0, "temperature of the layer", {}},
            {"reference_C",
             1.0,
             -60.0,
             120.0,
             false,
             20.0,
             "temperature that the times of relaxation are given for",
             {}},
            {"activation_kJ_mol",
             1e3,
             0.0,
             1e4,
             false,
             261.0,
             "activation energy: the times are longer by exp(H/R (1/T - 1/T0))",
             {}},
            {"g1",
             1.0,
             0.0,
             1.0,
             false,
             {},
             "share of the modulus that fades with tau1_s",
             {},
             UsualRange{0, 0.9, 0.3}},
            {"tau1_s", 1.0, 0.0, 1e9, true, {}, "time of relaxation", {}, UsualRange{1e-4, 1.0, 0.01, true}},
            {"g2", 1.0, 0.0, 1.0, false, 0.0, "share that fades with tau2_s", {}},
            {"tau2_s", 1.0, 0.0, 1e9, true, 0.1, "time of relaxation", {}},
            {"g3", 1.0, 0.0, 1.0, false, 0.0, "share that fades with tau3_s", {}},
            {"tau3_s", 1.0, 0.0, 1e9, true, 1.0, "time of relaxation", {}},
            {"g4", 1.0, 0.0, 1.0, false, 0.0, "share that fades with tau4_s", {}},
            {"tau4_s", 1.0, 0.0, 1e9, true, 10.0, "time of relaxation", {}},
        };
        return infos;
    }
    bool relaxes() const override { return true; }
    std::vector<Relaxation> relaxation(std::span<const double> p) const override {
        const double longer = shift(p);
        std::vector<Relaxation> series;
        for (std::size_t i = 0; i < terms; ++i) {
            series.push_back({.share = p[share_of(i)], .time = longer * p[time_of(i)]});
        }
        return series;
    }
    std::vector<Relaxation> relaxation_derivative(std::span<const double> p, std::size_t i) const override {
        const double longer = shift(p);
        double d_log_shift = 0.0;
        const double per_kelvin = p[activation] / gas_constant;
        if (i == temperature) {
            d_log_shift = -per_kelvin * inverse_kelvin(p[temperature]) * inverse_kelvin(p[temperature]);
        } else if (i == reference) {
            d_log_shift = per_kelvin * inverse_kelvin(p[reference]) * inverse_kelvin(p[reference]);
        } else if (i == activation) {
            d_log_shift = (inverse_kelvin(p[temperature]) - inverse_kelvin(p[reference])) / gas_constant;
        }
        std::vector<Relaxation> rates;
        for (std::size_t term = 0; term < terms; ++term) {
            rates.push_back({.share = i == share_of(term) ? 1.0 : 0.0,
                             .time = longer * ((i == time_of(term) ? 1.0 : 0.0) + d_log_shift * p[time_of(term)])});
        }
        return rates;
    }
    std::string impossible(std::span<const double> p) const override {
        double fades = 0.0;
        for (std::size_t i = 0; i < terms; ++i) {
            fades += p[share_of(i)];
        }
        if (!(fades < 1.0)) {
            return fmt::format(
                "the shares g of the Prony series add up to {:g}: below 1, or nothing of the modulus stays", fades);
        }
        return IsotropicLinear::impossible(p);
    }
};

} // namespace

const Law& viscoelastic() {
    static const Viscoelastic law;
    return law;
}

} // namespace pave::material

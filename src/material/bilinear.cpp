#include "material/bilinear.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>
#include <fmt/format.h>

namespace pave::material {
namespace {

enum : std::size_t { modulus_at_break, slope_below, slope_above, breakpoint, lowest, highest };

constexpr double rounding = 3e3; // Pa: corners are hyperbolas of this width

// |x| with a rounded corner, and its derivative.
struct Corner {
    double value;
    double slope;
    explicit Corner(double x) : value(std::hypot(x, rounding)), slope(x / value) {}
};

class Bilinear final : public StressDependent {
public:
    Bilinear()
        : StressDependent(
              {
                  {"modulus_MPa",
                   unit::MPa,
                   0.0,
                   1e5,
                   true,
                   {},
                   "modulus at the breakpoint",
                   {},
                   UsualRange{5.0, 200.0, 50.0, true}},
                  {"slope_below",
                   1.0,
                   0.0,
                   1e5,
                   false,
                   {},
                   "fall of the modulus with the deviator stress below the breakpoint",
                   {},
                   UsualRange{0.0, 2500.0, 1000.0, false}},
                  {"slope_above", 1.0, 0.0, 1e5, false, 178.0, "the same above it", {}},
                  {"breakpoint_kPa", unit::kPa, 0.0, 1e3, true, 41.0, "deviator stress where the lines meet", {}},
                  {"deviator_low_kPa", unit::kPa, 0.0, 1e3, false, 14.0, "below it the modulus stays", {}},
                  {"deviator_high_kPa", unit::kPa, 0.0, 1e4, true, 145.0, "above it the modulus stays", {}},
              },
              1.0) {}
    std::string_view name() const override { return "bilinear"; }
    std::string_view summary() const override {
        return "softens with the deviator stress along two lines: E = modulus + slope (breakpoint - deviator)";
    }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t own[] = {first + modulus_at_break, first + slope_below, first + slope_above};
        return own;
    }
    std::string impossible(std::span<const double> p) const override {
        const auto own = p.subspan(first);
        if (!(own[lowest] < own[breakpoint] && own[breakpoint] < own[highest])) {
            return "deviator_low_kPa < breakpoint_kPa < deviator_high_kPa is needed";
        }
        const double least = own[modulus_at_break] - own[slope_above] * (own[highest] - own[breakpoint]);
        // Rounded corners add less than their width times the slopes.
        if (!(least > 2.0 * rounding * (own[slope_above] + own[slope_below]))) {
            return fmt::format("the modulus would fall to {:.3g} MPa at the highest deviator stress",
                               least / unit::MPa);
        }
        return StressDependent::impossible(p);
    }

private:
    // The deviator stress between its limits, and its rate by tau.
    struct Deviator {
        double value;
        double rate;
        Deviator(std::span<const double> p, double tau) {
            const double q = deviator_over_tau * tau;
            const Corner low(q - p[lowest]);
            const Corner high(q - p[highest]);
            value = (p[lowest] + p[highest] + low.value - high.value) / 2.0;
            rate = deviator_over_tau * (low.slope - high.slope) / 2.0;
        }
    };

    Terms terms(std::span<const double> p, double, double tau) const override {
        const Deviator q(p, tau);
        const double beyond = q.value - p[breakpoint];
        const Corner corner(beyond);
        const double mean = (p[slope_below] + p[slope_above]) / 2.0;
        const double change = (p[slope_below] - p[slope_above]) / 2.0;
        return {.value = p[modulus_at_break] - mean * beyond + change * corner.value,
                .d_thp = 0.0,
                .d_tau = (-mean + change * corner.slope) * q.rate};
    }
    double own_derivative(std::span<const double> p, double, double tau, double, std::size_t i) const override {
        const double q = deviator_over_tau * tau;
        const double beyond = Deviator(p, tau).value - p[breakpoint];
        const Corner corner(beyond);
        const double by_deviator =
            -(p[slope_below] + p[slope_above]) / 2.0 + (p[slope_below] - p[slope_above]) / 2.0 * corner.slope;
        switch (i) {
        case modulus_at_break: return 1.0;
        case slope_below: return (corner.value - beyond) / 2.0;
        case slope_above: return -(corner.value + beyond) / 2.0;
        case breakpoint: return -by_deviator;
        case lowest: return by_deviator * (1.0 - Corner(q - p[lowest]).slope) / 2.0;
        default: return by_deviator * (1.0 + Corner(q - p[highest]).slope) / 2.0;
        }
    }
};

} // namespace

const Law& bilinear() {
    static const Bilinear law;
    return law;
}

} // namespace pave::material

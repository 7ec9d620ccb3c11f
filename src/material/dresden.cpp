#include "material/dresden.h"

#include "base/units.h"
#include "material/stress_dependent.h"

#include <cmath>

namespace pave::material {
namespace {

enum : std::size_t { q, c, q1, q2, d, floor };

constexpr double pa = unit::reference_pressure;

class Dresden final : public StressDependent {
public:
    Dresden()
        : StressDependent(
              {
                  {"q",
                   1.0,
                   0.0,
                   1e6,
                   true,
                   {},
                   "modulus at sigma1 = pa without confinement, in units of pa = 100 kPa",
                   {},
                   UsualRange{100, 8000, 800, true}},
                  {"c",
                   1.0,
                   0.0,
                   1e6,
                   false,
                   {},
                   "what sigma3 = pa adds to it, in units of pa",
                   {},
                   UsualRange{100, 8000, 800, true}},
                  {"q1", 1.0, 0.0, 3.0, false, {}, "exponent of sigma3", {}, UsualRange{0.0, 1.2, 0.5, false}},
                  {"q2", 1.0, 0.0, 3.0, false, {}, "exponent of sigma1", {}, UsualRange{0.0, 0.8, 0.33, false}},
                  {"d_MPa", unit::MPa, 0.0, 1e4, false, 0.0, "modulus that no stress changes", {}},
                  {"sigma3_smoothing_kPa", unit::kPa, 0.0, 1e3, true, 5.0, "the smooth floor of sigma3", {}},
              },
              1.0) {}
    std::string_view name() const override { return "dresden"; }
    std::string_view summary() const override {
        return "stress-dependent: E = (q + c (sigma3/pa)^q1) pa (sigma1/pa)^q2 + d";
    }
    std::span<const std::size_t> scale_parameters() const override {
        static constexpr std::size_t own[] = {first + q, first + c, first + d};
        return own;
    }

private:
    struct State {
        double s1, s3; // Pa, both positive
        double d_s3;   // of s3 by what it would be without the floor
        double root;
        State(std::span<const double> p, double thp, double tau) {
            const double deviator = deviator_over_tau * tau;
            const double raw = (thp - deviator) / 3.0;
            s1 = (thp + 2.0 * deviator) / 3.0;
            root = std::hypot(raw, 2.0 * p[floor]);
            s3 = raw >= 0.0 ? (raw + root) / 2.0 : 2.0 * p[floor] * p[floor] / (root - raw);
            d_s3 = s3 / root;
        }
        double of_s1(std::span<const double> p) const { return pa * std::pow(s1 / pa, p[q2]); }
        double of_s3(std::span<const double> p) const { return p[c] * std::pow(s3 / pa, p[q1]); }
    };

    Terms terms(std::span<const double> p, double thp, double tau) const override {
        const State s(p, thp, tau);
        const double e = (p[q] + s.of_s3(p)) * s.of_s1(p);
        const double by_s1 = e * p[q2] / s.s1;
        const double by_s3 = s.of_s3(p) * p[q1] / s.s3 * s.of_s1(p) * s.d_s3;
        return {.value = e + p[d],
                .d_thp = (by_s1 + by_s3) / 3.0,
                .d_tau = deviator_over_tau * (2.0 * by_s1 - by_s3) / 3.0};
    }
    double own_derivative(std::span<const double> p, double thp, double tau, double value,
                          std::size_t i) const override {
        const State s(p, thp, tau);
        switch (i) {
        case q: return s.of_s1(p);
        case c: return std::pow(s.s3 / pa, p[q1]) * s.of_s1(p);
        case q1: return s.of_s3(p) * std::log(s.s3 / pa) * s.of_s1(p);
        case q2: return (value - p[d]) * std::log(s.s1 / pa);
        case d: return 1.0;
        default: return s.of_s3(p) * p[q1] / s.s3 * s.of_s1(p) * 2.0 * p[floor] / s.root;
        }
    }
};

} // namespace

const Law& dresden() {
    static const Dresden law;
    return law;
}

} // namespace pave::material

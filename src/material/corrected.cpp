#include "material/corrected.h"

#include "base/units.h"
#include "material/catalog.h"
#include "material/floor.h"

#include <array>
#include <cmath>
#include <memory>

namespace pave::material {
namespace {

constexpr double floor_of_theta = 5.0 * unit::kPa;
constexpr std::size_t extra = 4 * most_places;

// The scales that theta and tau are counted by.
double theta_scale(double thp) {
    return std::log(thp / unit::reference_pressure);
}
double tau_scale(double tau) {
    return std::log1p(tau / unit::reference_pressure);
}

struct Value {
    double value = 0.0;
    double slope = 0.0; // by x
};

// The curve through (x, y) at a point.
Value curve(std::span<const double> x, std::span<const double> y, double at) {
    const std::size_t n = x.size();
    if (n == 0 || at <= x.front()) {
        return {n == 0 ? 0.0 : y.front(), 0.0};
    }
    if (at >= x.back()) {
        return {y.back(), 0.0};
    }
    std::size_t i = 0;
    while (at > x[i + 1]) {
        ++i;
    }
    const auto slope = [&](std::size_t k) {
        return k == 0 || k + 1 == n ? 0.0 : (y[k + 1] - y[k - 1]) / (x[k + 1] - x[k - 1]);
    };
    const double h = x[i + 1] - x[i];
    const double t = (at - x[i]) / h;
    const double rise = y[i + 1] - y[i];
    const double left = h * slope(i);
    const double right = h * slope(i + 1);
    const double a = left - rise;
    const double b = rise - right;
    return {.value = y[i] + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b),
            .slope = (rise + (1.0 - 2.0 * t) * (a + t * (b - a)) + t * (1.0 - t) * (b - a)) / h};
}

class Corrected final : public Law {
public:
    explicit Corrected(const Law& own)
        : own_(own),
          count_(own.parameters().size()),
          infos_(own.parameters().begin(), own.parameters().end()) {
        for (std::size_t i = 0; i < extra; ++i) {
            const bool is_place = i / most_places % 2 == 0;
            infos_.push_back(
                {"", 1.0, is_place ? 0.0 : -100.0, is_place ? 1e9 : 100.0, false, is_place ? not_given : 0.0, "", {}});
        }
    }

    std::string_view name() const override { return own_.name(); }
    std::string_view summary() const override { return own_.summary(); }
    std::span<const ParameterInfo> parameters() const override { return infos_; }
    bool stress_dependent() const override { return true; }
    std::span<const std::size_t> scale_parameters() const override { return own_.scale_parameters(); }

    Modulus modulus(std::span<const double> p, mechanics::Invariants at) const override {
        const Modulus m = own_.modulus(law_of(p), at);
        const Factor f = factor(p, at);
        const double value = m.value * f.value;
        if (m.limited || !(value < modulus_limit)) {
            return {.value = modulus_limit, .d_theta = 0.0, .d_tau = 0.0, .limited = true};
        }
        return {.value = value,
                .d_theta = f.value * m.d_theta + value * f.by_theta,
                .d_tau = f.value * m.d_tau + value * f.by_tau,
                .limited = false};
    }

    double modulus_derivative(std::span<const double> p, mechanics::Invariants at, const Modulus& here,
                              std::size_t i) const override {
        if (here.limited) {
            return 0.0;
        }
        if (i < count_) {
            const auto law = law_of(p);
            return factor(p, at).value * own_.modulus_derivative(law, at, own_.modulus(law, at), i);
        }
        const std::size_t k = i - count_;
        if (k / most_places % 2 == 0) {
            return 0.0; // places stay
        }
        Values unit{};
        unit[k % most_places] = 1.0;
        return here.value * through(p, at, k >= 2 * most_places, unit).value;
    }

    mechanics::Stiffness<6> unit_stiffness(std::span<const double> p, mechanics::Invariants at) const override {
        return own_.unit_stiffness(law_of(p), at);
    }
    mechanics::Stiffness<6> unit_stiffness_derivative(std::span<const double> p, mechanics::Invariants at,
                                                      std::size_t i) const override {
        return i < count_ ? own_.unit_stiffness_derivative(law_of(p), at, i) : mechanics::Stiffness<6>::Zero();
    }
    bool turns() const override { return own_.turns(); }
    UnitGradient unit_stiffness_gradient(std::span<const double> p, mechanics::Invariants at) const override {
        return own_.unit_stiffness_gradient(law_of(p), at);
    }
    std::string impossible(std::span<const double> p) const override { return own_.impossible(law_of(p)); }

private:
    using Values = std::array<double, most_places>;
    struct Factor {
        double value = 1.0;
        double by_theta = 0.0, by_tau = 0.0; // of its logarithm
    };

    std::span<const double> law_of(std::span<const double> p) const { return p.first(count_); }

    // g or h with these values in place of its own.
    Value through(std::span<const double> p, mechanics::Invariants at, bool of_shear, const Values& values) const {
        const auto places = p.subspan(count_ + (of_shear ? 2 * most_places : 0), most_places);
        Values x{};
        std::size_t n = 0;
        for (; n < most_places && !std::isnan(places[n]); ++n) {
            x[n] = of_shear ? tau_scale(places[n]) : theta_scale(places[n]);
        }
        const double here = of_shear ? tau_scale(at.tau) : theta_scale(Floor(floor_of_theta, 0.0, at).thp);
        return curve({x.data(), n}, {values.data(), n}, here);
    }

    Values values_of(std::span<const double> p, bool of_shear) const {
        Values values{};
        const auto own = p.subspan(count_ + most_places * (of_shear ? 3 : 1), most_places);
        std::copy(own.begin(), own.end(), values.begin());
        return values;
    }

    Factor factor(std::span<const double> p, mechanics::Invariants at) const {
        const Value g = through(p, at, false, values_of(p, false));
        const Value h = through(p, at, true, values_of(p, true));
        const Floor floor(floor_of_theta, 0.0, at);
        return {.value = std::exp(g.value + h.value),
                .by_theta = g.slope * floor.d_theta / floor.thp,
                .by_tau = h.slope / (unit::reference_pressure + at.tau)};
    }

    const Law& own_;
    std::size_t count_; // of the law's parameters
    std::vector<ParameterInfo> infos_;
};

} // namespace

const Law& corrected(const Law& law) {
    static const auto all = [] {
        std::vector<std::unique_ptr<const Corrected>> list;
        for (const Law* own : laws()) {
            list.push_back(std::make_unique<Corrected>(*own));
        }
        return list;
    }();
    std::size_t i = 0;
    while (laws()[i] != &law) {
        ++i;
    }
    return *all[i];
}

std::size_t place_index(const Law& law, bool of_shear, std::size_t i) {
    return law.parameters().size() + (of_shear ? 2 * most_places : 0) + i;
}

std::size_t value_index(const Law& law, bool of_shear, std::size_t i) {
    return place_index(law, of_shear, i) + most_places;
}

} // namespace pave::material

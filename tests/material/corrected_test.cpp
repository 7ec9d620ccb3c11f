// A law with a factor of stress on it.
#include "base/units.h"
#include "material/catalog.h"
#include "material/corrected.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace pave;
using material::Law;

namespace {

// Typical parameters of a law, with nothing corrected.
std::vector<double> parameters_of(const Law& law) {
    std::vector<double> p;
    for (const auto& info : law.parameters()) {
        constexpr double any = 0.3; // of ratios, and of the floor that a case sets
        const double stated = info.default_value.value_or(info.usual ? info.usual->start : any);
        p.push_back(info.to_si * (std::isnan(stated) ? any : stated));
    }
    return p;
}

std::vector<double> corrected_parameters(const Law& law, const std::vector<double>& places,
                                         const std::vector<double>& values, bool of_shear) {
    std::vector<double> p = parameters_of(law);
    for (std::size_t i = p.size(); i < material::corrected(law).parameters().size(); ++i) {
        p.push_back(*material::corrected(law).parameters()[i].default_value);
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
        p[material::place_index(law, of_shear, i)] = places[i];
        p[material::value_index(law, of_shear, i)] = values[i];
    }
    return p;
}

std::vector<const Law*> laws_at_rest() {
    std::vector<const Law*> list;
    for (const Law* law : material::laws()) {
        if (!law->relaxes()) {
            list.push_back(law);
        }
    }
    return list;
}

constexpr mechanics::Invariants states[] = {{-20e3, 10e3}, {12e3, 3e3}, {75e3, 22e3}, {240e3, 90e3}, {900e3, 300e3}};

} // namespace

TEST(Corrected, IsTheLawItselfWithoutPlaces) {
    for (const Law* law : laws_at_rest()) {
        const auto p = corrected_parameters(*law, {}, {}, false);
        for (const auto at : states) {
            const auto own = law->modulus(parameters_of(*law), at);
            const auto same = material::corrected(*law).modulus(p, at);
            EXPECT_EQ(same.value, own.value) << law->name();
            EXPECT_EQ(same.d_theta, own.d_theta);
            EXPECT_EQ(same.d_tau, own.d_tau);
        }
    }
}

TEST(Corrected, DerivativesAgreeWithDifferences) {
    for (const Law* law : laws_at_rest()) {
        SCOPED_TRACE(law->name());
        const Law& own = material::corrected(*law);
        auto p = corrected_parameters(*law, {15e3, 60e3, 180e3, 540e3}, {0.3, -0.4, 0.2, 0.6}, false);
        const double places[] = {0.0, 15e3, 45e3, 135e3};
        const double values[] = {-0.2, 0.1, 0.5, -0.3};
        for (std::size_t i = 0; i < 4; ++i) {
            p[material::place_index(*law, true, i)] = places[i];
            p[material::value_index(*law, true, i)] = values[i];
        }
        for (const auto at : states) {
            const auto m = own.modulus(p, at);
            const double h = 1.0;
            const auto value = [&](double theta, double tau) {
                return own.modulus(p, {at.theta + theta, at.tau + tau}).value;
            };
            EXPECT_NEAR(m.d_theta, (value(h, 0) - value(-h, 0)) / (2 * h), 1e-6 * m.value / 1e4);
            EXPECT_NEAR(m.d_tau, (value(0, h) - value(0, -h)) / (2 * h), 1e-6 * m.value / 1e4);
            for (std::size_t i = 0; i < p.size(); ++i) {
                const auto& info = own.parameters()[i];
                if (!info.choices.empty() || std::isnan(p[i]) || i == material::place_index(*law, true, 0)) {
                    continue;
                }
                auto low = p;
                auto high = p;
                const double step = 1e-5 * std::max(std::abs(p[i]), 0.1);
                low[i] -= step;
                high[i] += step;
                const double rate = (own.modulus(high, at).value - own.modulus(low, at).value) / (2 * step);
                const bool stays = i >= law->parameters().size() && std::isnan(*info.default_value);
                EXPECT_NEAR(own.modulus_derivative(p, at, m, i), stays ? 0.0 : rate,
                            1e-6 * m.value / std::max(std::abs(p[i]), 0.1))
                    << i;
            }
        }
    }
}

// E (thp/pa)^a is equation 1 with k2 + a: what is straight in ln(theta) between the second place and the last but one
// is reproduced.
TEST(Corrected, StraightInLogarithmsIsAnotherExponent) {
    const Law& law = *material::find_law("uzan");
    std::vector<double> places;
    std::vector<double> values;
    constexpr double exponent = 0.3;
    for (const double place : {1e-3, 1.0, 5e7, 1e9}) {
        places.push_back(place);
        values.push_back(exponent * std::log(place / unit::reference_pressure));
    }
    auto p = corrected_parameters(law, places, values, false);
    auto steeper = parameters_of(law);
    p[*law.index_of("shear_floor")] = steeper[*law.index_of("shear_floor")] = 0.0; // the same floor of theta
    steeper[*law.index_of("k2")] += exponent;
    for (const auto at : states) {
        const auto found = material::corrected(law).modulus(p, at);
        const auto expected = law.modulus(steeper, at);
        EXPECT_NEAR(found.value / expected.value, 1.0, 1e-12);
        EXPECT_NEAR(found.d_theta / expected.d_theta, 1.0, 1e-12);
    }
}

TEST(Corrected, IsSmoothAndConstantBeyondItsPlaces) {
    const Law& law = *material::find_law("linear");
    const std::vector<double> places{20e3, 60e3, 180e3};
    const auto p = corrected_parameters(law, places, {std::log(0.5), 0.0, std::log(2.0)}, true);
    const Law& own = material::corrected(law);
    const double stated = law.modulus(parameters_of(law), {}).value;
    const auto at = [&](double tau) { return own.modulus(p, {100e3, tau}); };
    EXPECT_NEAR(at(0.0).value / stated, 0.5, 1e-12);
    EXPECT_NEAR(at(60e3).value / stated, 1.0, 1e-12);
    EXPECT_NEAR(at(500e3).value / stated, 2.0, 1e-12);
    for (const double place : places) { // no kink
        EXPECT_NEAR(at(place - 1e-3).d_tau, at(place + 1e-3).d_tau, 1e-6 * stated / 60e3);
    }
}

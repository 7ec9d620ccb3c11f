// Corrections of a section by depth, distance and stress, and of readings.
#include "pavement/effects/effect.h"
#include "support/differences.h"
#include "support/effects.h"

#include <gtest/gtest.h>

using namespace test;

namespace {

Case corrected(Case c, Channel channel, std::string layer, std::vector<double> places, std::vector<double> factors) {
    c.corrections.push_back({.channel = channel,
                             .layer = std::move(layer),
                             .places = std::move(places),
                             .factors = std::move(factors),
                             .present = true});
    return c;
}

std::vector<Case> every_channel(const Case& c) {
    return {corrected(c, Channel::depth, "base", {0.0, 0.1, 0.2, 0.277}, {1.2, 0.8, 0.7, 1.1}),
            corrected(c, Channel::depth, "subgrade", {0.0, 0.2, 0.5, 1.0}, {0.6, 0.9, 1.3, 1.0}),
            corrected(c, Channel::distance, "asphalt", {0.0, 0.15, 0.3, 0.6}, {1.0, 0.9, 0.5, 0.4}),
            corrected(c, Channel::distance, "subgrade", {0.0, 0.3, 0.6, 1.2}, {0.8, 1.1, 1.2, 0.9}),
            corrected(c, Channel::theta, "base", {20e3, 60e3, 180e3, 540e3}, {1.3, 0.9, 0.8, 1.2}),
            corrected(c, Channel::theta, "subgrade", {20e3, 60e3, 180e3}, {0.7, 1.0, 1.2}),
            corrected(c, Channel::tau, "base", {0.0, 30e3, 100e3}, {1.2, 0.9, 0.8}),
            corrected(c, Channel::tau, "subgrade", {0.0, 15e3, 45e3}, {1.2, 0.9, 0.7})};
}

void expect_exact_derivatives(const Case& c) {
    const Correction& correction = c.corrections.front();
    SCOPED_TRACE(correction.name());
    std::vector<Parameter> parameters;
    for (const std::size_t i : {std::size_t{2}, correction.places.size()}) {
        parameters.push_back(find_parameter(c, correction.name() + ".factor_" + std::to_string(i), {}));
    }
    parameters.push_back(find_parameter(c, "base.k1", {}));
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    const auto exact = model.run(c, parameters, *workspace);
    ASSERT_TRUE(exact) << exact.failure().reason;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double value = parameters[p].get(c);
        // Factors of stress jump in their second derivative: a step of 1e-3 feels it.
        const auto rates = central_differences(model, c, parameters[p], 1e-4 * value, *exact, *workspace);
        ASSERT_TRUE(rates);
        const auto d = disagreement(*exact, p, value, rates->rates);
        EXPECT_LT(d.worst, 2e-6 * std::max(d.scale, 1e-3)) << parameters[p].path;
    }
}

} // namespace

TEST(Correction, DerivativesAreExactInTwoDimensions) {
    for (const Case& own : every_channel(axisymmetric_case())) {
        expect_exact_derivatives(own);
    }
    Case secant = axisymmetric_case(Integration::secant);
    secant.settings.solver.equilibrium_tolerance = 1e-11;
    const auto all = every_channel(secant);
    for (const std::size_t i : {3U, 4U, 7U}) {
        expect_exact_derivatives(all[i]);
    }
}

TEST(Correction, DerivativesAreExactInThreeDimensions) {
    const auto all = every_channel(solid_case());
    for (const std::size_t i : {2U, 6U}) {
        expect_exact_derivatives(all[i]);
    }
}

TEST(Correction, OfReadingsScalesThem) {
    const Case c = axisymmetric_case();
    const auto plain = values_of(c);
    const Case moved = corrected(c, Channel::offset, "", {0.2, 0.6}, {1.1, 0.9});
    const auto found = values_of(moved);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const Sensor& sensor = c.sensors[i];
        const double share = std::clamp((sensor.x - 0.2) / 0.4, 0.0, 1.0);
        const double factor =
            sensor.quantity == Quantity::deflection ? std::pow(1.1, 1.0 - share) * std::pow(0.9, share) : 1.0;
        EXPECT_NEAR(found[i] / plain[i], factor, 1e-12);
    }
    expect_exact_derivatives(moved);
}

TEST(Correction, ThatIsNotThereChangesNoBit) {
    const Case c = axisymmetric_case();
    const auto plain = values_of(c);
    for (Case own : every_channel(c)) {
        own.corrections[0].factors.assign(own.corrections[0].factors.size(), 1.0);
        own.corrections[0].present = false;
        EXPECT_EQ(values_of(own), plain) << own.corrections[0].name();
    }
}

// Half of the modulus all over is half of the modulus.
TEST(Correction, ThatIsTheSameEverywhereIsAFactorOnTheModulus) {
    const Case c = axisymmetric_case();
    for (Case own : every_channel(c)) {
        Correction& correction = own.corrections[0];
        correction.factors.assign(correction.factors.size(), 0.5);
        Case scaled = c;
        for (const std::size_t l : layers_named(scaled, correction.layer)) {
            scale_modulus(scaled.layers[l], 0.5);
        }
        EXPECT_LT(largest_change(values_of(own), values_of(scaled)), 1e-4) << correction.name();
    }
}

// In ever thinner layers, each with the modulus of its middle, the section converges to the corrected one: with four
// times as many the difference falls to a third and less.
TEST(Correction, OfDepthIsASectionOfManyThinLayers) {
    const Case c = axisymmetric_case();
    const std::vector<double> places{0.0, 0.1, 0.277};
    const std::vector<double> factors{0.5, 1.5, 0.8};
    const auto found = values_of(corrected(c, Channel::depth, "base", places, factors));
    const auto difference = [&](int parts) {
        Case cut = c;
        const Layer whole = c.layers[1];
        cut.layers.erase(cut.layers.begin() + 1);
        for (int i = parts - 1; i >= 0; --i) {
            Layer part = whole;
            part.name += std::to_string(i);
            part.thickness /= parts;
            const double z = whole.thickness * (i + 0.5) / parts;
            const std::size_t k = z < places[1] ? 0 : 1;
            const double share = (z - places[k]) / (places[k + 1] - places[k]);
            scale_modulus(part, std::pow(factors[k], 1.0 - share) * std::pow(factors[k + 1], share));
            cut.layers.insert(cut.layers.begin() + 1, part);
        }
        return largest_change(values_of(cut), found);
    };
    const double coarse = difference(4);
    const double fine = difference(16);
    EXPECT_GT(coarse, 0.01);
    EXPECT_LT(fine, 0.015);
    EXPECT_LT(fine, coarse / 3.0);
}

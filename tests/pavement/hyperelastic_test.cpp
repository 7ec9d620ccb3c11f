// Sections of layers whose strain derives from an energy: closed forms of a column, the load path, linear limits,
// derivatives, motion.
#include "support/differences.h"
#include "support/sections.h"

#include "pavement/effects/catalog.h"
#include "pavement/effects/effect.h"
#include "pavement/load_model.h"
#include "reduced/basis.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace test;

namespace {

struct Hyperelastic {
    double k1 = 1800, k = 0.5, n = 0.4;
    double nu12 = 0.35, nu31 = 0.35;
    double delta = 5e3; // Pa
    double residual_stress = 0.0;
};

Layer hyperelastic_layer(std::string name, double thickness, const Hyperelastic& h = {}) {
    return {std::move(name),
            thickness,
            2200.0,
            0.5,
            h.residual_stress,
            material::find_law("hyperelastic"),
            {0.0, h.k1, h.k, h.n, h.nu12, h.nu31, material::not_given, h.delta}};
}

// CAPTIF pavement 1 with such a base.
Case hyperelastic_captif(const Hyperelastic& h = {}, double refine = 1.0) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.layers[1] = hyperelastic_layer("base", 0.277, h);
    c.settings.refine = refine;
    return c;
}

// The strain of a stress (horizontal, vertical) by the printed equation, of the horizontal modulus E1 = E: vertical and
// horizontal.
struct Printed {
    Hyperelastic h;
    double pa = 1e5;
    double a11() const { return 1.0; }
    double a12() const { return -h.nu12; }
    double a13() const { return -h.nu31 * h.n; } // -nu31/E3, E3 = E1/n
    double a33() const { return h.n; }
    double modulus(double horizontal, double vertical) const {
        const double q = 2.0 * (a11() + a12()) * horizontal * horizontal + 4.0 * a13() * horizontal * vertical +
                         a33() * vertical * vertical;
        return h.k1 * pa * std::pow((q + h.delta * h.delta) / (pa * pa), h.k / 2.0);
    }
    double horizontal(double across, double along) const {
        return ((a11() + a12()) * across + a13() * along) / modulus(across, along);
    }
    double vertical(double across, double along) const {
        return (2.0 * a13() * across + a33() * along) / modulus(across, along);
    }
    // Vertical strain of a load of vertical stress on an initial stress, held sideways. Compression positive.
    double held(double initial_across, double initial_along, double load) const {
        const double wanted = horizontal(initial_across, initial_along);
        double low = -1e7;
        double high = 1e7;
        for (int i = 0; i < 200; ++i) {
            const double middle = (low + high) / 2.0;
            (horizontal(middle, initial_along + load) < wanted ? low : high) = middle;
        }
        return vertical(low, initial_along + load) - vertical(initial_across, initial_along);
    }
};

// The deflection of the top of a column of one layer, held sideways, pressed evenly over its top.
double column_deflection(const Layer& layer, double pressure, int cells) {
    constexpr double wall = 0.2;
    Case c;
    c.layers = {layer};
    c.loads = {plate(wall, pressure)};
    c.settings.extent = wall;
    std::vector<double> z;
    for (int i = 0; i <= cells; ++i) {
        z.push_back(layer.thickness * i / cells);
    }
    const auto mesh = mesh::axisymmetric_mesh({0.0, wall / 2.0, wall}, z, {layer.thickness});
    const auto model = fe::make_model(mesh, {false});
    const Eigen::VectorXd load = pressure * Axisymmetric::unit_load(mesh, model, c.loads[0]);
    fe::Solver<fe::AxisymmetricQ8> solver(model);
    const auto solved = solver.hyperelastic(materials_of(c), load, {}, {});
    EXPECT_TRUE(solved);
    EXPECT_LT(solved->statistics.residual_relative, 1e-9);
    return solved->displacement[model.topology->unknowns[0][1]];
}

} // namespace

// Without weight the stress ratio of a column is that of a linear one, K = -A13/(A11 + A12), and Q = stress^2/M with
// 1/M = A33 - 2 A13^2/(A11 + A12): the strain is stress/(M E).
TEST(HyperelasticColumn, WithoutWeightHasTheStrainOfTheClosedForm) {
    for (const double k : {0.0, 0.5, 0.8, -0.6}) {
        Hyperelastic h{.k = k};
        Layer layer = hyperelastic_layer("column", 1.5, h);
        layer.density = 0.0;
        const double m = 1.0 / (h.n - 2.0 * h.nu31 * h.n * h.nu31 * h.n / (1.0 - h.nu12));
        for (const double pressure : {20e3, 400e3}) {
            const double e = h.k1 * 1e5 * std::pow((pressure * pressure / m + h.delta * h.delta) / 1e10, k / 2.0);
            const double expected = 1.5 * pressure / (m * e);
            EXPECT_NEAR(column_deflection(layer, pressure, 2) / expected, 1.0, 1e-9) << k;
        }
    }
}

TEST(HyperelasticColumn, WithWeightHasTheStrainsOfEveryDepth) {
    const Hyperelastic h{.k = 0.6, .residual_stress = 10e3};
    const Layer layer = hyperelastic_layer("column", 2.0, h);
    double expected = 0.0;
    constexpr int parts = 4000;
    for (int i = 0; i < parts; ++i) {
        const double vertical = 2200.0 * 9.81 * 2.0 * (i + 0.5) / parts;
        expected += 2.0 / parts * Printed{h}.held(0.5 * vertical + 10e3, vertical, 200e3);
    }
    double before = 1.0;
    for (const int cells : {4, 8, 16}) { // displacements converge with the fourth power of the cells
        const double error = std::abs(column_deflection(layer, 200e3, cells) / expected - 1.0);
        EXPECT_LT(error, before / 8.0) << cells;
        before = error;
    }
    EXPECT_LT(before, 1e-6);
}

// Pulled, too, a column has its one answer.
TEST(HyperelasticColumn, IsAnsweredInTension) {
    const Hyperelastic h{.k = 0.7};
    Layer layer = hyperelastic_layer("column", 1.0, h);
    layer.density = 0.0;
    EXPECT_NEAR(column_deflection(layer, -150e3, 2), -column_deflection(layer, 150e3, 2), 1e-12);
    layer.density = 2200.0;
    double expected = 0.0;
    for (int i = 0; i < 4000; ++i) {
        const double vertical = 2200.0 * 9.81 * (i + 0.5) / 4000;
        expected += Printed{h}.held(0.5 * vertical, vertical, -60e3) / 4000;
    }
    EXPECT_NEAR(column_deflection(layer, -60e3, 32) / expected, 1.0, 1e-3);
}

// With k = 0 the layer is linear: a stress-dependent law whose exponents are zero, along a path.
TEST(HyperelasticSection, IsTheLinearCrossAnisotropicOneWithoutAnExponent) {
    Case c = hyperelastic_captif({.k = 0.0});
    Case linear = c;
    linear.layers[1] = uzan_layer("base", 0.277, {.k1 = 1800, .k2 = 0.0, .k3 = 0.0, .n = 0.4});
    const auto found = run(c, {"base.k1", "base.n"});
    const auto expected = run(linear, {"base.k1", "base.n"});
    ASSERT_TRUE(found && expected);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        EXPECT_NEAR(found->values[i] / expected->values[i], 1.0, 1e-9) << i;
    }
    EXPECT_LT((found->jacobian - expected->jacobian).norm(), 1e-9 * expected->jacobian.norm());
}

// The load path of the same law, by its tangents, ends at the minimum of the energy: the nearer the more steps it has,
// with their third power.
template <class Kind>
void expect_end_of_the_path(const Case& c) {
    const auto parts = parts_of<Kind>(c, 0);
    fe::Solver<typename Kind::Element> solver(parts.model);
    const auto at_once = solver.hyperelastic(parts.layers, parts.load, {}, c.settings.solver);
    ASSERT_TRUE(at_once) << at_once.failure().reason;
    double before = 0.05;
    for (const int steps : {9, 18, 36}) {
        fe::SolverSettings settings = c.settings.solver;
        settings.load_steps = steps;
        settings.linear_tolerance = 1e-9;
        const auto path = solver.incremental(parts.layers, parts.load, {}, settings);
        ASSERT_TRUE(path) << path.failure().reason;
        const double error = (path->displacement - at_once->displacement).norm() / at_once->displacement.norm();
        EXPECT_LT(error, before / 4.0) << steps;
        before = error;
    }
    EXPECT_LT(before, 1e-4);
}

TEST(HyperelasticSection, IsWhereEveryLoadPathEnds) {
    expect_end_of_the_path<Axisymmetric>(hyperelastic_captif({}, 0.5));
    expect_end_of_the_path<Axisymmetric>(hyperelastic_captif({.k = -0.4, .residual_stress = 20e3}, 0.5));
    expect_end_of_the_path<Axisymmetric>(hyperelastic_captif({.k = 0.75}, 0.5));
}

TEST(HyperelasticSection, IsWhereEveryLoadPathEndsInThreeDimensions) {
    Case c = hyperelastic_captif({}, 0.3);
    c.loads = {dual_wheel()};
    c.settings.extent = 2.0;
    expect_end_of_the_path<Solid>(c);
}

TEST(HyperelasticSection, ConvergesUnderRefinementOfTheMesh) {
    std::vector<std::vector<double>> values;
    for (const double refine : {0.5, 1.0, 2.0, 4.0}) {
        const auto found = run(hyperelastic_captif({}, refine));
        ASSERT_TRUE(found);
        values.push_back(found->values);
    }
    for (std::size_t i = 0; i < values[0].size(); ++i) {
        const double scale = std::max(std::abs(values[3][i]), 5e-5); // a far deflection changes its sign
        const auto gap = [&](std::size_t mesh) { return std::abs(values[mesh][i] - values[3][i]) / scale; };
        EXPECT_LT(gap(1), 0.02) << i;
        EXPECT_LT(gap(2), std::max(0.5 * gap(0), 1e-3)) << i;
    }
}

namespace {

void expect_rates(const Case& c, std::initializer_list<const char*> paths, double tolerance = 1e-6) {
    expect_exact_derivatives(c, paths, tolerance);
}

// Not the first layer alone, and beside a spring.
Case of_two() {
    Case c = hyperelastic_captif({}, 0.4);
    c.layers[2] = hyperelastic_layer("subgrade", 1.193, {.k1 = 500, .k = -0.3, .n = 0.7});
    c.sensors.push_back({0, Quantity::stress_zz, 0.1, 0.0, 0.2, 0.0});
    c.sensors.push_back({0, Quantity::stress_xx, 0.0, 0.0, 0.6, 0.0});
    return c;
}

} // namespace

TEST(HyperelasticSection, HasExactDerivatives) {
    Case c = of_two();
    expect_rates(c, {"base.k1", "base.k", "base.n", "base.poisson_12", "base.poisson_31", "base.stress_smoothing_kPa",
                     "base.density_kg_m3", "base.k0", "base.residual_stress_kPa", "base.thickness_mm",
                     "asphalt.thickness_mm", "asphalt.density_kg_m3", "asphalt.modulus_MPa", "subgrade.k1",
                     "subgrade.k", "subgrade.thickness_mm", "fwd.pressure_kPa", "fwd.radius_mm"});
    c.layers[1].compliance = 1e-9;
    c.layers[1].parameters[6] = 0.3; // shear ratio
    expect_rates(c, {"base.shear_ratio", "base.k", "subgrade.k1"});
}

TEST(HyperelasticSection, HasExactDerivativesByWhatVariesWithinALayer) {
    for (const char* name : {"anisotropy-distribution", "base-modulus-gradient"}) {
        Case c = hyperelastic_captif({}, 0.4);
        c.effects = {{.effect = find_effect(name), .size = 0.4, .present = true}};
        const std::string size = std::string(name) + ".size";
        expect_rates(c, {size.c_str(), "base.k1", "base.k", "base.n"});
    }
}

// A factor on the modulus is one on k1, at every point.
TEST(HyperelasticSection, TakesAFactorOnItsModulusAsOneOnK1) {
    Case c = hyperelastic_captif({}, 0.4);
    c.layers[1].fields = {{.parameter = {},
                           .is_power = true,
                           .size = std::log(1.7),
                           .weight = [](const fe::Field::Shape&, const Eigen::Vector3d&) { return 1.0; }}};
    const auto found = run(c);
    const auto expected = run(hyperelastic_captif({.k1 = 1.7 * 1800}, 0.4));
    ASSERT_TRUE(found && expected);
    for (std::size_t i = 0; i < found->values.size(); ++i) {
        EXPECT_NEAR(found->values[i] / expected->values[i], 1.0, 1e-10) << i;
    }
}

TEST(HyperelasticSection, HasExactDerivativesInThreeDimensions) {
    Case c = hyperelastic_captif({}, 0.3);
    c.loads = {dual_wheel()};
    c.settings.extent = 2.0;
    c.settings.solver.linear_tolerance = 1e-9;
    c.sensors = {deflection(0.0),
                 deflection(0.5),
                 strain_zz(0.15, 0.0, 0.17),
                 strain_zz(0.4, 0.0, 0.17),
                 {0, Quantity::stress_yy, 0.17, 0.0, 0.2, 0.0}};
    expect_rates(c, {"base.k1", "base.k", "base.n", "base.k0", "asphalt.modulus_MPa"}, 1e-5);
}

// Beside a layer that has a load path the section has one: the same answer where that layer's modulus is a number.
TEST(HyperelasticBesideOtherLaws, IsFollowedAlongTheirLoadPath) {
    Case c = hyperelastic_captif({}, 0.5);
    const auto at_once = run(c);
    c.layers[2] = uzan_layer("subgrade", 1.193, {.k1 = 450, .k2 = 0.0, .k3 = 0.0, .n = 1.0});
    c.layers[2].parameters[5] = c.layers[2].parameters[6] = 0.4; // the linear subgrade: 45 MPa
    c.settings.solver.load_steps = 36;
    const auto along = run(c);
    ASSERT_TRUE(at_once && along);
    EXPECT_EQ(at_once->statistics.load_steps, 1);
    EXPECT_GT(along->statistics.load_steps, 5);
    for (std::size_t i = 0; i < at_once->values.size(); ++i) {
        const double scale = std::max(std::abs(at_once->values[i]), 1e-4);
        EXPECT_NEAR(along->values[i], at_once->values[i], 1e-3 * scale) << i;
    }
}

TEST(HyperelasticBesideOtherLaws, HasExactDerivativesAlongTheLoadPath) {
    Case c = of_two();
    c.layers[2] = uzan_layer("subgrade", 1.193, {.k1 = 600, .k2 = 0.2, .k3 = -0.5, .n = 1.0});
    expect_rates(c,
                 {"base.k1", "base.k", "base.n", "base.k0", "base.poisson_31", "base.stress_smoothing_kPa",
                  "base.thickness_mm", "subgrade.k1", "asphalt.density_kg_m3"},
                 5e-6);
}

TEST(HyperelasticBesideOtherLaws, IsNotASecantButAloneHasTheSameAnswerAnyWay) {
    Case c = hyperelastic_captif({}, 0.4);
    const auto expected = run(c);
    c.settings.integration = Integration::secant;
    const auto found = run(c);
    ASSERT_TRUE(found && expected);
    EXPECT_EQ(found->values, expected->values);
    c.layers[2] = uzan_layer("subgrade", 1.193, {.k1 = 600, .k2 = 0.2, .k3 = -0.5, .n = 1.0});
    EXPECT_THROW(ForwardModel{c}, Error);
}

TEST(HyperelasticSection, SaysWhyItHasNoReducedModel) {
    EXPECT_NE(reduced::why_not(hyperelastic_captif(), 0).find("no load path"), std::string::npos);
    Case c = hyperelastic_captif();
    c.layers[2] = uzan_layer("subgrade", 1.193, {.k1 = 600, .k2 = 0.2, .k3 = -0.5, .n = 1.0});
    EXPECT_NE(reduced::why_not(c, 0), "");
}

TEST(HyperelasticSection, WritesTheModuliOfItsStress) {
    Case c = hyperelastic_captif({}, 0.5);
    c.layers[1].parameters[0] = 1.0; // the vertical modulus
    const auto fields = ForwardModel(c).fields(c, 0);
    ASSERT_TRUE(fields);
    int compared = 0;
    for (Eigen::Index i = 0; i < fields->vertical_modulus.size(); ++i) {
        if (fields->layer[static_cast<std::size_t>(i / fields->nodes)] != 1) {
            continue;
        }
        const double vertical = -2200.0 * 9.81 * fields->position(2, i);
        mechanics::Voigt<6> whole = fields->stress.col(i);
        whole[0] += 0.5 * vertical;
        whole[1] += 0.5 * vertical;
        whole[2] += vertical;
        // Vertical modulus E: E1 = n E.
        const double n = 0.4;
        const double nu = 0.35;
        const double g = n / (1.0 + (1.0 + 2.0 * nu) * n);
        const double q = (whole[0] * whole[0] + whole[1] * whole[1] - 2.0 * nu * whole[0] * whole[1]) / n +
                         whole[2] * whole[2] - 2.0 * nu * whole[2] * (whole[0] + whole[1]) + whole[3] * whole[3] / g;
        const double e = 1800e5 * std::pow((q + 25e6) / 1e10, 0.25);
        EXPECT_NEAR(fields->vertical_modulus[i] / e, 1.0, 1e-9);
        EXPECT_NEAR(fields->horizontal_modulus[i] / (n * e), 1.0, 1e-9);
        ++compared;
    }
    EXPECT_GT(compared, 100);
}

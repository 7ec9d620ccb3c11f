// The mechanics of effects against closed forms and limits.
#include "reference/multilayer_elastic.h"
#include "support/effects.h"

#include "pavement/load_model.h"

#include <numbers>

using namespace test;

namespace {

// A linear half-space under a plate, deep and wide.
Case half_space(double modulus, double poisson) {
    Case c;
    c.layers = {linear_layer("soil", 30.0, modulus, poisson)};
    c.loads = {plate(0.15, 600e3)};
    c.sensors = {deflection(0.0)};
    c.settings.extent = 30.0;
    return c;
}

} // namespace

// Boussinesq: flexible 2 p a (1 - nu^2)/E at the centre; the rigid punch pi/2 p a (1 - nu^2)/E everywhere under it.
TEST(PlateRigidity, GoesFromTheFlexiblePlateToTheRigidPunch) {
    const double e = 50e6, nu = 0.35;
    Case c = half_space(e, nu);
    c.sensors = {deflection(0.0), deflection(0.075), deflection(0.14)};
    const double unit = 600e3 * 0.15 * (1 - nu * nu) / e;
    const double punch = std::numbers::pi / 2.0 * unit;
    // The wall and the floor far away move everything near the plate alike: by what the flexible plate shows.
    c.settings.refine = 4.0;
    const double moved = values_of(c)[0] - 2.0 * unit;
    // The pressure of the punch is singular at its edge: what the mesh errs by is in proportion to its size there.
    for (const auto& [refine, allowed] : {std::pair{1.0, 0.006}, {2.0, 0.004}, {4.0, 0.003}}) {
        c.settings.refine = refine;
        for (const double w : values_of(with(c, "plate-rigidity", 0.999))) {
            EXPECT_NEAR((w - moved) / punch, 1.0, allowed) << refine;
        }
    }
    c.settings.refine = 2.0;
    EXPECT_NEAR(values_of(c)[0] / (2.0 * unit), 1.0, 0.01);
    double before = values_of(c)[0];
    for (const double size : {0.1, 0.5, 0.9, 0.99}) {
        const double w = values_of(with(c, "plate-rigidity", size))[0];
        EXPECT_LT(w, before);
        before = w;
    }
}

// The parabola p (1 - s)... with s = -1 is 2 p (1 - (r/a)^2): Hertz-like, with 8/3 p a (1 - nu^2)/E at the centre (the
// integral of the Boussinesq kernel, 2 (1 - nu^2)/E int 2 p (1 - r^2/a^2) dr).
TEST(ContactPressureShape, OfAParabolaHasItsDeflectionAndKeepsTheForce) {
    const double e = 50e6, nu = 0.35;
    Case c = half_space(e, nu);
    c.sensors.push_back(deflection(1.5));
    const auto uniform = values_of(c);
    const auto parabola = values_of(with(c, "contact-pressure-shape", -1.0));
    EXPECT_NEAR(parabola[0] / (8.0 / 3.0 * 600e3 * 0.15 * (1 - nu * nu) / e), 1.0, 0.01);
    EXPECT_NEAR(parabola[1] / uniform[1], 1.0, 0.005);
    Case dual = solid_case();
    for (const Patch patch : {Patch::rectangle, Patch::circle}) {
        dual.loads = {dual_wheel(40e3, 650e3, patch)};
        const auto parts = parts_of<Solid>(dual, 0);
        dual.loads[0].pressure_shape = 0.7;
        EXPECT_NEAR(4.0 * 650e3 * Solid::unit_load(parts.mesh, parts.model, dual.loads[0]).sum() / 40e3, 1.0, 1e-9);
    }
}

// Frictionless: the two halves of a divided slab bend each on its own. Bonded: the multilayer solution.
TEST(InterfaceSlip, GoesFromTheBondedSolutionToFrictionlessLayers) {
    Case c = three_layers();
    c.sensors = {deflection(0.0), deflection(0.3), {0, Quantity::strain_xx, 0.0, 0.0, 0.1499, 0.0}};
    std::vector<reference::ElasticLayer> layers;
    for (const Layer& layer : c.layers) {
        layers.push_back({layer.thickness, layer.parameters[0], layer.parameters[1]});
    }
    // Present without slip: two faces held together.
    const auto held = values_of(with(c, *find_effect("interface-slip-asphalt-base"), 0.0, true));
    for (const int i : {0, 1}) {
        const double w = reference::multilayer_elastic(layers, reference::Floor::rigid_rough, 0.15, 600e3,
                                                       c.sensors[static_cast<std::size_t>(i)].x, 0.0)
                             .u_z;
        EXPECT_NEAR(held[static_cast<std::size_t>(i)] / w, 1.0, 0.005);
    }
    auto before = held;
    for (const double size : {0.01, 0.1, 0.5, 0.9, 0.999}) {
        const auto now = values_of(with(c, "interface-slip-asphalt-base", size));
        EXPECT_GT(now[0], before[0]);
        EXPECT_LT(now[2], before[2]); // more tension at the bottom of the asphalt
        before = now;
    }
    // A thin film with hardly any shear stiffness instead of the spring: k = G / thickness.
    Case film = c;
    const double size = 0.6, thickness = 0.002;
    const double k = 1e9 * (1.0 - size) / size;
    Layer soft = uzan_layer("film", thickness, {.k1 = 3000e6 / 1e5, .k2 = 0.0, .k3 = 0.0, .n = 1.0});
    soft.parameters[7] = k * thickness / 3000e6;
    film.layers.insert(film.layers.begin() + 1, soft);
    film.layers[0].thickness -= thickness / 2.0;
    film.layers[2].thickness -= thickness / 2.0;
    const auto by_film = values_of(film);
    const auto by_spring = values_of(with(c, "interface-slip-asphalt-base", size));
    EXPECT_NEAR(by_film[0] / by_spring[0], 1.0, 0.005);
    EXPECT_NEAR(by_film[1] / by_spring[1], 1.0, 0.005);
}

// One-dimensional compression of E0 (1 + g z): w = p/M0 ln(1 + g H)/g.
TEST(SubgradeDepthGradient, HasTheClosedFormOfOneDimensionalCompression) {
    const double e = 40e6, nu = 0.3, g = 1.7, depth = 2.0;
    const auto w = values_of(with(column(e, nu, depth), "subgrade-depth-gradient", g))[0];
    EXPECT_NEAR(w / (100e3 / oedometric(e, nu) * std::log1p(g * depth) / g), 1.0, 1e-4);
}

TEST(WeakSubgradeTop, HasTheClosedFormOfOneDimensionalCompression) {
    const double e = 40e6, nu = 0.3, size = 0.9;
    const auto w = values_of(with(column(e, nu, 2.0), "weak-subgrade-top", size))[0];
    EXPECT_NEAR(w / (100e3 / oedometric(e, nu) * (0.2 * std::exp(size) + 1.8)), 1.0, 1e-5);
}

TEST(FloorDepth, AddsToTheCompressionOfAColumn) {
    const double e = 40e6, nu = 0.3;
    EXPECT_NEAR(values_of(with(column(e, nu, 2.0), "floor-depth", 500.0))[0] / (100e3 / oedometric(e, nu) * 2.5), 1.0,
                1e-5);
}

// Where n is 1 already, rising to 1 changes nothing; where it is not, far from the load it is 1.
TEST(AnisotropyDistribution, OfAnIsotropicBaseIsConstant) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 1.0});
    const auto plain = values_of(c);
    EXPECT_LT(largest_change(values_of(with(c, "anisotropy-distribution", 0.8)), plain), 1e-9);
    fe::LayerMaterial layer = materials_of(with_effects(
        with(captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.2}), "anisotropy-distribution", 1.0), 0))[1];
    const auto uniform = [&](double n) {
        auto p = layer.parameters;
        p[4] = n;
        return layer.law->unit_stiffness(p, {});
    };
    EXPECT_TRUE(fe::local_stiffness(layer, {0.0, 0.0, 0.2}, {}).isApprox(uniform(0.2), 1e-12));
    EXPECT_TRUE(fe::local_stiffness(layer, {3.0, 0.0, 0.2}, {}).isApprox(uniform(1.0), 1e-9));
}

TEST(SubgradeStressDependence, OfSizeZeroIsTheLinearLayerAndSoftensWithTheLoad) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.0, .k3 = 0.0, .n = 0.4}); // linear without the effect
    const auto plain = values_of(c);
    const auto present = values_of(with(c, *find_effect("subgrade-stress-dependence"), 0.0, true));
    EXPECT_LT(largest_change(present, plain), 1e-9);
    Case doubled = c;
    doubled.loads[0].pressure *= 2.0;
    const auto soft = values_of(with(c, "subgrade-stress-dependence", -2.0));
    const auto soft_doubled = values_of(with(doubled, "subgrade-stress-dependence", -2.0));
    for (const std::size_t i : {0U, 3U, 4U}) {
        EXPECT_GT(soft_doubled[i] / soft[i], 2.005);
        EXPECT_NEAR(values_of(doubled)[i] / plain[i], 2.0, 1e-9);
    }
}

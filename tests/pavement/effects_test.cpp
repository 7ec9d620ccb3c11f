// The catalogue of effects: every one of it without being asked, and the mechanics of each against closed forms.
#include "pavement/effects/catalog.h"
#include "reference/multilayer_elastic.h"
#include "support/differences.h"
#include "support/sections.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numbers>

namespace pave::pavement {
void PrintTo(const Effect* effect, std::ostream* stream) {
    *stream << effect->name;
}
} // namespace pave::pavement

using namespace test;

namespace {

Load circular_wheel() {
    Load load;
    load.name = "wheel";
    load.type = LoadType::wheel;
    load.patch = Patch::circle;
    load.force = 40e3;
    load.pressure = 650e3;
    return load;
}

// What every effect finds something in: a plate and a circular wheel, deflections, gauges and points.
Case axisymmetric_case(Integration integration = Integration::incremental) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4, .eta = 0.3}, integration);
    c.loads.push_back(circular_wheel());
    c.sensors = {deflection(0.0), deflection(0.45), strain_zz(0.1875, 0.075), strain_zz(0.42, 0.0)};
    c.sensors.push_back({1, Quantity::strain_zz, 0.08, 0.0, 0.2, 0.075});
    c.sensors.push_back({1, Quantity::strain_zz, 0.05, 0.0, 0.45, 0.0});
    c.sensors.push_back({1, Quantity::deflection, 0.21, 0.0, 0.0, 0.0});
    c.sensors.push_back({1, Quantity::stress_zz, 0.05, 0.0, 0.25, 0.0});
    c.settings.refine = 0.5;
    return c;
}

Case solid_case() {
    Case c = axisymmetric_case();
    c.loads = {dual_wheel()};
    c.sensors = {deflection(0.17),
                 strain_zz(0.1875, 0.075, 0.17),
                 strain_zz(0.42, 0.0, 0.15),
                 {0, Quantity::stress_xx, 0.1, 0.0, 0.25, 0.0}};
    c.settings.extent = 2.0;
    c.settings.refine = 0.4;
    c.settings.solver.linear_tolerance = 1e-11;
    return c;
}

Case with(Case c, const Effect& effect, double size, bool present = false) {
    AppliedEffect applied;
    applied.effect = &effect;
    applied.size = size;
    applied.present = present;
    c.effects.push_back(std::move(applied));
    return c;
}
Case with(Case c, std::string_view name, double size) {
    return with(std::move(c), *find_effect(name), size);
}

std::vector<double> values_of(const Case& c) {
    const auto response = test::run(c);
    EXPECT_TRUE(response) << response.failure().reason;
    return response ? response->values : std::vector<double>(c.sensors.size(), 0.0);
}

double largest_change(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, std::abs(a[i] / b[i] - 1.0));
    }
    return largest;
}

const Case& shared_axisymmetric_case() {
    static const Case c = axisymmetric_case();
    return c;
}

class EveryEffect : public testing::TestWithParam<const Effect*> {};

// A linear half-space under a plate, deep and wide.
Case half_space(double modulus, double poisson) {
    Case c;
    c.layers = {linear_layer("soil", 30.0, modulus, poisson)};
    c.loads = {plate(0.15, 600e3)};
    c.sensors = {deflection(0.0)};
    c.settings.extent = 30.0;
    return c;
}

// A column of linear soil under a plate as wide as its smooth wall: everything is one-dimensional.
Case column(double modulus, double poisson, double depth, double density = 2000.0) {
    Case c;
    c.layers = {linear_layer("soil", depth, modulus, poisson)};
    c.layers[0].density = density;
    c.settings.extent = 0.5;
    c.loads = {plate(0.4999999, 100e3)};
    c.sensors = {deflection(0.0)};
    c.settings.refine = 4.0;
    return c;
}
double oedometric(double modulus, double poisson) {
    return modulus * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
}

// The section of a case, solved once, and its sensors under pulses of its load.
struct Pulsed {
    Parts<Axisymmetric> parts;
    fe::Solver<fe::AxisymmetricQ8> solver;
    std::vector<fe::Variation> no_variations; // which the solver refers to
    fe::Solution<fe::AxisymmetricQ8> solved;
    std::vector<fe::Functional<fe::AxisymmetricQ8>> readings;
    Eigen::ArrayXd at_rest;

    explicit Pulsed(const Case& c)
        : parts(parts_of<Axisymmetric>(c, 0)),
          solver(parts.model),
          solved(solver.incremental(parts.layers, parts.load, no_variations, {}).value()),
          at_rest(c.sensors.size()) {
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            readings.push_back(observe(c.sensors[i], parts.mesh, parts.model, parts.mesh));
            at_rest[static_cast<Eigen::Index>(i)] = readings[i].of_displacement(solved.displacement.data());
        }
    }
    // What inertia adds to the extremes.
    Eigen::ArrayXd excess(const fe::Pulse& pulse) {
        const auto result = solver.inertial_excess(solved, parts.load, pulse, readings).value();
        return Eigen::Map<const Eigen::ArrayXd>(result.values.data(), at_rest.size());
    }
    Eigen::ArrayXd peaks(const fe::Pulse& pulse) { return at_rest + excess(pulse); }
};

// Sensors where the wall would throw the waves back, did it not absorb them.
Case near_the_wall() {
    Case c;
    c.layers = {linear_layer("subgrade", 2.0, 60e6, 0.4)};
    c.layers[0].density = 2000.0;
    c.loads = {plate()};
    c.settings.extent = 2.0;
    c.sensors = {deflection(1.5), deflection(1.8)};
    return c;
}

bool is_exact(const Case& c, std::string_view path) {
    return exact_derivative(c, find_parameter(c, path, {}), 0).has_value();
}

Case three_layers() {
    Case c;
    c.layers = {linear_layer("asphalt", 0.15, 3000e6, 0.35), linear_layer("base", 0.3, 300e6, 0.35),
                linear_layer("subgrade", 1.5, 60e6, 0.40)};
    c.loads = {plate(0.15, 600e3)};
    c.settings.extent = 8.0;
    return c;
}

} // namespace

TEST_P(EveryEffect, ChangesNoBitAtItsNullSize) {
    const Case& c = shared_axisymmetric_case();
    static const std::vector<double> plain = values_of(c);
    EXPECT_EQ(values_of(with(c, *GetParam(), GetParam()->null)), plain);
    static const auto slopes = test::run(c, {"base.k1", "fwd.pressure_kPa"})->jacobian;
    EXPECT_EQ(test::run(with(c, *GetParam(), GetParam()->null), {"base.k1", "fwd.pressure_kPa"})->jacobian, slopes);
}

TEST_P(EveryEffect, ChangesSomeResponseAtItsTypicalSizeAndKeepsTheNullInItsRange) {
    const Effect& e = *GetParam();
    EXPECT_LE(e.low, e.null);
    EXPECT_GE(e.high, e.null);
    EXPECT_GT(e.typical, e.low);
    EXPECT_LT(e.typical, e.high);
    EXPECT_EQ(why_impossible(shared_axisymmetric_case(), {.effect = &e}), "");
    static const std::vector<double> plain = values_of(shared_axisymmetric_case());
    EXPECT_GT(largest_change(values_of(with(shared_axisymmetric_case(), e, e.typical)), plain), 0.005);
}

TEST_P(EveryEffect, ChangesSomeResponseInThreeDimensionsOrRefuses) {
    const Effect& e = *GetParam();
    const Case c = solid_case();
    if (const std::string why = why_impossible(c, {.effect = &e}); !why.empty()) {
        EXPECT_NE(why.find("plate"), std::string::npos) << why;
        return;
    }
    static const std::vector<double> plain = values_of(c);
    EXPECT_GT(largest_change(values_of(with(c, e, e.typical)), plain), 0.005);
    EXPECT_EQ(values_of(with(c, e, e.null)), plain);
}

// Modelled at its null size, the effect may change the mesh but not what it stands for.
TEST_P(EveryEffect, IsContinuousAtItsNullSize) {
    static const std::vector<double> plain = values_of(shared_axisymmetric_case());
    EXPECT_LT(largest_change(values_of(with(shared_axisymmetric_case(), *GetParam(), GetParam()->null, true)), plain),
              0.005);
}

namespace {

// Returns how many parameters were compared: where the load path takes other steps nearby there is no difference
// quotient.
int expect_derivatives(const Case& plain, const Effect& e) {
    const Case c = with(plain, e, e.typical, true);
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    std::vector<Parameter> parameters;
    for (const std::string& path :
         {std::string(e.name) + ".size", std::string("base.k1"), std::string("subgrade.modulus_MPa"),
          std::string("asphalt.poisson"), std::string("base.thickness_mm"), std::string("fwd.radius_mm")}) {
        parameters.push_back(find_parameter(c, path, {}));
    }
    const auto exact = model.run(c, parameters, *workspace);
    EXPECT_TRUE(exact);
    int compared = 0;
    for (std::size_t k = 0; exact && k < parameters.size(); ++k) {
        const double value = parameters[k].get(c);
        const double h = 2e-4 * (k == 0 ? e.high - e.low : std::abs(value));
        const auto differences = central_differences(model, c, parameters[k], h, *exact, *workspace);
        EXPECT_TRUE(differences);
        if (!differences || !differences->same_path) {
            continue;
        }
        ++compared;
        const double range = k == 0 ? e.high - e.low : value;
        const auto [worst, most] = disagreement(*exact, k, range, differences->rates);
        EXPECT_LT(worst, 2e-4 * most + 1e-7) << parameters[k].path;
    }
    return compared;
}

} // namespace

TEST_P(EveryEffect, HasTheDerivativeOfCentralDifferences) {
    EXPECT_EQ(expect_derivatives(axisymmetric_case(Integration::secant), *GetParam()), 6);
}

TEST_P(EveryEffect, HasTheDerivativeWhereTheAnisotropyFollowsTheStressOrRefuses) {
    Case c = axisymmetric_case();
    c.layers[1].law = material::find_law("uzan-separate");
    c.layers[1].parameters = {2000, 0.4, -0.3, 700, 0.7, -0.5, 600, 0.5, -0.2, 0.03, 1.0, 0.3, 0.35, 5e3, 0.3};
    if (why_impossible(c, {.effect = GetParam()}).empty()) {
        EXPECT_GE(expect_derivatives(c, *GetParam()), 3);
    } else {
        const auto name = GetParam()->name;
        EXPECT_TRUE(name == "anisotropy-distribution" || name == "shear-ratio") << "n and G13/E3 are no parameters";
    }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(effects().begin(), effects().end()),
                         [](const auto& tested) {
                             std::string name(tested.param->name);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

TEST(Effects, AreThoseOfTheCatalogueEachOnce) {
    std::vector<std::string_view> names;
    for (const Effect* e : effects()) {
        names.push_back(e->name);
        EXPECT_EQ(find_effect(e->name), e);
        EXPECT_FALSE(e->mechanism.empty() || e->source.empty() || e->unit.empty() || e->acts_on.empty());
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    EXPECT_EQ(names.size(), 22U);
}

// Boussinesq: flexible 2 p a (1 - nu^2)/E at the centre; the rigid punch pi/2 p a (1 - nu^2)/E everywhere under it.
// By name, else by the rules that effect.h states.
TEST(Effects, FindTheLayersTheyActOn) {
    const auto roles = [](const std::vector<Layer>& layers) {
        Case c;
        c.layers = layers;
        std::vector<int> found;
        for (const LayerRole role : {LayerRole::asphalt, LayerRole::base, LayerRole::subgrade, LayerRole::none}) {
            const auto layer = layer_of_role(c, role);
            found.push_back(layer ? static_cast<int>(*layer) : -1);
        }
        return found;
    };
    const auto linear = [](const char* name) { return linear_layer(name, 0.2, 1e8, 0.3); };
    const auto granular = [](const char* name) {
        return uzan_layer(name, 0.2, {.k1 = 1000, .k2 = 0.5, .k3 = -0.3, .n = 0.5});
    };
    using Found = std::vector<int>;
    EXPECT_EQ(roles({linear("subgrade"), linear("base"), linear("asphalt")}), (Found{2, 1, 0, -1}));
    EXPECT_EQ(roles({linear("a"), linear("b"), granular("c"), granular("d"), linear("e")}), (Found{0, 2, 4, -1}));
    EXPECT_EQ(roles({linear("a"), linear("b"), linear("c"), linear("d")}), (Found{0, 2, 3, -1}));
    EXPECT_EQ(roles({linear("a"), linear("b"), granular("c")}), (Found{0, 1, 2, -1})); // the lowest is no base
    EXPECT_EQ(roles({granular("a")}), (Found{-1, -1, 0, -1}));
}

TEST(PlateRigidity, GoesFromTheFlexiblePlateToTheRigidPunch) {
    const double e = 50e6, nu = 0.35;
    Case c = half_space(e, nu);
    c.sensors = {deflection(0.0), deflection(0.075), deflection(0.14)};
    c.settings.refine = 4.0; // the pressure of the punch is singular at its edge
    const double unit = 600e3 * 0.15 * (1 - nu * nu) / e;
    EXPECT_NEAR(values_of(c)[0] / (2.0 * unit), 1.0, 0.01);
    const auto rigid = values_of(with(c, "plate-rigidity", 0.999));
    for (const double w : rigid) {
        EXPECT_NEAR(w / (std::numbers::pi / 2.0 * unit), 1.0, 0.012);
    }
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

TEST(LoadMagnitude, ScalesALinearSection) {
    Case c = three_layers();
    c.sensors = {deflection(0.0), strain_zz(0.5, 0.0)};
    const auto plain = values_of(c);
    const auto more = values_of(with(c, "load-magnitude", 1.3));
    for (std::size_t i = 0; i < plain.size(); ++i) {
        EXPECT_NEAR(more[i] / plain[i], 1.3, 1e-12);
    }
}

TEST(SensorsThatErr, AreReadWhereTheyAreAndTimesTheirGain) {
    Case c = axisymmetric_case();
    const auto plain = values_of(c);
    // The same places asked for without an effect, on the mesh that the effect makes too.
    Case moved = c;
    for (Sensor& sensor : moved.sensors) {
        if (sensor.quantity != Quantity::deflection) {
            sensor.depth += 0.012;
        }
    }
    EXPECT_EQ(values_of(with(c, "gauge-depth", 12.0)), values_of(moved));
    moved = c;
    moved.sensors[2].gauge += 0.05;
    moved.sensors[4].gauge += 0.05;
    const auto longer = values_of(with(c, "gauge-length", 50.0));
    EXPECT_NEAR(longer[2] / values_of(moved)[2], 1.0, 1e-9);
    moved = c;
    for (const std::size_t i : {2U, 3U, 4U, 5U, 6U, 7U}) {
        moved.sensors[i].x -= 0.03;
    }
    EXPECT_EQ(values_of(with(c, "load-offset", 30.0)), values_of(moved));
    const auto gain = values_of(with(c, "sensor-gain", 1.2));
    const auto outlier = values_of(with(c, "outlier", -0.25));
    for (std::size_t i = 0; i < plain.size(); ++i) {
        EXPECT_DOUBLE_EQ(gain[i], i < 2 ? 1.2 * plain[i] : plain[i]);
        EXPECT_DOUBLE_EQ(outlier[i], i < 1 ? 0.75 * plain[i] : plain[i]);
    }
    // What is asked for and not measured has no instrument.
    c.sensors[0].measured = false;
    EXPECT_EQ(why_impossible(c, {.effect = find_effect("outlier")}), "no such reading");
}

TEST(EffectsOnNumbers, AreTheSectionWithThoseNumbers) {
    const Case c = axisymmetric_case();
    const auto differs = [&](std::string_view name, double size, const auto& change) {
        Case changed = c;
        change(changed);
        return largest_change(values_of(with(c, name, size)), values_of(changed));
    };
    EXPECT_EQ(differs("base-thickness", 20.0,
                      [](Case& s) {
                          s.layers[1].thickness += 0.02;
                          s.layers[2].thickness -= 0.02;
                      }),
              0.0);
    EXPECT_EQ(differs("base-residual-stress", 15.0, [](Case& s) { s.layers[1].residual_stress += 15e3; }), 0.0);
    EXPECT_LT(differs("base-tension", std::log(2.0), [](Case& s) { s.layers[1].parameters[8] /= 2.0; }), 1e-9);
    // Without shear_ratio 1/G13 = 1/E1 + (1 + 2 nu31)/E3.
    EXPECT_LT(differs("shear-ratio", 0.5, [](Case& s) { s.layers[1].parameters[7] = 0.5 / (1.0 / 0.4 + 1.7); }), 1e-9);
    // The modulus under the second load only.
    const auto plain = values_of(c);
    const auto rate = values_of(with(c, "asphalt-modulus-rate", 0.5));
    Case soft = c;
    soft.layers[0].parameters[0] *= 0.5;
    const auto everywhere = values_of(soft);
    for (std::size_t i = 0; i < plain.size(); ++i) {
        EXPECT_EQ(rate[i], c.sensors[i].load == 0 ? plain[i] : everywhere[i]);
    }
}

// The mean over a normal distribution, by the trapezium rule over 6 standard deviations instead of Gauss-Hermite.
TEST(WheelWander, IsTheMeanOverANormalDistribution) {
    Case c = axisymmetric_case();
    c.loads = {circular_wheel()};
    c.sensors = {{0, Quantity::strain_zz, 0.05, 0.0, 0.45, 0.075}};
    const double wander = values_of(with(c, "wheel-wander", 60.0))[0];
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    double sum = 0.0, weights = 0.0;
    for (int k = -60; k <= 60; ++k) {
        Case moved = c;
        moved.sensors[0].x += 0.06 * k / 10.0;
        const double weight = std::exp(-0.5 * k * k / 100.0);
        sum += weight * model.run(moved, {}, *workspace)->values[0];
        weights += weight;
    }
    EXPECT_NEAR(wander / (sum / weights), 1.0, 2e-3);
}

// The equation of motion of a column under a haversine pulse, summed over its modes (free top, fixed floor):
// w(0, t) = sum_k 2 p/(rho H) int sin^2(pi s/T) sin(omega_k (t - s))/omega_k ds, omega_k = (2 k - 1) pi c/(2 H).
TEST(Inertia, OfAColumnIsTheSumOfItsModes) {
    const double e = 30e6, nu = 0.3, rho = 2000.0, depth = 1.5;
    Case c = column(e, nu, depth, rho);
    const double statics = values_of(c)[0];
    EXPECT_NEAR(statics / (100e3 * depth / oedometric(e, nu)), 1.0, 1e-5);
    const double wave = std::sqrt(oedometric(e, nu) / rho);
    Pulsed section(c);
    for (const double duration : {0.03, 0.06, 0.3}) {
        const double computed =
            section.peaks({.duration = duration, .damping = 0.0, .inertia = 1.0, .absorbs = false})[0];
        double peak = 0.0;
        for (double t = 0.0; t <= 4.0 / 3.0 * duration; t += duration / 400.0) {
            double w = 0.0;
            for (int k = 1; k <= 1000; ++k) { // the rest of the static sum: 2e-4
                const double omega = (2 * k - 1) * std::numbers::pi * wave / (2.0 * depth);
                // int_0^min(t,T) (1 - cos(b s))/2 sin(omega (t - s)) ds, b = 2 pi/T
                const double b = 2.0 * std::numbers::pi / duration;
                const auto antiderivative = [&](double s) {
                    return std::cos(omega * (t - s)) / (2.0 * omega) -
                           (std::cos(omega * t + (b - omega) * s) / (omega - b) +
                            std::cos(omega * t - (b + omega) * s) / (omega + b)) /
                               4.0;
                };
                w +=
                    2.0 * 100e3 / (rho * depth) / omega * (antiderivative(std::min(t, duration)) - antiderivative(0.0));
            }
            peak = std::abs(w) > std::abs(peak) ? w : peak;
        }
        EXPECT_NEAR(computed / peak, 1.0, 1e-3) << duration;
    }
}

// A column so slender that the drag of its wall, Z = rho c_s on 2/R of its volume, is all that resists in time:
// (2 Z/R) dw/dt = M d2w/dz2 under a haversine pressure, summed over its modes as above. Inertia is 1/70 of the drag.
TEST(Inertia, OfASlenderColumnIsTheDragOfItsWall) {
    const double e = 30e6, nu = 0.3, rho = 2000.0, depth = 1.5, radius = 0.02, duration = 0.06;
    Case c = column(e, nu, depth, rho);
    c.settings.extent = radius;
    c.loads = {plate(0.999999 * radius, 100e3)};
    c.settings.refine = 2.0;
    Pulsed section(c);
    const double computed = section.peaks({.duration = duration, .damping = 0.0, .inertia = 1.0, .absorbs = true})[0];
    const double drag = 2.0 / radius * std::sqrt(rho * e / (2.0 * (1.0 + nu)));
    const double b = 2.0 * std::numbers::pi / duration;
    double peak = 0.0;
    for (double t = 0.5 * duration; t <= duration; t += duration / 400.0) {
        double w = 0.0;
        for (int k = 1; k <= 1000; ++k) {
            const double kappa = (2 * k - 1) * std::numbers::pi / (2.0 * depth);
            const double rate = oedometric(e, nu) / drag * kappa * kappa;
            w += 100e3 / (depth * drag) *
                 ((1.0 - std::exp(-rate * t)) / rate -
                  (rate * (std::cos(b * t) - std::exp(-rate * t)) + b * std::sin(b * t)) / (rate * rate + b * b));
        }
        peak = std::max(peak, w);
    }
    EXPECT_NEAR(computed / peak, 1.0, 2e-3);
}

// What the wall absorbs is that of its own motion, whatever the size of the elements beside it.
TEST(Inertia, AtTheWallConvergesWithTheMesh) {
    Case c = near_the_wall();
    const auto excess = [&](double refine, bool absorbs) {
        c.settings.refine = refine;
        return Pulsed(c).excess({.duration = 0.03, .damping = 0.02, .inertia = 1.0, .absorbs = absorbs});
    };
    const Eigen::ArrayXd coarse = excess(1.0, true);
    const Eigen::ArrayXd fine = excess(3.0, true);
    const Eigen::ArrayXd absorbed = excess(3.0, false) - fine;
    EXPECT_LT((coarse - fine).abs().maxCoeff(), 0.01 * absorbed.abs().minCoeff());
}

TEST(Inertia, AtTheWallHasItsDerivatives) {
    const Case c = with(near_the_wall(), "inertia", 1.0);
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    for (const auto& [path, h] : {std::pair{"subgrade.density_kg_m3", 2.0}, {"subgrade.modulus_MPa", 0.1}}) {
        const Parameter parameter = find_parameter(c, path, {});
        const auto exact = model.run(c, {parameter}, *workspace);
        ASSERT_TRUE(exact);
        const auto differences = central_differences(model, c, parameter, h, *exact, *workspace);
        ASSERT_TRUE(differences);
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const double rate = differences->rates[i];
            EXPECT_NEAR(exact->jacobian(static_cast<Eigen::Index>(i), 0), rate, 1e-6 * std::abs(rate))
                << path << " " << i;
        }
    }
}

// The peak lies between two steps of time, at another place of them for every duration; what is read there is smooth.
TEST(Inertia, PeaksAreSmoothInTheDuration) {
    const Case c = column(30e6, 0.3, 1.5, 2000.0);
    Pulsed section(c);
    constexpr int count = 31, degree = 8;
    Eigen::MatrixXd powers(count, degree + 1);
    Eigen::VectorXd peaks(count);
    for (int i = 0; i < count; ++i) {
        const double x = 2.0 * i / (count - 1) - 1.0;
        peaks[i] = section.peaks({.duration = 0.05 + 0.01 * x, .damping = 0.05, .inertia = 1.0, .absorbs = false})[0];
        for (int k = 0; k <= degree; ++k) {
            powers(i, k) = std::pow(x, k);
        }
    }
    const Eigen::VectorXd smooth = powers * powers.colPivHouseholderQr().solve(peaks);
    EXPECT_LT(((peaks - smooth).array() / peaks.array()).abs().maxCoeff(), 1e-5); // half a step off the peak: 4e-4
}

TEST(Inertia, IsSmallForASlowPulseAndLiftsTheFarDeflectionsOfAFastOne) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4});
    const auto plain = values_of(c);
    const auto nearly = values_of(with(c, "inertia", 1e-4));
    const auto full = values_of(with(c, "inertia", 1.0));
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(nearly[i] / plain[i], 1.0, 1e-3);
    }
    EXPECT_GT(full[4] / plain[4], 1.2); // at 900 mm
    EXPECT_GT(full[4] / plain[4], full[0] / plain[0]);
}

// The solver's own derivatives, by interface springs and by fields, in three dimensions.
TEST(Effects, HaveTheirDerivativesInThreeDimensions) {
    for (const std::string_view name :
         {"interface-slip-base-subgrade", "anisotropy-distribution", "subgrade-depth-gradient"}) {
        const Effect& e = *find_effect(name);
        const Case c = with(solid_case(), e, e.typical);
        const ForwardModel model(c);
        const auto workspace = model.make_workspace();
        const auto exact = model.run(c, {find_parameter(c, std::string(name) + ".size", {})}, *workspace);
        ASSERT_TRUE(exact) << exact.failure().reason;
        const double h = 1e-3 * (e.high - e.low);
        std::vector<std::vector<double>> sides;
        for (const double offset : {-h, h}) {
            Case moved = c;
            moved.effects[0].size += offset;
            sides.push_back(model.run(moved, {}, *workspace)->values);
        }
        double most = 0.0;
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            most = std::max(most, std::abs((sides[1][i] - sides[0][i]) / (2.0 * h) / exact->values[i]));
        }
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            EXPECT_NEAR(exact->jacobian(static_cast<Eigen::Index>(i), 0) / exact->values[i],
                        (sides[1][i] - sides[0][i]) / (2.0 * h) / exact->values[i], 1e-3 * most)
                << name << " " << i;
        }
    }
}

TEST(Effects, OfTwoOnOneLayerComposeInEitherOrder) {
    const Case& c = shared_axisymmetric_case();
    const auto weak = with(with(c, "weak-subgrade-top", 0.7), "subgrade-stress-dependence", -1.0);
    const auto soft = with(with(c, "subgrade-stress-dependence", -1.0), "weak-subgrade-top", 0.7);
    EXPECT_LT(largest_change(values_of(weak), values_of(soft)), 1e-9);
}

TEST(Effects, RefuseWhatTheyCannotActOn) {
    Case dual = solid_case();
    EXPECT_NE(why_impossible(dual, {.effect = find_effect("plate-rigidity")}), "");
    EXPECT_NE(why_impossible(dual, {.effect = find_effect("inertia")}), "");
    Case fwd = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4});
    EXPECT_NE(why_impossible(fwd, {.effect = find_effect("wheel-wander")}), "");
    Case linear = three_layers();
    EXPECT_NE(why_impossible(linear, {.effect = find_effect("anisotropy-distribution")}), "");
    EXPECT_NE(why_impossible(linear, {.effect = find_effect("base-tension")}), "");
}

// A motion of the mesh holds neither springs nor fields, nor what moves in time.
TEST(Effects, LeaveGeometryToAMotionOfTheMeshWhereItHoldsAll) {
    const Case& plain = shared_axisymmetric_case();
    for (const std::string_view path : {"base.thickness_mm", "subgrade.thickness_mm", "fwd.radius_mm"}) {
        EXPECT_TRUE(is_exact(plain, path)) << path;
        for (const std::string_view name : {"weak-subgrade-top", "load-magnitude", "contact-pressure-shape",
                                            "base-thickness", "gauge-length", "sensor-gain", "shear-ratio"}) {
            EXPECT_TRUE(is_exact(with(plain, name, find_effect(name)->typical), path)) << name << " " << path;
        }
        for (const std::string_view name : {"anisotropy-distribution", "subgrade-depth-gradient", "plate-rigidity",
                                            "interface-slip-base-subgrade", "inertia"}) {
            EXPECT_FALSE(is_exact(with(plain, name, find_effect(name)->typical), path)) << name << " " << path;
        }
    }
}

// Of what inertia moves only its own time has no derivative.
TEST(Effects, LeaveLoadsTheirExactDerivatives) {
    const Case& plain = shared_axisymmetric_case();
    const Case moving = with(plain, "inertia", 1.0);
    EXPECT_TRUE(is_exact(plain, "fwd.pressure_kPa"));
    EXPECT_TRUE(is_exact(plain, "fwd.duration_ms"));
    EXPECT_TRUE(is_exact(moving, "fwd.pressure_kPa"));
    EXPECT_FALSE(is_exact(moving, "fwd.duration_ms"));
}

// The catalogue of effects: what holds for every one of it without being asked.
#include "support/differences.h"
#include "support/effects.h"

namespace pave::pavement {
void PrintTo(const Effect* effect, std::ostream* stream) {
    *stream << effect->name;
}
} // namespace pave::pavement

using namespace test;

namespace {

const Case& shared_axisymmetric_case() {
    static const Case c = axisymmetric_case();
    return c;
}

// In which the effect finds something to act on.
Case case_of(const Effect& e, Integration integration = Integration::incremental) {
    const Case& at_rest = shared_axisymmetric_case();
    return why_impossible(at_rest, {.effect = &e}).empty() ? axisymmetric_case(integration) : in_motion(at_rest);
}

class EveryEffect : public testing::TestWithParam<const Effect*> {};

bool is_exact(const Case& c, std::string_view path) {
    return exact_derivative(c, find_parameter(c, path, {}), 0).has_value();
}

} // namespace

TEST_P(EveryEffect, ChangesNoBitAtItsNullSize) {
    const Case c = case_of(*GetParam());
    EXPECT_EQ(values_of(with(c, *GetParam(), GetParam()->null)), values_of(c));
    const auto slopes = test::run(c, {"base.k1", "fwd.pressure_kPa"})->jacobian;
    EXPECT_EQ(test::run(with(c, *GetParam(), GetParam()->null), {"base.k1", "fwd.pressure_kPa"})->jacobian, slopes);
}

TEST_P(EveryEffect, ChangesSomeResponseAtItsTypicalSizeAndKeepsTheNullInItsRange) {
    const Effect& e = *GetParam();
    EXPECT_LE(e.low, e.null);
    EXPECT_GE(e.high, e.null);
    EXPECT_GT(e.typical, e.low);
    EXPECT_LT(e.typical, e.high);
    const Case c = case_of(e);
    EXPECT_EQ(why_impossible(c, {.effect = &e}), "");
    EXPECT_GT(largest_change(values_of(with(c, e, e.typical)), values_of(c)), 0.005);
}

TEST_P(EveryEffect, ChangesSomeResponseInThreeDimensionsOrRefuses) {
    const Effect& e = *GetParam();
    const Case c = solid_case();
    if (const std::string why = why_impossible(c, {.effect = &e}); !why.empty()) {
        EXPECT_TRUE(why.find("plate") != std::string::npos || why.find("history") != std::string::npos ||
                    e.name == "drift")
            << why;
        return;
    }
    static const std::vector<double> plain = values_of(c);
    EXPECT_GT(largest_change(values_of(with(c, e, e.typical)), plain), 0.005);
    EXPECT_EQ(values_of(with(c, e, e.null)), plain);
}

// Modelled at its null size, the effect may change the mesh but not what it stands for.
TEST_P(EveryEffect, IsContinuousAtItsNullSize) {
    const Case c = case_of(*GetParam());
    EXPECT_LT(largest_change(values_of(with(c, *GetParam(), GetParam()->null, true)), values_of(c)), 0.005);
}

namespace {

// Returns how many parameters were compared: where the secant equilibrium is continued through other loads nearby there
// is no difference quotient.
int expect_derivatives(const Case& plain, const Effect& e) {
    Case c = with(plain, e, e.typical, true);
    if (e.name == "wheel-wander") {
        // From cell to cell the places where a point is read step from one polynomial to the next: no quotient is
        // smooth.
        std::erase_if(c.sensors, [](const Sensor& s) { return s.quantity != Quantity::deflection && s.gauge == 0.0; });
    }
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
    EXPECT_EQ(expect_derivatives(case_of(*GetParam(), Integration::secant), *GetParam()), 6);
}

TEST_P(EveryEffect, HasTheDerivativeWhereTheAnisotropyFollowsTheStressOrRefuses) {
    Case c = axisymmetric_case();
    c.layers[1].law = material::find_law("uzan-separate");
    c.layers[1].parameters = {2000, 0.4, -0.3, 700, 0.7, -0.5, 600, 0.5, -0.2, 0.03, 1.0, 0.3, 0.35, 5e3, 0.3};
    if (why_impossible(c, {.effect = GetParam()}).empty()) {
        EXPECT_EQ(expect_derivatives(c, *GetParam()), 6);
    } else {
        const auto name = GetParam()->name;
        const bool is_in_time = !why_impossible(axisymmetric_case(), {.effect = GetParam()}).empty();
        EXPECT_TRUE(is_in_time || name == "anisotropy-distribution" || name == "shear-ratio")
            << "n and G13/E3 are no parameters";
    }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(effects().begin(), effects().end()),
                         [](const auto& tested) {
                             std::string name(tested.param->name);
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

// exp(1) = 2.7, exp(-0.7) = 50 %, 1/(1 - 0.5) - 1 = 1 mm/MPa.
TEST(Effects, SayInWordsWhichWayAndHowMuch) {
    const auto words = [](const char* name, double size) {
        return find_effect(name)->in_words({.effect = find_effect(name), .size = size});
    };
    EXPECT_EQ(words("weak-subgrade-top", -1.0), "the top 200 mm of the subgrade have 2.7 times the stated modulus");
    EXPECT_EQ(words("weak-subgrade-top", 0.7), "the top 200 mm of the subgrade have 50 % of the stated modulus");
    EXPECT_EQ(words("load-magnitude", 0.91), "the load is 9.0 % below what is stated");
    EXPECT_EQ(words("gauge-depth", -12.0), "gauges sit 12 mm higher than stated");
    EXPECT_EQ(words("interface-slip-asphalt-base", 0.5), "the shear spring between the layers yields by 1.0 mm/MPa");
    for (const Effect* e : effects()) {
        ASSERT_NE(e->in_words, nullptr) << e->name;
        EXPECT_NE(e->in_words({.effect = e, .size = e->typical}), "") << e->name;
    }
}

TEST(Effects, AreThoseOfTheCatalogueEachOnce) {
    std::vector<std::string_view> names;
    for (const Effect* e : effects()) {
        names.push_back(e->name);
        EXPECT_EQ(find_effect(e->name), e);
        EXPECT_FALSE(e->mechanism.empty() || e->source.empty() || e->unit.empty() || e->acts_on.empty());
    }
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
    EXPECT_EQ(names.size(), 32U);
}

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

TEST(Effects, SayWhichLayerAloneTheyStiffen) {
    const Case& c = shared_axisymmetric_case();
    const auto layer = [&](const char* name) { return layer_stiffened(c, {.effect = find_effect(name)}); };
    for (const char* name : {"weak-subgrade-top", "subgrade-depth-gradient", "subgrade-stress-dependence"}) {
        EXPECT_EQ(layer(name), "subgrade") << name;
    }
    for (const char* name : {"base-modulus-gradient", "base-tension", "shear-ratio"}) {
        EXPECT_EQ(layer(name), "base") << name;
    }
    for (const char* name : {"interface-slip-base-subgrade", "base-thickness", "floor-depth", "base-residual-stress",
                             "asphalt-modulus-rate", "gauge-depth", "load-magnitude", "sensor-gain", "inertia"}) {
        EXPECT_EQ(layer(name), "") << name;
    }
}

// The solver's own derivatives, by interface springs and by fields, in three dimensions.
TEST(Effects, HaveTheirDerivativesInThreeDimensions) {
    for (const std::string_view name : {"interface-slip-base-subgrade", "anisotropy-distribution",
                                        "subgrade-depth-gradient", "base-modulus-gradient", "subgrade-anisotropy"}) {
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

// A motion of the mesh holds neither springs nor fields, nor what inertia adds to the load at rest.
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

// So are the derivatives by sizes that move layers; those by sizes that move sensors alone are read on the way, though
// a number that the law was not given is equal to none.
TEST(Effects, NeedNoFurtherRunForTheDerivativeByTheirSizeWhereTheyMoveLayersOrSensors) {
    Case plain = shared_axisymmetric_case();
    plain.layers[1].parameters[*plain.layers[1].law->index_of("poisson_12")] = material::not_given;
    for (const std::string_view name : {"base-thickness", "floor-depth"}) {
        EXPECT_TRUE(is_exact(with(plain, *find_effect(name), 0.0, true), std::string(name) + ".size")) << name;
    }
    const auto moves_sensors_alone = [&](std::string_view name) {
        const Effect& e = *find_effect(name);
        return differ_in_sensors_alone(with_effects(with(plain, e, e.typical), 0),
                                       with_effects(with(plain, e, e.typical / 2.0), 0), 0);
    };
    for (const std::string_view name : {"sensor-position", "gauge-depth", "gauge-length", "load-offset"}) {
        EXPECT_TRUE(moves_sensors_alone(name)) << name;
    }
    for (const std::string_view name : {"base-thickness", "floor-depth", "load-magnitude", "plate-rigidity"}) {
        EXPECT_FALSE(moves_sensors_alone(name)) << name;
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

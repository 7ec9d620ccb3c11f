// Every effect is another case written out: a section, sensors elsewhere, or a sum of runs.
#include "support/effects.h"

#include "pavement/load_model.h"

using namespace test;

namespace {

Case shared() {
    static const Case c = axisymmetric_case();
    return c;
}

// The largest difference between a case with an effect and the same case changed by hand.
template <class F>
double differs(const Case& c, std::string_view name, double size, const F& change) {
    Case changed = c;
    change(changed);
    return largest_change(values_of(with(c, name, size)), values_of(changed));
}

Layer soil_of(double modulus, double poisson, const Uzan& u) {
    Layer layer = uzan_layer("subgrade", 1.193, u);
    layer.parameters[0] = 1.0; // the vertical modulus is the one that is stated
    layer.parameters[1] = modulus / 100e3;
    layer.parameters[5] = layer.parameters[6] = poisson;
    layer.parameters[9] = 0.0;
    return layer;
}

// Cuts a layer into equal parts; their modulus is that of the layer times factor(place of their middle from 0 to 1).
template <class F>
void cut(Case& c, std::size_t layer, int parts, const F& factor) {
    const Layer whole = c.layers[layer];
    c.layers.erase(c.layers.begin() + static_cast<std::ptrdiff_t>(layer));
    for (int i = parts - 1; i >= 0; --i) {
        Layer part = whole;
        part.name += std::to_string(i);
        part.thickness /= parts;
        part.parameters[whole.law->name() == "linear" ? 0 : 1] *= factor((i + 0.5) / parts);
        c.layers.insert(c.layers.begin() + static_cast<std::ptrdiff_t>(layer), part);
    }
}

} // namespace

TEST(LoadMagnitude, IsThePressureTimesTheSize) {
    EXPECT_LT(differs(shared(), "load-magnitude", 1.3, [](Case& s) { s.loads[0].pressure *= 1.3; }), 1e-12);
}

TEST(EffectsInTime, AreOtherNumbersAndALawOfTheLayers) {
    const Case c = in_motion(shared());
    EXPECT_LT(differs(c, "damping", 4.0, [](Case& s) { s.layers[2].damping_time *= 4.0; }), 1e-12);
    EXPECT_LT(differs(c, "density", 1.4, [](Case& s) { s.layers[2].density *= 1.4; }), 1e-12);
    EXPECT_LT(differs(c, "asphalt-relaxation", 0.6,
                      [](Case& s) {
                          Layer& asphalt = s.layers[0];
                          const double modulus = asphalt.parameters[0];
                          const double poisson = asphalt.parameters[1];
                          asphalt.law = material::find_law("viscoelastic");
                          asphalt.parameters = {modulus, poisson, 20.0, 20.0, 261e3, 0.6, 0.01,
                                                0.0,     0.1,     0.0,  1.0,  0.0,   10.0};
                      }),
              1e-12);
}

TEST(SubgradeStressDependence, IsALayerOfEquationOne) {
    EXPECT_LT(differs(shared(), "subgrade-stress-dependence", -1.5,
                      [](Case& s) { s.layers[2] = soil_of(40e6, 0.4, {.k1 = 400, .k2 = 0.0, .k3 = -1.5, .n = 1.0}); }),
              1e-9);
}

// a = sqrt(E1/E3): nu31 = nu/a, G13 = a E3/(2 (1 + nu)), the vertical modulus stays.
TEST(SubgradeAnisotropy, IsALayerWithThoseModuliInTwoAndThreeDimensions) {
    for (const Case& c : {shared(), solid_case()}) {
        for (const double size : {0.4, 2.0}) {
            EXPECT_LT(differs(c, "subgrade-anisotropy", size,
                              [&](Case& s) {
                                  s.layers[2] = soil_of(40e6, 0.4, {.k1 = 400, .k2 = 0.0, .k3 = 0.0, .n = size});
                                  s.layers[2].parameters[6] = 0.4 / std::sqrt(size);
                                  s.layers[2].parameters[7] = std::sqrt(size) / (2.0 * 1.4);
                              }),
                      1e-9)
                << size;
        }
    }
    const auto both = values_of(with(with(shared(), "subgrade-anisotropy", 0.5), "subgrade-stress-dependence", -1.0));
    const auto other = values_of(with(with(shared(), "subgrade-stress-dependence", -1.0), "subgrade-anisotropy", 0.5));
    EXPECT_LT(largest_change(both, other), 1e-9);
}

TEST(WeakSubgradeTop, IsASectionWithThatLayer) {
    const auto divided = [](double thickness) {
        return [=](Case& s) {
            Layer top = s.layers[2];
            top.thickness = thickness;
            top.parameters[0] *= std::exp(-0.7);
            s.layers[2].thickness -= thickness;
            s.layers.insert(s.layers.begin() + 2, top);
        };
    };
    EXPECT_LT(differs(shared(), "weak-subgrade-top", 0.7, divided(0.2)), 1e-12);
    Case thin = with(shared(), "weak-subgrade-top", 0.7);
    thin.effects[0].thickness = 0.12;
    Case changed = shared();
    divided(0.12)(changed);
    EXPECT_LT(largest_change(values_of(thin), values_of(changed)), 1e-12);
    thin.effects[0].thickness = 5.0; // at most half of the layer
    Case half = shared();
    divided(1.193 / 2.0)(half);
    EXPECT_LT(largest_change(values_of(thin), values_of(half)), 1e-12);
}

TEST(BaseSublayer, IsASectionWithThatBand) {
    const auto divided = [](double thickness, double size) {
        return [=](Case& s) {
            const double whole = s.layers[1].thickness;
            Layer part = s.layers[1];
            part.thickness = (whole - thickness) / 2.0;
            s.layers[1].thickness = thickness;
            s.layers[1].parameters[1] *= std::exp(size); // k1
            s.layers.insert(s.layers.begin() + 2, part);
            s.layers.insert(s.layers.begin() + 1, part);
        };
    };
    const double whole = shared().layers[1].thickness;
    EXPECT_LT(differs(shared(), "base-sublayer", 0.7, divided(whole / 3.0, 0.7)), 1e-12);
    EXPECT_LT(differs(shared(), "base-sublayer", -0.5, divided(whole / 3.0, -0.5)), 1e-12);
    Case thin = with(shared(), "base-sublayer", 0.7);
    thin.effects[0].thickness = 0.05;
    Case changed = shared();
    divided(0.05, 0.7)(changed);
    EXPECT_LT(largest_change(values_of(thin), values_of(changed)), 1e-12);
}

// Bonded lifts are one layer; without friction each bends by itself, as in a section of two layers that says so.
TEST(InterfaceSlipInAsphalt, IsASectionWithThatInterface) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4});
    c.layers[0].thickness = 0.12;
    const auto lifts = [](double upper, double size) {
        return [=](Case& s) {
            Layer top = s.layers[0];
            top.thickness = upper;
            top.compliance = 1e-9 * (size / (1.0 - size) + 1e-5); // 1 mm/MPa; bonded: 10 nm
            s.layers[0].thickness -= upper;
            s.layers.insert(s.layers.begin(), top);
        };
    };
    EXPECT_LT(differs(c, "interface-slip-in-asphalt", 0.5, lifts(0.06, 0.5)), 1e-9);
    EXPECT_LT(differs(c, "interface-slip-in-asphalt", 0.99, lifts(0.06, 0.99)), 1e-9);
    Case deeper = with(c, "interface-slip-in-asphalt", 0.5);
    deeper.effects[0].thickness = 0.08;
    Case changed = c;
    lifts(0.08, 0.5)(changed);
    EXPECT_LT(largest_change(values_of(deeper), values_of(changed)), 1e-9);
    const double bonded = values_of(c)[0];
    const double loose = values_of(with(c, "interface-slip-in-asphalt", 0.999))[0];
    EXPECT_GT(loose, 1.02 * bonded); // a quarter of the bending stiffness
}

// What varies with depth is the limit of many sublayers.
TEST(EffectsThatVaryWithDepth, AreManySublayers) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4, .eta = 0.3});
    c.layers[0].thickness = 0.12;
    c.sensors = {deflection(0.0),
                 deflection(0.45),
                 strain_zz(0.22, 0.075),
                 strain_zz(0.6, 0.1),
                 {0, Quantity::strain_xx, 0.0, 0.0, 0.119, 0.0}};
    c.settings.refine = 1.5;
    const auto plain = values_of(c);
    const struct {
        const char* name;
        double size;
        std::size_t layer;
        int parts;
        double (*factor)(double);
    } cases[] = {
        {"subgrade-depth-gradient", 0.8, 2, 12, [](double at) { return 1.0 + 0.8 * 1.193 * at; }},
        {"base-modulus-gradient", -1.2, 1, 10, [](double at) { return std::exp(-1.2 * (at - 0.5)); }},
        {"asphalt-temperature-gradient", 1.0, 0, 8, [](double at) { return std::exp(1.0 * (at - 0.5)); }},
    };
    for (const auto& e : cases) {
        const double error = differs(c, e.name, e.size, [&](Case& s) { cut(s, e.layer, e.parts, e.factor); });
        const double effect = largest_change(values_of(with(c, e.name, e.size)), plain);
        EXPECT_GT(effect, 0.02) << e.name;
        EXPECT_LT(error, 0.1 * effect) << e.name;
        EXPECT_LT(error, 0.01) << e.name;
    }
}

// n(r, z) = n + size (1 - n) w, w = 1 - exp(-(r/(a + z/2))^2), at places between the axis and far away.
TEST(AnisotropyDistribution, IsTheFormulaAtEveryPlace) {
    const Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.2});
    const fe::LayerMaterial layer = materials_of(with_effects(with(c, "anisotropy-distribution", 0.7), 0))[1];
    for (const auto& [r, z] : {std::pair{0.05, 0.05}, {0.15, 0.2}, {0.4, 0.3}}) {
        auto p = layer.parameters;
        p[4] = 0.2 + 0.7 * 0.8 * (1.0 - std::exp(-std::pow(r / (0.15 + z / 2.0), 2)));
        EXPECT_TRUE(fe::local_stiffness(layer, {r, 0.0, z}, {}).isApprox(layer.law->unit_stiffness(p, {}), 1e-12));
    }
}

// The wall stands where it would stand for the section written out, whose mesh is then the same.
TEST(FloorDepth, IsTheDeeperSectionWithItsOwnWall) {
    Case c = captif(3000, 60, {.k1 = 1500, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.sensors.resize(6);
    c.settings.wall_follows = true;
    c.settings.extent = c.default_extent();
    const auto deeper = [&](double by) {
        Case s = c;
        s.layers[2].thickness += by;
        s.settings.extent = s.default_extent();
        return values_of(s);
    };
    EXPECT_LT(largest_change(values_of(with(c, "floor-depth", 2000.0)), deeper(2.0)), 1e-12);
    EXPECT_LT(largest_change(values_of(with(c, "floor-depth", -300.0)), deeper(-0.3)), 1e-12);
    // As a parameter of a model whose mesh was made without it, the mesh is another one.
    const ForwardModel model(with(c, *find_effect("floor-depth"), 0.0, true));
    Case moved = with(c, *find_effect("floor-depth"), 2000.0, true);
    const auto response = model.run(moved, {}, *model.make_workspace());
    ASSERT_TRUE(response);
    EXPECT_LT(largest_change(response->values, deeper(2.0)), 0.01);
    // A wall that is stated stays, and it is said that it is near.
    c.settings.wall_follows = false;
    const auto near = test::run(with(c, "floor-depth", 2000.0));
    ASSERT_TRUE(near);
    ASSERT_FALSE(near->warnings.empty());
    EXPECT_NE(near->warnings[0].find("nearer than twice the depth"), std::string::npos);
}

// p (1 + s (2 (r/a)^2 - 1)) is (1 + s) times the uniform plate less the integral over plates of smaller radii rho with
// the weight 4 s rho/a^2, here by Gauss-Legendre with 8 points: a sum of runs of a linear section.
TEST(ContactPressureShape, IsASumOfUniformPlates) {
    Case c = three_layers();
    c.sensors = {deflection(0.0), deflection(0.3), strain_zz(0.3, 0.1), {0, Quantity::stress_zz, 0.0, 0.0, 0.5, 0.0}};
    c.settings.refine = 2.0;
    constexpr double points[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    constexpr double weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double s = 0.8, a = 0.15;
    std::vector<double> sum = values_of(c);
    for (double& v : sum) {
        v *= 1.0 + s;
    }
    for (int i = 0; i < 4; ++i) {
        for (const double sign : {-1.0, 1.0}) {
            const double rho = a / 2.0 * (1.0 + sign * points[i]);
            Case smaller = c;
            smaller.loads[0].radius = rho;
            const auto of_plate = values_of(smaller);
            for (std::size_t k = 0; k < sum.size(); ++k) {
                sum[k] -= weights[i] * a / 2.0 * 4.0 * s * rho / (a * a) * of_plate[k];
            }
        }
    }
    EXPECT_LT(largest_change(values_of(with(c, "contact-pressure-shape", s)), sum), 0.005);
}

// A thin film with hardly any shear stiffness in place of the spring between base and subgrade: k = G/thickness.
TEST(InterfaceSlipBaseSubgrade, IsAThinSoftFilm) {
    Case c = three_layers();
    c.sensors = {deflection(0.0), deflection(0.3), {0, Quantity::strain_xx, 0.0, 0.0, 0.4, 0.0}};
    const double size = 0.9, thickness = 0.001;
    const double k = 1e9 * (1.0 - size) / size;
    Case film = c;
    Layer soft = uzan_layer("film", thickness, {.k1 = 200e6 / 1e5, .k2 = 0.0, .k3 = 0.0, .n = 1.0});
    soft.parameters[7] = k * thickness / 200e6;
    film.layers.insert(film.layers.begin() + 2, soft);
    film.layers[1].thickness -= thickness / 2.0;
    film.layers[3].thickness -= thickness / 2.0;
    const auto by_spring = values_of(with(c, "interface-slip-base-subgrade", size));
    EXPECT_GT(largest_change(by_spring, values_of(c)), 0.03);
    EXPECT_LT(largest_change(by_spring, values_of(film)), 0.01);
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
    moved.sensors[3].gauge = moved.sensors[5].gauge = 0.05;
    const auto longer = values_of(with(c, "gauge-length", 50.0));
    const ForwardModel model(c); // its mesh, which a gauge in place of a point would change
    const auto by_hand = model.run(moved, {}, *model.make_workspace());
    ASSERT_TRUE(by_hand);
    EXPECT_LT(largest_change(longer, by_hand->values), 1e-9);
    moved = c;
    for (const std::size_t i : {2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
        moved.sensors[i].x -= 0.03;
    }
    // Places that are moved in millimetres and in metres differ by rounding.
    EXPECT_LT(largest_change(values_of(with(c, "load-offset", 30.0)), values_of(moved)), 1e-14);
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

// A geophone reads every drop of its device, wherever another effect moves it to, and no wheel's.
TEST(EffectsOnReadings, OfOneInstrumentActOnEveryReadingOfIt) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.1, 3e9, 0.35), linear_layer("subgrade", 2.0, 60e6, 0.4)};
    Load second = plate(0.15, 900e3);
    second.name = "second";
    c.loads = {plate(), second, dual_wheel(40e3, 650e3, Patch::circle)};
    c.settings.layered = true;
    for (const int load : {0, 1, 2}) {
        for (const double x : {0.3, 0.6}) {
            c.sensors.push_back(deflection(x));
            c.sensors.back().load = load;
        }
    }
    AppliedEffect gain{.effect = find_effect("sensor-gain"), .size = 1.2, .reading = 1};
    const auto gained = [&](Case of) {
        const auto plain = values_of(of);
        of.effects.push_back(gain);
        const auto there = values_of(of);
        std::vector<bool> by;
        for (std::size_t i = 0; i < plain.size(); ++i) {
            by.push_back(std::abs(there[i] / plain[i] - 1.2) < 1e-12);
            EXPECT_TRUE(by.back() || there[i] == plain[i]);
        }
        return by;
    };
    const std::vector<bool> every_drop{false, true, false, true, false, false};
    EXPECT_EQ(gained(c), every_drop);
    AppliedEffect moved{.effect = find_effect("load-offset"), .size = 50.0, .load = 1};
    Case with_offset = c;
    with_offset.effects = {moved};
    EXPECT_EQ(gained(with_offset), every_drop);
    AppliedEffect slipped{.effect = find_effect("sensor-position"), .size = 300.0, .reading = 0};
    with_offset.effects = {slipped}; // to where the other one is
    EXPECT_EQ(gained(with_offset), every_drop);
    gain.reading = 100; // of a list of readings that has no such instrument
    EXPECT_EQ(gained(c), std::vector<bool>(6, false));
    gain.load = 0;
    EXPECT_EQ(why_impossible(c, gain), "a reading says its load and quantity");
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

// A gauge across an interface reads the strains of both layers: u at its ends on either side.
TEST(GaugeLength, AcrossAnInterfaceIsTheChangeOfTheLength) {
    Case c = captif(3000, 40, {.k1 = 1500, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.sensors = {strain_zz(0.300, 0.0)};
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    for (const double length : {0.03, 0.1, 0.2}) {
        Case moved = c;
        moved.sensors[0].gauge = length;
        const double by_hand = model.run(moved, {}, *workspace)->values[0];
        EXPECT_NEAR(values_of(with(c, "gauge-length", 1e3 * length))[0] / by_hand, 1.0, 2e-4) << length;
    }
    // It grows from the point.
    const double at_point = values_of(c)[0];
    const Case present = with(c, *find_effect("gauge-length"), 0.0, true);
    const auto response = test::run(present, {"gauge-length.size"});
    ASSERT_TRUE(response);
    EXPECT_EQ(response->values[0], at_point);
    EXPECT_LT(std::abs(response->jacobian(0, 0)), 0.01 * std::abs(at_point)); // a mm: even in the length
}

// One bar for all drops: what is stated at the same place moves together, away from the load; x changes sign with it.
TEST(SensorPosition, IsTheSensorsElsewhere) {
    Case c = shared();
    c.sensors = {deflection(0.0), deflection(0.3), deflection(-0.45), strain_zz(0.2, 0.075, 0.3)};
    c.sensors.push_back({1, Quantity::deflection, 0.3, 0.0, 0.0, 0.0});
    c.sensors.push_back({0, Quantity::deflection, 0.3, 0.4, 0.0, 0.0});
    c.sensors.push_back({1, Quantity::deflection, 0.3, 0.0, 0.0, 0.0, false});
    const auto moved = [&](std::optional<int> reading, double size, const auto& change) {
        Case by_effect = with(c, "sensor-position", size);
        by_effect.effects[0].reading = reading;
        Case by_hand = c;
        change(by_hand.sensors);
        EXPECT_LT(largest_change(values_of(by_effect), values_of(by_hand)), 1e-12); // summed in another order
    };
    const auto both = [](std::vector<Sensor>& s) { s[1].x = s[4].x = 0.325; };
    moved(std::nullopt, 25.0, both);
    moved(1, 25.0, both);
    moved(2, 25.0, [](std::vector<Sensor>& s) { s[2].x = -0.475; });
    moved(0, 25.0, [](std::vector<Sensor>& s) { s[0].x = 0.025; });
    Case by_effect = with(c, "sensor-position", -50.0);
    by_effect.effects[0].reading = 5;
    EXPECT_NEAR(std::hypot(with_effects(by_effect, 0).sensors[5].x, with_effects(by_effect, 0).sensors[5].y), 0.45,
                1e-12);
    EXPECT_EQ(why_impossible(c, {.effect = find_effect("sensor-position"), .reading = 3}),
              "the reading is no deflection");
}

// A layout moves every sensor of the surface by its share of the way, gauges and what is not measured not at all.
TEST(SensorPosition, OfALayoutIsAllSensorsElsewhere) {
    Case c = shared();
    c.sensors = {deflection(0.0), deflection(0.6), deflection(0.315), strain_zz(0.2, 0.075, 0.3)};
    c.sensors.push_back({1, Quantity::deflection, 0.315, 0.0, 0.0, 0.0});
    c.sensors.push_back({1, Quantity::deflection, 0.315, 0.0, 0.0, 0.0, false});
    AppliedEffect layout{.effect = find_effect("sensor-position"), .size = 150.0, .offsets = {0.0, 0.3, 0.45}};
    const auto moved = [&](double size, double at_600, double at_315) {
        Case by_effect = c;
        layout.size = size;
        by_effect.effects = {layout};
        Case by_hand = c;
        by_hand.sensors[1].x = at_600;
        by_hand.sensors[2].x = by_hand.sensors[4].x = at_315;
        EXPECT_LT(largest_change(values_of(by_effect), values_of(by_hand)), 1e-12) << size;
    };
    moved(150.0, 0.45, 0.3); // the one that moves most by 150 mm: the whole layout
    moved(75.0, 0.525, 0.3075);
    moved(-30.0, 0.63, 0.318);
    EXPECT_EQ(why_impossible(c, layout), "");
    layout.offsets = {0.0, 0.3};
    EXPECT_EQ(why_impossible(c, layout), "the layout has 2 sensors, the readings are of 3");
    layout.offsets = {0.0, 0.315, 0.6};
    EXPECT_EQ(why_impossible(c, layout), "the sensors stand in that layout already");
    layout.offsets = {0.3, 0.0, 0.6};
    EXPECT_EQ(why_impossible(c, layout), "the offsets of a layout rise, from 0 or more");
    layout.reading = 1;
    EXPECT_EQ(why_impossible(c, layout), "a layout is of all sensors, not of one reading");
    layout = {.effect = find_effect("sensor-position"), .offsets = {0.0, 0.3, 0.45}};
    c.sensors.push_back({1, Quantity::deflection, -0.6, 0.0, 0.0, 0.0}); // on the other side of the load
    EXPECT_EQ(why_impossible(c, layout),
              "no deflections are measured at distances that are the places of one sensor each");
}

TEST(Drift, ScalesTheReadingsOfEveryLoadByItsNumber) {
    Case c = shared();
    c.loads.push_back(circular_wheel());
    c.loads.back().name = "third";
    c.sensors.push_back({2, Quantity::deflection, 0.1, 0.0, 0.0, 0.0});
    c.sensors.push_back({2, Quantity::deflection, 0.1, 0.0, 0.0, 0.0, false});
    const auto plain = values_of(c);
    const auto drifted = values_of(with(c, "drift", 0.02));
    for (std::size_t i = 0; i < plain.size(); ++i) {
        const double by = c.sensors[i].measured ? 1.0 + 0.02 * c.sensors[i].load : 1.0;
        EXPECT_DOUBLE_EQ(drifted[i], by * plain[i]);
    }
    c = three_layers();
    c.sensors = {deflection(0.0)};
    EXPECT_EQ(why_impossible(c, {.effect = find_effect("drift")}), "no reading under a second load");
}

// The mean over a normal distribution, by the trapezium rule over 6 standard deviations in steps of a hundredth, of
// runs of the same model: deep, and where the strain under a tyre changes its sign within centimetres.
TEST(WheelWander, IsTheMeanOverANormalDistribution) {
    Case c = axisymmetric_case();
    c.loads = {circular_wheel()};
    c.sensors = {{0, Quantity::strain_zz, 0.05, 0.0, 0.45, 0.075},
                 {0, Quantity::strain_xx, 0.0, 0.0, 0.029, 0.0},
                 {0, Quantity::strain_xx, 0.17, 0.0, 0.029, 0.0},
                 {0, Quantity::stress_zz, 0.17, 0.0, 0.05, 0.0},
                 {0, Quantity::deflection, 0.1, 0.0, 0.0, 0.0}};
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    for (const double deviation : {0.03, 0.06, 0.15}) {
        // Places beside the sensors are sensors of one run.
        Case moved = c;
        moved.sensors.clear();
        std::vector<double> weights;
        for (int k = -600; k <= 600; ++k) {
            weights.push_back(std::exp(-0.5 * k * k / 1e4));
            for (Sensor sensor : c.sensors) {
                sensor.x += deviation * k / 100.0;
                moved.sensors.push_back(sensor);
            }
        }
        const auto there = model.run(moved, {}, *workspace);
        ASSERT_TRUE(there);
        const auto wander = values_of(with(c, "wheel-wander", 1e3 * deviation));
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            double sum = 0.0, all = 0.0, most = 0.0;
            for (std::size_t k = 0; k < weights.size(); ++k) {
                const double value = there->values[k * c.sensors.size() + i];
                sum += weights[k] * value;
                all += weights[k];
                most = std::max(most, std::abs(value));
            }
            EXPECT_NEAR(wander[i], sum / all, 2e-3 * most) << deviation << ", sensor " << i;
        }
    }
}

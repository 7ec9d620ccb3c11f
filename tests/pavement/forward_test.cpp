#include "support/differences.h"
#include "support/sections.h"

#include "base/random.h"
#include "pavement/effects/catalog.h"

#include <gtest/gtest.h>
#include <map>

using namespace test;

namespace {

const std::vector<std::string> every_parameter{"base.k1",
                                               "base.k2",
                                               "base.k3",
                                               "base.n",
                                               "base.poisson_12",
                                               "base.poisson_31",
                                               "base.tension_smoothing_kPa",
                                               "base.residual_stress_kPa",
                                               "base.k0",
                                               "base.density_kg_m3",
                                               "base.thickness_mm",
                                               "asphalt.thickness_mm",
                                               "asphalt.modulus_MPa",
                                               "asphalt.poisson",
                                               "asphalt.density_kg_m3",
                                               "subgrade.modulus_MPa",
                                               "subgrade.poisson",
                                               "subgrade.thickness_mm",
                                               "fwd.pressure_kPa",
                                               "fwd.radius_mm"};

// For the dual wheel, where runs cost more: of the moduli and thicknesses one each.
const std::vector<std::string> every_kind_of_parameter{"base.k1",
                                                       "base.k2",
                                                       "base.k3",
                                                       "base.n",
                                                       "base.poisson_12",
                                                       "base.poisson_31",
                                                       "base.tension_smoothing_kPa",
                                                       "base.residual_stress_kPa",
                                                       "base.thickness_mm",
                                                       "subgrade.modulus_MPa",
                                                       "subgrade.poisson",
                                                       "dual.pressure_kPa",
                                                       "dual.force_kN",
                                                       "dual.patch_width_mm",
                                                       "dual.spacing_mm"};

Case random_case(std::uint64_t stream, Integration integration) {
    const RandomStream random(41, stream);
    Uzan u{.k1 = 500 + 7500 * random.uniform(0),
           .k2 = 0.2 + 0.5 * random.uniform(1),
           .k3 = -1.5 * random.uniform(2),
           .n = 0.1 + 0.9 * random.uniform(3),
           .delta = 5e3 + 10e3 * random.uniform(4),
           .eta = integration == Integration::secant ? 1.0 : 0.2,
           .residual_stress = 5e3 + 20e3 * random.uniform(5)};
    Case c = captif(1500 + 3000 * random.uniform(6), 30 + 60 * random.uniform(7), u, integration);
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.2, 0.0});   // in the base
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.5, 0.0});   // in the subgrade
    c.sensors.push_back({0, Quantity::strain_xx, 0.1, 0.1, 0.028, 0.0}); // not on the interface: a jump
    c.settings.refine = 0.35; // the derivative is that of the discrete model, whatever its mesh
    // 1e-12 is the rounding of some of these cases, of which ones depends on the compiler.
    c.settings.solver.equilibrium_tolerance = 1e-11;
    return c;
}

// The same section under a dual wheel, on a coarse mesh with its linear systems solved to rounding. No sensor lies on a
// line of the mesh: a reading there has a kink when the line moves.
Case random_dual_case(std::uint64_t stream, Integration integration) {
    Case c = random_case(stream, integration);
    c.loads = {dual_wheel()};
    c.sensors = {deflection(0.15),
                 deflection(0.0),
                 strain_zz(0.1875, 0.075, 0.15),
                 strain_zz(0.4125, 0.075, 0.15),
                 {0, Quantity::stress_zz, 0.15, 0.0, 0.2, 0.0},
                 {0, Quantity::strain_yy, 0.0, 0.1, 0.028, 0.0}};
    c.settings.extent = 2.0;
    c.settings.refine = 0.2;
    c.settings.solver.linear_tolerance = 1e-12;
    return c;
}

void check_jacobian(Case (*make)(std::uint64_t, Integration), Integration integration, int cases,
                    const std::vector<std::string>& paths) {
    int checked = 0;
    std::size_t compared = 0;
    for (int k = 0; k < cases; ++k) {
        const Case c = make(k, integration);
        const ForwardModel model(c);
        const auto workspace = model.make_workspace();
        std::vector<Parameter> parameters;
        parameters.reserve(paths.size());
        for (const auto& path : paths) {
            parameters.push_back(find_parameter(c, path, {}));
        }
        const auto exact = model.run(c, parameters, *workspace);
        if (!exact) {
            ASSERT_EQ(exact.status(), Status::no_equilibrium);
            continue;
        }
        ++checked;
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            const double value = parameters[p].get(c);
            const auto numeric =
                central_differences(model, c, parameters[p], 5e-4 * std::abs(value), *exact, *workspace);
            if (!numeric) { // beyond a fold
                ASSERT_EQ(numeric.status(), Status::no_equilibrium);
                continue;
            }
            if (!numeric->same_path) {
                continue; // the secant equilibrium: no difference quotient there
            }
            ++compared;
            // As relative change of the response for a relative change of the parameter. What rounding leaves of a
            // difference quotient is some 1e-12 (the solver) over 5e-4 (the step).
            const auto [worst, scale] = disagreement(*exact, p, value, numeric->rates);
            EXPECT_LT(worst, 1e-6 * scale + 1e-8) << paths[p] << ", case " << k;
        }
    }
    EXPECT_GE(checked, cases * 9 / 10);
    EXPECT_GE(compared, paths.size() * static_cast<std::size_t>(cases) * 7 / 10);
}

} // namespace

TEST(Jacobian, OfTheLoadPathAgreesWithCentralDifferences) {
    check_jacobian(random_case, Integration::incremental, 50, every_parameter);
}

TEST(Jacobian, OfTheSecantEquilibriumAgreesWithCentralDifferences) {
    check_jacobian(random_case, Integration::secant, 20, every_parameter);
}

TEST(Jacobian, OfTheLoadPathInThreeDimensionsAgreesWithCentralDifferences) {
    check_jacobian(random_dual_case, Integration::incremental, 12, every_kind_of_parameter);
}

TEST(Jacobian, OfTheSecantEquilibriumInThreeDimensionsAgreesWithCentralDifferences) {
    check_jacobian(random_dual_case, Integration::secant, 12, every_kind_of_parameter);
}

// The base has a law for each of its moduli, whose ratios follow the stress; its other parameters are those above.
Case with_separate_moduli(Case c, std::uint64_t stream) {
    const RandomStream random(43, stream);
    Layer& base = c.layers[1];
    const auto uzan = base.parameters;
    base.law = material::find_law("uzan-separate");
    base.parameters = {uzan[1],
                       uzan[2],
                       uzan[3],
                       uzan[1] * (0.1 + 0.5 * random.uniform(0)),
                       uzan[2] + 0.4 * random.uniform(1),
                       uzan[3] - 0.5 * random.uniform(2),
                       uzan[1] * (0.2 + 0.2 * random.uniform(3)),
                       uzan[2] + 0.3 * random.uniform(4),
                       uzan[3] + 0.3 * random.uniform(5),
                       0.02,
                       1.0,
                       0.3,
                       0.35,
                       uzan[8],
                       uzan[9]};
    return c;
}

TEST(Jacobian, OfSeparateModuliAgreesWithCentralDifferences) {
    const std::vector<std::string> own{"base.k1",
                                       "base.k2",
                                       "base.k3",
                                       "base.k1_horizontal",
                                       "base.k2_horizontal",
                                       "base.k3_horizontal",
                                       "base.k1_shear",
                                       "base.k2_shear",
                                       "base.k3_shear",
                                       "base.poisson_12",
                                       "base.poisson_31",
                                       "base.tension_smoothing_kPa",
                                       "base.residual_stress_kPa",
                                       "base.density_kg_m3",
                                       "base.thickness_mm",
                                       "asphalt.modulus_MPa",
                                       "subgrade.modulus_MPa"};
    const auto plate = [](std::uint64_t stream, Integration integration) {
        return with_separate_moduli(random_case(stream, integration), stream);
    };
    const auto dual = [](std::uint64_t stream, Integration integration) {
        return with_separate_moduli(random_dual_case(stream, integration), stream);
    };
    check_jacobian(plate, Integration::incremental, 10, own);
    check_jacobian(dual, Integration::incremental, 2, own);
}

TEST(ForwardRun, OfSeparateModuliWithTheExponentsOfOneIsThatOfUzan) {
    for (const bool solid : {false, true}) {
        Case c = solid ? random_dual_case(3, Integration::incremental) : random_case(3, Integration::incremental);
        auto& p = c.layers[1].parameters;
        p[0] = 1.0; // vertical
        p[7] = 0.3; // G13/E3
        const auto one = run(c);
        c.layers[1].law = material::find_law("uzan-separate");
        p = {p[1], p[2], p[3], p[4] * p[1], NAN, NAN, 0.3 * p[1], NAN, NAN, 0.01, 1.0, p[5], p[6], p[8], p[9]};
        const auto other = run(c);
        ASSERT_TRUE(one && other);
        for (std::size_t i = 0; i < one->values.size(); ++i) {
            EXPECT_NEAR(other->values[i] / one->values[i], 1.0, 1e-9) << i;
        }
    }
}

TEST(ForwardRun, RefusesToTakeSeparateModuliAsASecant) {
    Case c = with_separate_moduli(random_case(1, Integration::secant), 1);
    EXPECT_THROW(ForwardModel{c}, Error);
}

TEST(Jacobian, KeepsItsColumnsWhateverStandsBesideThem) {
    const Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    const auto response = run(c, {"base.thickness_mm", "base.k1", "fwd.radius_mm"});
    ASSERT_TRUE(response);
    // A thicker base and a smaller plate (at its pressure) deflect less.
    EXPECT_LT(response->jacobian(0, 0), 0.0);
    EXPECT_GT(response->jacobian(0, 2), 0.0);
    const auto k1_alone = run(c, {"base.k1"});
    const auto exact = k1_alone->jacobian(0, 0);
    EXPECT_NEAR(response->jacobian(0, 1), exact, 1e-12 * std::abs(exact));
}

TEST(ForwardRun, GivesTheSameBitsWhateverTheWorkspaceDidBefore) {
    const Case c = random_case(1, Integration::incremental);
    const ForwardModel model(c);
    const auto fresh = model.run(c, {}, *model.make_workspace());
    const auto used = model.make_workspace();
    for (int k = 2; k < 5; ++k) {
        Case other = random_case(k, Integration::incremental);
        other.layers[1].thickness = 0.2 + 0.05 * k;
        static_cast<void>(model.run(other, {find_parameter(c, "base.k1", {})}, *used));
    }
    const auto again = model.run(c, {}, *used);
    ASSERT_TRUE(fresh && again);
    EXPECT_EQ(fresh->values, again->values);
    EXPECT_EQ(model.run(c, {find_parameter(c, "base.k2", {})}, *used)->values, fresh->values);
}

// Loads on one mesh use one model and its memory in turn; the plate of another radius has a mesh of its own.
TEST(ForwardRun, OfManyLoadsReadsWhatEachReadsAlone) {
    Case c = random_case(7, Integration::incremental);
    const std::vector<Sensor> sensors = c.sensors;
    for (int l = 1; l < 4; ++l) {
        Load load = c.loads[0];
        load.name = "fwd" + std::to_string(l);
        load.pressure *= 1.0 + 0.2 * l;
        load.radius *= l == 2 ? 1.5 : 1.0;
        c.loads.push_back(load);
        for (Sensor sensor : sensors) {
            sensor.load = l;
            c.sensors.push_back(sensor);
        }
    }
    const ForwardModel together(c);
    const auto workspace = together.make_workspace();
    for (const double thickness : {0.25, 0.3}) { // moves the mesh
        c.layers[1].thickness = thickness;
        const std::vector<Parameter> parameters{find_parameter(c, "base.k1", {}),
                                                find_parameter(c, "base.thickness_mm", {}),
                                                find_parameter(c, "fwd2.radius_mm", {})};
        const auto all = together.run(c, parameters, *workspace);
        ASSERT_TRUE(all);
        for (int l = 0; l < 4; ++l) {
            std::vector<bool> only(4, false);
            only[static_cast<std::size_t>(l)] = true;
            const ForwardModel alone(together.nominal(), only);
            const auto one = alone.run(c, parameters, *alone.make_workspace());
            ASSERT_TRUE(one);
            for (std::size_t i = 0; i < c.sensors.size(); ++i) {
                if (c.sensors[i].load == l) {
                    const auto row = static_cast<Eigen::Index>(i);
                    EXPECT_EQ(all->values[i], one->values[i]) << "load " << l;
                    EXPECT_EQ(all->jacobian.row(row), one->jacobian.row(row)) << "load " << l;
                }
            }
        }
    }
}

// Three plates on one path, the heaviest in the middle; a fourth of another radius is on its own.
TEST(LoadPath, OfTheHeaviestPlateReadsTheLighterOnesOnTheWay) {
    Case c = random_case(7, Integration::incremental);
    const std::vector<Sensor> sensors = c.sensors;
    c.sensors.clear();
    for (const auto& [share, radius] : {std::pair{0.55, 1.0}, {1.0, 1.0}, {0.8, 1.0}, {0.7, 1.5}}) {
        Load load = c.loads[0];
        load.name = "level" + std::to_string(c.loads.size());
        load.pressure *= share;
        load.radius *= radius;
        for (Sensor sensor : sensors) {
            sensor.load = static_cast<int>(c.loads.size()) - 1;
            if (sensor.quantity == Quantity::deflection) {
                c.sensors.push_back(sensor);
            }
        }
        c.loads.push_back(load);
    }
    c.loads.erase(c.loads.begin());
    EXPECT_EQ(path_of_each(c), (std::vector{0, 1, 2, 3}));
    Case shared = c;
    shared.settings.shares_paths = true;
    EXPECT_EQ(path_of_each(shared), (std::vector{1, 1, 1, 3}));
    const std::vector parameters{find_parameter(c, "base.k1", {}), find_parameter(c, "base.k3", {}),
                                 find_parameter(c, "base.thickness_mm", {}),
                                 find_parameter(c, "subgrade.modulus_MPa", {})};
    const auto run = [&](Case& of, int steps) {
        of.settings.solver.load_steps = steps;
        const ForwardModel model(of);
        return model.run(of, parameters, *model.make_workspace());
    };
    int more_steps = 0;
    std::map<int, std::size_t> first; // sensor of each load
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        first.try_emplace(c.sensors[i].load, i);
    }
    // They differ by the errors of paths.
    for (const auto& [steps, values, rates] : {std::tuple{9, 3e-3, 1e-2}, std::tuple{70, 2e-5, 1e-4}}) {
        const auto each = run(c, steps);
        const auto together = run(shared, steps);
        ASSERT_TRUE(each && together);
        more_steps += each->statistics.load_steps - together->statistics.load_steps;
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const bool is_followed = c.sensors[i].load == 1 || c.sensors[i].load == 3;
            const double size = std::abs(each->values[first[c.sensors[i].load]]); // of D0
            EXPECT_NEAR(together->values[i], each->values[i], is_followed ? 0.0 : values * size) << i;
            for (Eigen::Index k = 0; k < each->jacobian.cols(); ++k) {
                const auto row = static_cast<Eigen::Index>(i);
                const double scale = each->jacobian.col(k).cwiseAbs().maxCoeff();
                EXPECT_NEAR(together->jacobian(row, k), each->jacobian(row, k), is_followed ? 0.0 : rates * scale);
            }
        }
    }
    EXPECT_GT(more_steps, 0);
    // Derivatives are those of the interpolated path.
    shared.settings.solver.load_steps = 9;
    const ForwardModel model(shared);
    const auto workspace = model.make_workspace();
    const auto exact = model.run(shared, parameters, *workspace);
    ASSERT_TRUE(exact);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const Parameter& parameter = parameters[p];
        const double h = 1e-4 * std::abs(parameter.get(shared));
        const auto found = central_differences(model, shared, parameter, h, *exact, *workspace);
        ASSERT_TRUE(found);
        const Disagreement d = disagreement(*exact, p, parameter.get(shared), found->rates);
        EXPECT_LT(d.worst, 1e-6 * d.scale) << parameter.path;
    }
    // Beside an effect, which need not be the same under every load, each has a path of its own.
    for (Case* of : {&c, &shared}) {
        of->effects = {{.effect = find_effect("weak-subgrade-top"), .size = 0.4}};
    }
    const auto each = run(c, 12);
    const auto beside = run(shared, 12);
    ASSERT_TRUE(each && beside);
    EXPECT_EQ(beside->values, each->values);
}

TEST(ForwardRun, OfALinearSectionIsProportionalToTheLoadAndInverseToTheModuli) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0, .k3 = 0, .n = 0.4});
    const auto one = run(c);
    c.loads[0].pressure *= 2.0;
    for (auto& [layer, index] : {std::pair{0, 0}, {1, 1}, {2, 0}}) {
        c.layers[layer].parameters[index] *= 4.0;
    }
    const auto other = run(c);
    ASSERT_TRUE(one && other);
    for (std::size_t i = 0; i < one->values.size(); ++i) {
        EXPECT_NEAR(other->values[i] / one->values[i], 0.5, 1e-8);
    }
}

TEST(ForwardRun, AgreesBetweenIncrementalAndSecantWhereTheLawIsLinear) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0, .k3 = 0, .n = 0.4});
    const auto incremental = run(c);
    c.settings.integration = Integration::secant;
    const auto secant = run(c);
    ASSERT_TRUE(incremental && secant);
    for (std::size_t i = 0; i < incremental->values.size(); ++i) {
        EXPECT_NEAR(secant->values[i] / incremental->values[i], 1.0, 1e-7);
    }
}

TEST(ForwardRun, ServesACircularWheelAsThePlateOfItsForceAndPressure) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    const auto as_plate = run(c);
    c.loads[0].type = LoadType::wheel;
    c.loads[0].force = 595e3 * 3.14159265358979323846 * 0.15 * 0.15;
    c.loads[0].radius = 0.0;
    const auto as_wheel = run(c);
    ASSERT_TRUE(as_plate && as_wheel);
    for (std::size_t i = 0; i < as_plate->values.size(); ++i) {
        EXPECT_NEAR(as_wheel->values[i] / as_plate->values[i], 1.0, 1e-6);
    }
}

// Each system of the load path is solved to a tolerance; one solution at the end with what is left multiplies by it
// again.
TEST(LoadPath, LeavesTheSquareOfTheLinearToleranceUnbalancedInThreeDimensions) {
    for (int k = 0; k < 3; ++k) {
        Case c = random_dual_case(k, Integration::incremental);
        for (const double tolerance : {1e-3, 1e-4}) {
            c.settings.solver.linear_tolerance = tolerance;
            const auto response = run(c);
            ASSERT_TRUE(response);
            // Of forces, where the tolerance is of energies.
            EXPECT_LT(response->statistics.residual_relative, 2.0 * tolerance * tolerance);
        }
    }
}

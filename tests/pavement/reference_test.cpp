// Against numbers of an independent program (other code, other meshes, about 14,000 unknowns and 64 explicit midpoint
// steps; its estimated error is 0.05 % in deflection and 0.3 % in strain).
#include "support/sections.h"

#include "base/units.h"
#include "fe/solver.h"
#include "pavement/load_model.h"

#include <gtest/gtest.h>

using namespace test;

namespace {

struct Reference {
    const char* name;
    Case c;
    std::vector<double> values; // mm, then microstrain
};

std::vector<Reference> references() {
    return {{"A1, incremental",
             captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4}),
             {1.0032437, 0.6875751, 0.31561661, 0.20311325, 0.081472889, -0.0066278152, 913.44, 900.97, 982.87, 1856.91,
              1461.37, 1137.25, 916.60}},
            {"A2, incremental, the FWD column of table 5",
             captif(3000, 40, {.k1 = 5500, .k2 = 0.70, .k3 = -1.50, .n = 0.40}),
             {0.97470291, 0.67194399, 0.33498755, 0.22688576, 0.10003287, -0.0063337534, 831.81, 1054.28, 1089.09,
              1771.48, 1370.81, 1062.72, 860.32}},
            {"S1, secant",
             captif(3000, 45,
                    {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .delta = 10e3, .eta = 1.0, .residual_stress = 20e3},
                    Integration::secant),
             {0.76097429, 0.54895295, 0.29406236, 0.20290456, 0.091013883, -0.0054337123, 562.46, 536.42, 520.97,
              1447.94, 1159.13, 905.33, 736.11}}};
}

struct Worst {
    double deflection = 0.0;
    double strain = 0.0;
};

// Largest relative difference.
Worst compare(const Reference& reference, const Case& c) {
    const auto response = run(c);
    EXPECT_TRUE(response) << (response ? "" : response.failure().reason);
    Worst worst;
    for (std::size_t i = 0; i < reference.values.size(); ++i) {
        const bool is_deflection = c.sensors[i].quantity == Quantity::deflection;
        const double value = response->values[i] * (is_deflection ? 1e3 : 1e6);
        double& target = is_deflection ? worst.deflection : worst.strain;
        target = std::max(target, std::abs(value / reference.values[i] - 1.0));
    }
    return worst;
}

} // namespace

TEST(Reference, IsMetWithinThreePerMilleInDeflectionAndOnePercentInStrainAtDefaultSettings) {
    for (const Reference& reference : references()) {
        SCOPED_TRACE(reference.name);
        const Worst worst = compare(reference, reference.c);
        EXPECT_LT(worst.deflection, 0.003);
        EXPECT_LT(worst.strain, 0.01);
    }
}

TEST(Reference, IsApproachedWhenMeshAndLoadStepsAreRefined) {
    for (const Reference& reference : references()) {
        SCOPED_TRACE(reference.name);
        std::printf("  %s\n    refine  steps  largest difference: deflection  strain\n", reference.name);
        Worst last;
        for (const auto& [refine, steps] : {std::pair{0.5, 6}, {1.0, 9}, {2.0, 18}}) {
            Case c = reference.c;
            c.settings.refine = refine;
            c.settings.solver.load_steps = steps;
            const Worst now = compare(reference, c);
            std::printf("    %6.1f  %5d  %29.4f %%  %5.3f %%\n", refine, steps, 100 * now.deflection, 100 * now.strain);
            if (refine > 0.5) {
                // The last step meets the reference's own error.
                EXPECT_LT(now.deflection, std::max(last.deflection, 0.0005));
                EXPECT_LT(now.strain, std::max(last.strain, 0.003));
            }
            last = now;
        }
        EXPECT_LT(last.strain, 0.003);
        EXPECT_LT(last.deflection, 0.0015);
    }
}

// A dual wheel on linear layers, all with Poisson's ratio 0.35: CalculiX on a mesh of 12,460 unknowns of its own.
TEST(Reference, CalculiXUnderAWheelOfADualIsMetWithinThreePerMille) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.030, 3000e6, 0.35), linear_layer("base", 0.277, 300e6, 0.35),
                linear_layer("subgrade", 1.193, 40e6, 0.35)};
    Load dual;
    dual.name = "dual";
    dual.type = LoadType::dual_wheel;
    dual.force = 40e3;
    dual.pressure = 650e3;
    dual.spacing = 0.34;
    c.loads = {dual};
    c.sensors = {deflection(0.17)};
    c.settings.extent = 2.0;
    const auto response = run(c);
    ASSERT_TRUE(response) << response.failure().reason;
    EXPECT_NEAR(response->values[0], 0.6813658e-3, 0.003 * 0.6813658e-3);
}

// GT-PAVE (Tutumluer 1995, the University of Illinois' copy, input GT2AN2): a test pit of Georgia Tech with a linear
// cross-anisotropic base on a mesh of eight-node elements, here on the same mesh. Inches and psi. Its displacements
// are those of the weight and of the load together; those of the weight are the closed form of confined compression.
TEST(Reference, TheAnisotropicTestPitOfGtPaveIsMetOnItsMesh) {
    using Element = fe::AxisymmetricQ8;
    Case c;
    c.layers = {linear_layer("asphalt", 3.5, 250000.0, 0.35),
                uzan_layer("base", 8.0, {.k1 = 34925.0 / unit::reference_pressure, .k2 = 0.0, .k3 = 0.0, .n = 0.15}),
                linear_layer("subgrade", 50.0, 7099.0, 0.40)};
    auto& base = c.layers[1].parameters;
    base[0] = 1.0; // the vertical modulus is given
    base[5] = 0.15;
    base[6] = 0.45;
    base[7] = 0.34965;
    c.loads = {plate(4.55, 100.0)};
    const double unit_weight[] = {0.0856, 0.0804, 0.0607}; // pci
    const double constrained[] = {250000.0 * 0.65 / (1.35 * 0.3),
                                  34925.0 * 0.85 / (0.85 - 2.0 * 0.15 * 0.45 * 0.45), // C3333
                                  7099.0 * 0.6 / (1.4 * 0.2)};
    const std::vector<double> bottoms{3.5, 11.5, 61.5};
    const auto settled = [&](double depth) { // by the weight
        double u = 0.0;
        double stress = 0.0; // at the top of the layer
        double top = 0.0;
        for (std::size_t l = 0; l < 3; ++l) {
            const double below = bottoms[l] - std::max(top, std::min(depth, bottoms[l]));
            const double above = bottoms[l] - top - below;
            u += below * (stress + unit_weight[l] * (above + below / 2.0)) / constrained[l];
            stress += unit_weight[l] * (bottoms[l] - top);
            top = bottoms[l];
        }
        return u;
    };
    const auto mesh = mesh::axisymmetric_mesh(
        {0.0, 1.4, 4.55, 9.55, 17.55, 32.55, 52.55, 77.55},
        {0.0, 1.1, 2.2, 3.3, 3.5, 4.8, 6.1, 7.4, 8.7, 10.0, 11.3, 11.5, 14.5, 19.5, 27.5, 41.5, 61.5}, bottoms);
    const auto model = fe::make_model(mesh, linear_layers(c));
    const Eigen::VectorXd load = 100.0 * Axisymmetric::unit_load(mesh, model, c.loads[0]);
    fe::Solver<Element> solver(model);
    const auto solved = solver.incremental(materials_of(c), load, {}, {});
    ASSERT_TRUE(solved);
    const auto displacement = [&](double r, double depth, int direction) {
        for (int e = 0; e < model.elements(); ++e) {
            for (int i = 0; i < Element::nodes; ++i) {
                if (std::abs(model.coordinates[e](0, i) - r) < 1e-6 &&
                    std::abs(model.coordinates[e](1, i) - depth) < 1e-6) {
                    const int unknown = model.topology->unknowns[e][Element::dim * i + direction];
                    return unknown < 0 ? 0.0 : solved->displacement[unknown];
                }
            }
        }
        ADD_FAILURE() << "no node at " << r << ", " << depth;
        return 0.0;
    };
    struct Node {
        double r, depth, radial, down; // inches
    };
    for (const Node& n :
         {Node{0.0, 0.0, 0.0, 0.03290274}, Node{4.55, 0.0, -0.00187957, 0.02908933},
          Node{9.55, 0.0, -0.00186957, 0.02269231}, Node{17.55, 0.0, -0.00123336, 0.01633151},
          Node{32.55, 0.0, -0.00053490, 0.01069958}, Node{77.55, 0.0, 0.0, 0.00755488}, Node{0.0, 3.3, 0.0, 0.03235624},
          Node{4.55, 11.5, 0.00369993, 0.02481325}, Node{0.0, 11.5, 0.0, 0.02615415},
          Node{17.55, 11.5, 0.00396786, 0.01591206}, Node{0.0, 27.5, 0.0, 0.01285306},
          Node{17.55, 27.5, 0.00181948, 0.01102916}, Node{0.0, 41.5, 0.0, 0.00706906}}) {
        const double allowed = 2e-3 * 0.0329; // of the largest
        EXPECT_NEAR(displacement(n.r, n.depth, 1) + settled(n.depth), n.down, allowed) << n.r << " " << n.depth;
        EXPECT_NEAR(displacement(n.r, n.depth, 0), n.radial, allowed) << n.r << " " << n.depth;
    }
}

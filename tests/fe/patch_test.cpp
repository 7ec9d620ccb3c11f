// Patch test, equilibrium and orders of convergence of the axisymmetric element.
#include "support/sections.h"

#include "base/random.h"
#include "base/units.h"
#include "fe/solver.h"
#include "mechanics/cross_anisotropic.h"

#include <gtest/gtest.h>
#include <numbers>

using namespace test;
using Element = fe::AxisymmetricQ8;

namespace {

std::vector<fe::LayerMaterial> materials(const std::vector<Layer>& layers) {
    std::vector<fe::LayerMaterial> all;
    double top = 0.0;
    double stress = 0.0;
    for (const Layer& l : layers) {
        const double weight = l.density * unit::gravity;
        all.push_back({l.law, l.parameters, top, l.thickness, stress, weight, l.k0, l.residual_stress});
        top += l.thickness;
        stress += weight * l.thickness;
    }
    return all;
}

// Irregular lines from 0 to length.
std::vector<double> irregular_lines(double length, int cells, std::uint64_t stream) {
    const RandomStream random(31, stream);
    std::vector<double> lines{0.0};
    for (int i = 0; i < cells; ++i) {
        lines.push_back(lines.back() + 0.5 + random.uniform(i));
    }
    const double scale = length / lines.back();
    for (double& x : lines) {
        x *= scale;
    }
    lines.back() = length;
    return lines;
}

constexpr double radius = 1.0;
constexpr double depth = 0.8;

// A displacement field that keeps the boundary conditions of the model, with its strains:
// u_r = A sin(pi r) cos(z) (z - H), u_z = B cos(pi r) sin(pi (H - z)/(2 H)).
struct Field {
    static constexpr double a = 2e-4, b = 5e-4;
    static double ur(double r, double z) { return a * std::sin(std::numbers::pi * r) * std::cos(z) * (z - depth); }
    static double uz(double r, double z) {
        return b * (2.0 + std::cos(std::numbers::pi * r)) * std::sin(std::numbers::pi * (depth - z) / (2 * depth));
    }
    static Element::Stress strain(double r, double z) {
        const double pi = std::numbers::pi;
        const double k = pi / (2 * depth);
        const double rr = a * pi * std::cos(pi * r) * std::cos(z) * (z - depth);
        const double tt = ur(r, z) / r;
        const double zz = -b * (2.0 + std::cos(pi * r)) * k * std::cos(k * (depth - z));
        const double rz = a * std::sin(pi * r) * (std::cos(z) - (z - depth) * std::sin(z)) -
                          b * pi * std::sin(pi * r) * std::sin(k * (depth - z));
        return {rr, tt, zz, rz};
    }
};

// Stress of the field by the secant definition: sigma = E C strain with E = Ehat(sigma0 + sigma), by bisection.
Element::Stress secant_stress(const fe::LayerMaterial& layer, double r, double z) {
    const mechanics::Stiffness<4> c = layer.law->unit_stiffness(layer.parameters, {}).topLeftCorner<4, 4>();
    const Element::Stress s = c * Field::strain(r, z);
    double low = 1.0;
    double high = 1e12;
    for (int i = 0; i < 200; ++i) {
        const double e = std::sqrt(low * high);
        const auto at = mechanics::invariants<4>(Element::Stress(layer.initial_stress<4>(z) + e * s));
        (layer.law->modulus(layer.parameters, at).value > e ? low : high) = e;
    }
    return low * s;
}

// The load that has the field as its exact answer: the virtual work of its stress, with 5 x 5 Gauss points.
template <class StressAt>
Eigen::VectorXd load_of(const fe::Model<Element>& model, const StressAt& stress_at) {
    constexpr double x[] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640};
    constexpr double w[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
                            0.2369268850561891};
    Eigen::VectorXd load = Eigen::VectorXd::Zero(model.free_unknowns());
    for (int e = 0; e < model.elements(); ++e) {
        Element::Vector force = Element::Vector::Zero();
        for (int i = 0; i < 5; ++i) {
            for (int j = 0; j < 5; ++j) {
                const auto p = Element::point(model.coordinates[e], {x[i], x[j]});
                const Eigen::Vector2d at = model.coordinates[e] * Element::shape({x[i], x[j]});
                Element::add_force(p, stress_at(e, at[0], at[1]), p.weight * w[i] * w[j], force);
            }
        }
        model.scatter_add(e, force, load.data());
    }
    return load;
}

struct Errors {
    double displacement = 0.0; // relative, L2
    double stress = 0.0;       // relative, at the Gauss points
};

template <class StressAt>
Errors errors_of(const fe::Model<Element>& model, const fe::Solution<Element>& solution, const StressAt& stress_at) {
    double du = 0.0, u = 0.0, ds = 0.0, s = 0.0;
    const auto positions = Element::gauss_positions();
    for (int e = 0; e < model.elements(); ++e) {
        const auto ue = model.gather(e, solution.displacement.data());
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = e * Element::gauss + g;
            const auto shape = Element::shape(positions[g]);
            const Eigen::Vector2d at = model.coordinates[e] * shape;
            const Eigen::Map<const Eigen::Matrix<double, 2, 8>> nodal(ue.data());
            const Eigen::Vector2d found = nodal * shape;
            const Eigen::Vector2d exact{Field::ur(at[0], at[1]), Field::uz(at[0], at[1])};
            const double w = model.points[q].weight;
            du += w * (found - exact).squaredNorm();
            u += w * exact.squaredNorm();
            const Element::Stress sigma = stress_at(e, at[0], at[1]);
            ds += w * (Element::Stress(solution.stress.col(q)) - sigma).squaredNorm();
            s += w * sigma.squaredNorm();
        }
    }
    return {std::sqrt(du / u), std::sqrt(ds / s)};
}

fe::Model<Element> regular_model(int cells) {
    std::vector<double> r, z;
    for (int i = 0; i <= cells; ++i) {
        r.push_back(radius * i / cells);
        z.push_back(depth * i / cells);
    }
    return fe::make_model(mesh::axisymmetric_mesh(r, z, {depth}), {true});
}

} // namespace

TEST(PatchTest, ConstantStrainIsInEquilibriumOnAnIrregularMesh) {
    const auto model =
        fe::make_model(mesh::axisymmetric_mesh(irregular_lines(2.0, 7, 0), irregular_lines(1.0, 6, 1), {1.0}), {true});
    // u_r = a r, u_z = b z: on the nodes; internal forces vanish at every node that touches no boundary.
    const double a = 3e-4, b = -7e-4;
    mechanics::CrossAnisotropy solid{
        .n = 0.4, .nu12 = 0.3, .nu31 = 0.25, .shear_ratio = {}, .modulus_is_vertical = false};
    const mechanics::Stiffness<4> d = 2e8 * solid.unit_stiffness().topLeftCorner<4, 4>();
    Eigen::VectorXd force = Eigen::VectorXd::Zero(model.free_unknowns());
    Eigen::VectorXd on_boundary = Eigen::VectorXd::Zero(model.free_unknowns());
    double largest = 0.0;
    for (int e = 0; e < model.elements(); ++e) {
        Element::Vector u, f = Element::Vector::Zero(), marks = Element::Vector::Zero();
        for (int i = 0; i < Element::nodes; ++i) {
            const double r = model.coordinates[e](0, i), z = model.coordinates[e](1, i);
            u[2 * i] = a * r;
            u[2 * i + 1] = b * z;
            marks[2 * i] = marks[2 * i + 1] = z == 0.0 || r == 2.0 ? 1.0 : 0.0;
        }
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& p = model.points[e * Element::gauss + g];
            const auto strain = Element::strain(p, u);
            EXPECT_LT((strain - Element::Stress(a, a, b, 0.0)).norm(), 1e-10 * std::abs(b));
            EXPECT_LT((Element::strain_operator(p) * u - strain).norm(), 1e-14);
            Element::add_force(p, d * strain, p.weight, f);
        }
        largest = std::max(largest, f.lpNorm<Eigen::Infinity>());
        model.scatter_add(e, f, force.data());
        model.scatter_add(e, marks, on_boundary.data());
    }
    for (Eigen::Index k = 0; k < force.size(); ++k) {
        if (on_boundary[k] == 0.0) {
            EXPECT_LT(std::abs(force[k]), 1e-10 * largest);
        }
    }
}

TEST(PatchTest, ConfinedCompressionOfTwoLayersIsExact) {
    // The whole surface loaded between smooth walls: strain p / M in each layer, M the constrained modulus.
    const double p = 1e5;
    const std::vector<Layer> layers{linear_layer("top", 0.3, 2e8, 0.3), linear_layer("bottom", 0.7, 5e7, 0.4)};
    const auto z = irregular_lines(0.3, 3, 2);
    auto lines = z;
    for (const double below : irregular_lines(0.7, 4, 3)) {
        if (below > 0.0) {
            lines.push_back(0.3 + below);
        }
    }
    lines.back() = 1.0;
    const auto mesh = mesh::axisymmetric_mesh(irregular_lines(1.0, 5, 4), lines, {0.3, 1.0});
    const auto model = fe::make_model(mesh, {true, true});
    const auto stress_at = [&](int, double, double) { return Element::Stress(0.0, 0.0, -p, 0.0); };
    // Virtual work of sigma_zz = -p alone loads the surface (and the held floor).
    const Eigen::VectorXd load = load_of(model, stress_at);
    fe::Solver<Element> solver(model);
    const auto solved = solver.incremental(materials(layers), load, {}, {});
    ASSERT_TRUE(solved);
    const auto constrained = [](double e, double nu) { return e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)); };
    const double strain[] = {-p / constrained(2e8, 0.3), -p / constrained(5e7, 0.4)};
    for (int e = 0; e < model.elements(); ++e) {
        const auto ue = model.gather(e, solved->displacement.data());
        for (int g = 0; g < Element::gauss; ++g) {
            const auto found = Element::strain(model.points[e * Element::gauss + g], ue);
            EXPECT_NEAR(found[2], strain[model.topology->layer[e]], 1e-10 * std::abs(strain[1]));
            EXPECT_NEAR(found[0], 0.0, 1e-10 * std::abs(strain[1]));
        }
    }
}

// A weightless layer with locked-in stress under confined compression: stress follows from the load alone (the ratio of
// horizontal to vertical stress is that of D1133 to D3333), so that strain is a plain integral of the modulus over the
// load.
TEST(LoadPath, OfConfinedCompressionIsTheIntegralOfTheModulusOverTheLoad) {
    const double p = 4e5;
    Layer layer = uzan_layer(
        "base", 1.0, {.k1 = 800, .k2 = 0.7, .k3 = -0.8, .n = 0.5, .delta = 5e3, .eta = 0.0, .residual_stress = 3e3});
    layer.density = 0.0;
    const auto layers = materials({layer});
    const mechanics::Stiffness<4> c = layers[0].law->unit_stiffness(layers[0].parameters, {}).topLeftCorner<4, 4>();
    const auto modulus_at = [&](double vertical) {
        const double horizontal = vertical * c(0, 2) / c(2, 2);
        const Element::Stress total =
            layers[0].initial_stress<4>(0.5) - Element::Stress(horizontal, horizontal, vertical, 0.0);
        return layers[0].law->modulus(layers[0].parameters, mechanics::invariants<4>(total)).value;
    };
    double exact = 0.0; // Simpson's rule on a grid graded towards zero load
    constexpr int panels = 20000;
    for (int i = 0; i < panels; ++i) {
        const auto load_at = [&](double x) { return p * std::pow(x / panels, 3); };
        const double a = load_at(i), b = load_at(i + 1);
        exact +=
            (b - a) / 6.0 * (1.0 / modulus_at(a) + 4.0 / modulus_at((a + b) / 2.0) + 1.0 / modulus_at(b)) / c(2, 2);
    }
    const auto model = fe::make_model(mesh::axisymmetric_mesh({0.0, 0.5, 1.0}, {0.0, 0.5, 1.0}, {1.0}), {false});
    const auto load = load_of(model, [&](int, double, double) { return Element::Stress(0.0, 0.0, -p, 0.0); });
    fe::Solver<Element> solver(model);
    for (const int steps : {9, 18, 36, 72, 144}) {
        const auto solved = solver.incremental(layers, load, {}, {.load_steps = steps});
        ASSERT_TRUE(solved);
        EXPECT_EQ(solved->statistics.load_steps, steps);
        const double strain = -Element::strain(model.points[0], model.gather(0, solved->displacement.data()))[2];
        const double error = std::abs(strain / exact - 1.0);
        std::printf("  %3d steps: error %.1e\n", steps, error);
        EXPECT_LT(error,
                  1e-3 * std::pow(9.0 / steps, 3)); // where tau is 0 the modulus has a kink, which costs the rest
    }
    // The tangent at the end is that of the stress there; only a path that somebody watches computes it by itself.
    for (const bool is_watched : {false, true}) {
        constexpr int steps = 144;
        fe::Solver<Element> own(model);
        if (is_watched) {
            own.on_step([](double, const Eigen::VectorXd&, const Eigen::VectorXd&) {});
        }
        const auto solved = own.incremental(layers, load, {}, {.load_steps = steps});
        ASSERT_TRUE(solved);
        EXPECT_EQ(solved->statistics.factorizations, 3 * steps + (is_watched ? 1 : 0));
        Eigen::MatrixXd rate = load;
        ASSERT_TRUE(own.solve_at_end(rate));
        const double strain_rate = -Element::strain(model.points[0], model.gather(0, rate.data()))[2];
        EXPECT_NEAR(strain_rate * modulus_at(p) * c(2, 2) / p, 1.0, 1e-5);
    }
    // The secant law needs no integral: strain = p / (E(final stress) D3333).
    const auto secant = solver.secant(layers, load, {}, {});
    ASSERT_TRUE(secant);
    const double strain = -Element::strain(model.points[0], model.gather(0, secant->displacement.data()))[2];
    EXPECT_NEAR(strain * modulus_at(p) * c(2, 2) / p, 1.0, 1e-8);
}

// Where the moduli have laws of their own, the directions of D turn on the way: with v and h the vertical and
// horizontal stress of the load, dh/dv = D13/D33 = n nu31/(1 - nu12) and d(strain)/dv = 1/D33 = (1 - nu12 - 2 n
// nu31^2)/(E3 (1 - nu12)), integrated here by the classical Runge-Kutta rule with the laws as printed.
TEST(LoadPath, OfSeparateModuliIsTheDifferentialEquationOfAConfinedColumn) {
    const double p = 4e5, residual = 20e3, nu12 = 0.2, nu31 = 0.3, pa = 1e5;
    Layer layer{"base",
                1.0,
                0.0,
                0.5,
                residual,
                material::find_law("uzan-separate"),
                {900, 0.6, -0.4, 150, 1.1, -0.2, 300, 0.7, 0.0, 0.01, 2.0, nu12, nu31, 1.0, 0.0}};
    const auto layers = materials({layer});
    using State = std::array<double, 2>; // horizontal stress, strain
    const auto rate = [&](double v, const State& y) {
        const double theta = v + 2.0 * (y[0] + residual);
        const double tau = std::numbers::sqrt2 / 3.0 * std::abs(v - y[0] - residual);
        const double vertical = 900 * pa * std::pow(theta / pa, 0.6) * std::pow(tau / pa + 1.0, -0.4);
        const double n = 150 * pa * std::pow(theta / pa, 1.1) * std::pow(tau / pa + 1.0, -0.2) / vertical;
        return State{n * nu31 / (1.0 - nu12), (1.0 - nu12 - 2.0 * n * nu31 * nu31) / (vertical * (1.0 - nu12))};
    };
    State exact{};
    constexpr int steps = 20000;
    const double h = p / steps;
    for (int i = 0; i < steps; ++i) {
        const auto moved = [&](const State& by, double factor) {
            return State{exact[0] + factor * by[0], exact[1] + factor * by[1]};
        };
        const State a = rate(i * h, exact);
        const State b = rate((i + 0.5) * h, moved(a, h / 2));
        const State c = rate((i + 0.5) * h, moved(b, h / 2));
        const State d = rate((i + 1.0) * h, moved(c, h));
        for (std::size_t j = 0; j < 2; ++j) {
            exact[j] += h / 6.0 * (a[j] + 2.0 * b[j] + 2.0 * c[j] + d[j]);
        }
    }
    const auto model = fe::make_model(mesh::axisymmetric_mesh({0.0, 0.5, 1.0}, {0.0, 0.5, 1.0}, {1.0}), {false});
    const auto load = load_of(model, [&](int, double, double) { return Element::Stress(0.0, 0.0, -p, 0.0); });
    fe::Solver<Element> solver(model);
    for (const int number : {9, 18, 36, 72, 144}) {
        const auto solved = solver.incremental(layers, load, {}, {.load_steps = number});
        ASSERT_TRUE(solved);
        const double strain = -Element::strain(model.points[0], model.gather(0, solved->displacement.data()))[2];
        const double horizontal = -solved->stress(0, 0);
        std::printf("  %3d steps: error of strain %.1e, of horizontal stress %.1e\n", number,
                    std::abs(strain / exact[1] - 1.0), std::abs(horizontal / exact[0] - 1.0));
        const double allowed = 5e-3 * std::pow(9.0 / number, 3);
        EXPECT_NEAR(strain / exact[1], 1.0, allowed);
        EXPECT_NEAR(horizontal / exact[0], 1.0, allowed);
    }
}

TEST(Equilibrium, ReactionOfTheFloorEqualsTheLoad) {
    for (const auto integration : {Integration::incremental, Integration::secant}) {
        const Case c =
            captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .delta = 10e3, .residual_stress = 20e3},
                   integration);
        const auto parts = parts_of<Axisymmetric>(c, 0);
        const double applied = 595e3 * std::numbers::pi * 0.15 * 0.15;
        EXPECT_NEAR(parts.load.sum(), applied, 1e-10 * applied);
        fe::Solver<Element> solver(parts.model);
        const auto solved = integration == Integration::secant ? solver.secant(parts.layers, parts.load, {}, {})
                                                               : solver.incremental(parts.layers, parts.load, {}, {});
        ASSERT_TRUE(solved);
        double reaction = 0.0; // vertical internal force on the nodes of the floor
        for (int e = 0; e < parts.model.elements(); ++e) {
            Element::Vector force = Element::Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = e * Element::gauss + g;
                Element::add_force(parts.model.points[q], solved->stress.col(q), parts.model.points[q].weight, force);
            }
            for (int i = 0; i < Element::nodes; ++i) {
                if (parts.model.topology->unknowns[e][2 * i + 1] < 0) {
                    reaction -= force[2 * i + 1];
                }
            }
        }
        EXPECT_NEAR(reaction, applied, 1e-8 * applied);
        EXPECT_LT(solved->statistics.residual_relative, 1e-8);
    }
}

TEST(ConvergenceOrder, IsThreeForDisplacementAndAtLeastTwoForStressInALinearSection) {
    const auto layers = materials({linear_layer("soil", depth, 1e8, 0.3)});
    const mechanics::Stiffness<4> d =
        1e8 * layers[0].law->unit_stiffness(layers[0].parameters, {}).topLeftCorner<4, 4>();
    const auto stress_at = [&](int, double r, double z) { return Element::Stress(d * Field::strain(r, z)); };
    Errors last;
    for (const int cells : {4, 8, 16, 32}) {
        const auto model = regular_model(cells);
        fe::Solver<Element> solver(model);
        const auto solved = solver.incremental(layers, load_of(model, stress_at), {}, {});
        ASSERT_TRUE(solved);
        const Errors now = errors_of(model, *solved, stress_at);
        if (cells > 4) {
            const double displacement_order = std::log2(last.displacement / now.displacement);
            const double stress_order = std::log2(last.stress / now.stress);
            std::printf("  linear, %2d cells: displacement error %.2e (order %.2f), stress error %.2e (order %.2f)\n",
                        cells, now.displacement, displacement_order, now.stress, stress_order);
            EXPECT_GT(displacement_order, 2.8);
            EXPECT_GT(stress_order, 1.9);
        }
        last = now;
    }
    EXPECT_LT(last.displacement, 1e-5);
}

TEST(ConvergenceOrder, IsTheSameForAStressDependentSectionUnderTheSecantLaw) {
    const auto layers = materials({uzan_layer(
        "base", depth,
        {.k1 = 1000, .k2 = 0.5, .k3 = -0.3, .n = 0.5, .delta = 20e3, .eta = 1.0, .residual_stress = 50e3})});
    const auto stress_at = [&](int, double r, double z) { return secant_stress(layers[0], r, z); };
    Errors last;
    for (const int cells : {4, 8, 16, 32}) {
        const auto model = regular_model(cells);
        fe::Solver<Element> solver(model);
        const auto solved = solver.secant(layers, load_of(model, stress_at), {}, {});
        ASSERT_TRUE(solved) << solved.failure().reason;
        const Errors now = errors_of(model, *solved, stress_at);
        if (cells > 4) {
            const double displacement_order = std::log2(last.displacement / now.displacement);
            const double stress_order = std::log2(last.stress / now.stress);
            std::printf("  secant, %2d cells: displacement error %.2e (order %.2f), stress error %.2e (order %.2f)\n",
                        cells, now.displacement, displacement_order, now.stress, stress_order);
            EXPECT_GT(displacement_order, 2.7);
            EXPECT_GT(stress_order, 1.9);
        }
        last = now;
    }
}

TEST(Model, ModelsOfOneMeshShareWhatTheirPatternTakesWhileOneOfThemIsThere) {
    const auto mesh_of = [](double wide) {
        return mesh::axisymmetric_mesh({0.0, 0.5, wide}, {0.0, 0.5, 1.0}, {0.5, 0.5});
    };
    const auto first = fe::make_model(mesh_of(1.0), {true, false});
    const auto wider = fe::make_model(mesh_of(2.0), {true, false});
    EXPECT_EQ(first.topology, wider.topology);
    EXPECT_NE(first.coordinates.back(), wider.coordinates.back());
    EXPECT_NE(first.topology, fe::make_model(mesh_of(1.0), {false, false}).topology);
    const auto slipping = fe::make_model(mesh_of(1.0), {true, false}, {.slipping_layers = {0}});
    EXPECT_NE(first.topology, slipping.topology);
    EXPECT_GT(slipping.topology->free_unknowns, first.topology->free_unknowns);
}

// Linear sections against closed forms and the multilayer solution.
#include "reference/multilayer_elastic.h"
#include "support/sections.h"

#include "base/random.h"
#include "pavement/fields.h"
#include "pavement/load_model.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

using namespace test;

namespace {

// A half-space as a section: one layer, deep and wide.
Case half_space(Layer layer, double radius, double pressure) {
    Case c;
    layer.thickness = 400.0 * radius;
    c.layers = {std::move(layer)};
    c.loads = {plate(radius, pressure)};
    c.settings.extent = 400.0 * radius;
    return c;
}

Case two_layers() {
    Case c;
    c.layers = {linear_layer("top", 0.1, 1000e6, 0.3), linear_layer("bottom", 0.5, 50e6, 0.4)};
    c.loads = {plate()};
    c.settings.extent = 1.0;
    return c;
}

constexpr double a = 0.15;
constexpr double q = 600e3;

// Strains read at Gauss points and deflections read at nodes, of displacements drawn at random.
template <class Kind>
void expect_readings_of_the_field(const Case& c) {
    using Element = typename Kind::Element;
    const auto parts = parts_of<Kind>(c, 0);
    const pave::RandomStream random(7, 0);
    Eigen::VectorXd u(parts.model.free_unknowns());
    for (Eigen::Index i = 0; i < u.size(); ++i) {
        u[i] = random.normal(static_cast<std::uint64_t>(i));
    }
    const auto read = [&](Quantity quantity, const typename Element::Position& at) {
        const Sensor sensor{0, quantity, at[0], Element::dim == 3 ? at[1] : 0.0, at[Element::dim - 1], 0.0};
        return observe(sensor, parts.mesh, parts.model, parts.mesh).of_displacement(u.data());
    };
    const auto positions = Element::gauss_positions();
    for (int e = 0; e < parts.model.elements(); ++e) {
        const auto of_element = parts.model.gather(e, u.data());
        for (int g = 0; g < Element::gauss; ++g) {
            const typename Element::Position at = parts.model.coordinates[e] * Element::shape(positions[g]);
            const auto strain = Element::strain(parts.model.points[e * Element::gauss + g], of_element);
            const double rounding = 1e-8 * strain.norm();
            EXPECT_NEAR(read(Quantity::strain_xx, at), -strain[0], rounding) << "element " << e << " point " << g;
            EXPECT_NEAR(read(Quantity::strain_yy, at), -strain[1], rounding) << "element " << e << " point " << g;
            EXPECT_NEAR(read(Quantity::strain_zz, at), -strain[2], rounding) << "element " << e << " point " << g;
        }
        for (int k = 0; k < Element::nodes; ++k) {
            const typename Element::Position at = parts.model.coordinates[e].col(k);
            EXPECT_NEAR(read(Quantity::deflection, at), of_element[Element::dim * k + Element::down], 1e-8)
                << "element " << e << " node " << k;
        }
    }
}

// Displacements 3 x z across and z^2 + 2 z down: their strains are linear, and exact at the nodes.
template <class Kind>
void expect_exact_strains_at_nodes(const Case& c) {
    using Element = typename Kind::Element;
    const auto parts = parts_of<Kind>(c, 0);
    const auto& model = parts.model;
    const auto displacement = [](const typename Element::Position& at, int d) {
        const double z = at[Element::dim - 1];
        return d == 0 ? 3.0 * at[0] * z : d == Element::down ? z * z + 2.0 * z : 0.0;
    };
    fe::Solution<Element> solution;
    solution.displacement.resize(model.free_unknowns());
    solution.stress.setZero(Eigen::NoChange, model.elements() * Element::gauss);
    std::vector<char> holds(model.elements(), true); // not where a wall or the floor holds what should move
    for (int e = 0; e < model.elements(); ++e) {
        for (int k = 0; k < Element::dofs; ++k) {
            const double value = displacement(model.coordinates[e].col(k / Element::dim), k % Element::dim);
            const int unknown = model.topology->unknowns[e][k];
            if (unknown >= 0) {
                solution.displacement[unknown] = value;
            } else if (value != 0.0) {
                holds[e] = false;
            }
        }
    }
    const Fields fields = fields_of(model, parts.layers, solution);
    int compared = 0;
    for (int k = 0; k < fields.position.cols(); ++k) {
        if (holds[k / Element::nodes]) {
            ++compared;
            const double x = fields.position(0, k);
            const double z = fields.position(2, k);
            EXPECT_NEAR(fields.displacement(2, k), z * z + 2.0 * z, 1e-12);
            EXPECT_NEAR(fields.strain(0, k), 3.0 * z, 1e-10);
            EXPECT_NEAR(fields.strain(2, k), 2.0 * z + 2.0, 1e-10);
            EXPECT_NEAR(fields.strain(3, k), 3.0 * x, 1e-10);
        }
    }
    EXPECT_GT(compared, fields.position.cols() / 4);
}

} // namespace

TEST(Fields, AreExactAtNodesWhereStrainIsLinear) {
    Case c = two_layers();
    expect_exact_strains_at_nodes<Axisymmetric>(c);
    c.loads = {dual_wheel()};
    expect_exact_strains_at_nodes<Solid>(c);
}

// Two fields on the modulus ratio, the later on what the earlier leaves, and one on the stiffness.
TEST(Fields, OnOneParameterHaveRatesThatAgreeWithDifferences) {
    const Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    fe::LayerMaterial layer = materials_of(c)[1];
    const auto infos = layer.law->parameters();
    const auto n = static_cast<std::size_t>(
        std::find_if(infos.begin(), infos.end(), [](const auto& i) { return i.key == "n"; }) - infos.begin());
    ASSERT_LT(n, infos.size());
    const auto weight = [](const fe::Field::Shape& shape, const Eigen::Vector3d& at) {
        return std::exp(-shape[0] * at[0] - shape[1] * at[2]);
    };
    layer.fields = {{n, false, 0.9, 0.6, weight, {2.0, 1.0}},
                    {n, false, 0.1, 0.5, weight, {0.5, 3.0}},
                    {{}, false, 0.0, -0.4, weight, {1.0, 2.0}}};
    const Eigen::Vector3d at(0.3, 0.2, 0.1);
    const pave::mechanics::Invariants state{200e3, 60e3};
    const auto check = [&](const fe::Variation& variation, double& number) {
        const auto rate = fe::local_stiffness_rate(layer, 1, at, state, variation);
        const double value = number;
        number = value + 1e-5;
        const auto above = fe::local_stiffness(layer, at, state);
        number = value - 1e-5;
        const auto below = fe::local_stiffness(layer, at, state);
        number = value;
        EXPECT_LT((rate - (above - below) / 2e-5).norm(), 1e-7 * rate.norm());
    };
    using Kind = fe::Variation::Kind;
    check({.kind = Kind::law_parameter, .layer = 1, .index = n}, layer.parameters[n]);
    for (std::size_t i = 0; i < layer.fields.size(); ++i) {
        check({.kind = Kind::field, .layer = 1, .index = i}, layer.fields[i].size);
    }
}

TEST(Readings, AreThoseOfTheDisplacements) {
    Case c = two_layers();
    expect_readings_of_the_field<Axisymmetric>(c);
    c.loads = {dual_wheel()};
    c.settings.refine = 0.3;
    expect_readings_of_the_field<Solid>(c);
}

TEST(HalfSpace, HasBoussinesqStressAndDeflectionUnderACircle) {
    const double e = 50e6, nu = 0.35;
    Case c = half_space(linear_layer("soil", 0.0, e, nu), a, q);
    c.sensors = {deflection(0.0)};
    const std::vector<double> depths{0.1, 0.2, 0.3, 0.5, 0.8};
    for (const double z : depths) {
        c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, z, 0.0});
        c.sensors.push_back(strain_zz(z, 0.0));
    }
    const auto response = run(c);
    ASSERT_TRUE(response);
    EXPECT_NEAR(response->values[0] / (2 * (1 - nu * nu) * q * a / e), 1.0, 0.005);
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double z = depths[i];
        const double s = std::sqrt(a * a + z * z);
        const double stress = q * (1 - z * z * z / (s * s * s));
        // Horizontal stress on the axis: q/2 (1 + 2 nu - 2 (1 + nu) z/s + z^3/s^3).
        const double horizontal = q / 2 * (1 + 2 * nu - 2 * (1 + nu) * z / s + z * z * z / (s * s * s));
        EXPECT_NEAR(response->values[1 + 2 * i] / stress, 1.0, 0.01) << z;
        EXPECT_NEAR(response->values[2 + 2 * i] / ((stress - 2 * nu * horizontal) / e), 1.0, 0.01) << z;
    }
}

// Boussinesq under a circle, on its axis and, by the multilayer program, beside it; of a layer that hardly changes its
// volume. Stresses of Gauss points miss by up to 20 % of the pressure there.
TEST(HalfSpace, HasItsStressesWhateverPoissonsRatio) {
    for (const double nu : {0.35, 0.46, 0.49, 0.499, 0.4999}) {
        Case c = half_space(linear_layer("soil", 0.0, 100e6, nu), a, q);
        const reference::ElasticLayer soil[] = {{1.0, 100e6, nu}};
        for (const auto& [r, z] : {std::pair{0.0, 0.05},
                                   {0.0, 0.1},
                                   {0.0, 0.15},
                                   {0.0, 0.3},
                                   {0.1, 0.05},
                                   {0.1, 0.15},
                                   {0.15, 0.05},
                                   {0.15, 0.15},
                                   {0.3, 0.15}}) {
            for (const auto quantity : {Quantity::stress_zz, Quantity::stress_xx, Quantity::stress_yy}) {
                c.sensors.push_back({0, quantity, r, 0.0, z, 0.0});
            }
        }
        const auto response = run(c);
        ASSERT_TRUE(response);
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            const Sensor& s = c.sensors[i];
            const auto exact = reference::multilayer_elastic(soil, reference::Floor::half_space, a, q, s.x, s.depth);
            const double stress = s.quantity == Quantity::stress_zz   ? exact.sigma_zz
                                  : s.quantity == Quantity::stress_xx ? exact.sigma_rr
                                                                      : exact.sigma_tt;
            EXPECT_NEAR(response->values[i], -stress, 0.01 * q) << nu << " reading " << i;
        }
    }
}

// Of horizontal readings at the bottom of thin asphalt, each alone, of the largest along the radius.
TEST(LayeredSection, AgreesWithTheMultilayerSolutionAtTheBottomOfThinAsphalt) {
    for (const double thickness : {0.015, 0.030, 0.080}) {
        const reference::ElasticLayer stack[] = {{thickness, 3000e6, 0.35}, {0.277, 300e6, 0.35}, {1.193, 40e6, 0.40}};
        Case c;
        for (const auto& layer : stack) {
            c.layers.push_back(
                linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
        }
        c.loads = {plate(0.15, 650e3)};
        c.settings.extent = 8.0;
        for (const auto quantity :
             {Quantity::strain_xx, Quantity::strain_yy, Quantity::stress_xx, Quantity::stress_yy}) {
            std::vector<double> errors;
            double largest = 0.0;
            for (const double r : {0.0, 0.1, 0.15, 0.17, 0.3, 0.65}) {
                c.sensors = {{0, quantity, r, 0.0, thickness - 1e-7, 0.0}};
                const auto response = run(c);
                ASSERT_TRUE(response);
                const auto exact = reference::multilayer_elastic(stack, reference::Floor::rigid_rough, 0.15, 650e3, r,
                                                                 c.sensors[0].depth);
                const double value = quantity == Quantity::strain_xx   ? -exact.eps_rr
                                     : quantity == Quantity::strain_yy ? -exact.eps_tt
                                     : quantity == Quantity::stress_xx ? -exact.sigma_rr
                                                                       : -exact.sigma_tt;
                errors.push_back(std::abs(response->values[0] - value));
                largest = std::max(largest, std::abs(value));
            }
            for (std::size_t i = 0; i < errors.size(); ++i) {
                EXPECT_LT(errors[i], 0.01 * largest) << thickness << " " << info(quantity).name << " " << i;
            }
        }
    }
}

// However far the wall is, what is near the plate is resolved.
TEST(LayeredSection, AgreesWithTheMultilayerSolutionBesideThePlateInAVeryWideBox) {
    const reference::ElasticLayer stack[] = {{0.05, 3000e6, 0.35}, {0.25, 300e6, 0.35}, {2.0, 60e6, 0.40}};
    for (const double extent : {20.0, 300.0, 1000.0}) {
        Case c;
        for (const auto& layer : stack) {
            c.layers.push_back(
                linear_layer("layer" + std::to_string(c.layers.size()), layer.thickness, layer.modulus, layer.poisson));
        }
        c.loads = {plate(0.15, 700e3)};
        c.settings.extent = extent;
        c.sensors = {{0, Quantity::deflection, 0.15, 0.0, 0.0, 0.0},
                     {0, Quantity::strain_zz, 0.15, 0.0, 0.06, 0.0},
                     {0, Quantity::stress_zz, 0.2, 0.0, 0.06, 0.0}};
        const auto response = run(c);
        ASSERT_TRUE(response);
        const auto exact = [&](const Sensor& s) {
            return reference::multilayer_elastic(stack, reference::Floor::rigid_rough, 0.15, 700e3, s.x, s.depth);
        };
        EXPECT_NEAR(response->values[0] / exact(c.sensors[0]).u_z, 1.0, 0.002) << extent;
        EXPECT_NEAR(response->values[1] / -exact(c.sensors[1]).eps_zz, 1.0, 0.01) << extent;
        EXPECT_NEAR(response->values[2] / -exact(c.sensors[2]).sigma_zz, 1.0, 0.01) << extent;
    }
}

TEST(HalfSpace, OfATransverselyIsotropicSolidHasItsClosedFormDeflection) {
    // Eh, Ev, nu_hh, nu_vh, G in MPa; w/(q a) per MPa from the roots of the characteristic equation.
    struct Solid {
        double eh, ev, nu_hh, nu_vh, g, deflection;
    };
    for (const Solid& s : {Solid{50, 200, .35, .35, 38, 0.01393028}, Solid{20, 200, .2, .35, 40, 0.01596269},
                           Solid{100, 200, .3, .2, 70, 0.01107701}}) {
        // k2 = k3 = 0 makes the stress-dependent law linear: E3 = k1 pa.
        Layer layer = uzan_layer("soil", 0.0, {.k1 = s.ev * 10, .k2 = 0, .k3 = 0, .n = s.eh / s.ev});
        layer.parameters[0] = 1.0; // vertical
        layer.parameters[5] = s.nu_hh;
        layer.parameters[6] = s.nu_vh;
        layer.parameters[7] = s.g / s.ev;
        Case c = half_space(layer, a, q);
        c.sensors = {deflection(0.0)};
        const auto response = run(c);
        ASSERT_TRUE(response);
        EXPECT_NEAR(response->values[0] / (q * a / 1e6) / s.deflection, 1.0, 0.005);
    }
}

TEST(LayeredSection, AgreesWithTheMultilayerSolution) {
    struct Section {
        const char* name;
        std::vector<reference::ElasticLayer> layers;
        double radius, pressure;
    };
    const std::vector<Section> sections{
        {"thin asphalt on granular base", {{0.030, 3000e6, .35}, {0.277, 300e6, .35}, {1.193, 40e6, .40}}, 0.15, 595e3},
        {"thick asphalt, deep floor", {{0.26, 5000e6, .35}, {0.5, 200e6, .40}, {6.0, 50e6, .45}}, 0.1508, 700e3},
        {"inverted: stiff subbase under soft base",
         {{0.05, 2500e6, .35}, {0.15, 250e6, .35}, {0.20, 4000e6, .25}, {2.0, 60e6, .40}},
         0.15,
         800e3}};
    for (const Section& s : sections) {
        SCOPED_TRACE(s.name);
        Case c;
        for (std::size_t i = 0; i < s.layers.size(); ++i) {
            c.layers.push_back(linear_layer("layer" + std::to_string(i), s.layers[i].thickness, s.layers[i].modulus,
                                            s.layers[i].poisson));
        }
        c.loads = {plate(s.radius, s.pressure)};
        c.settings.extent = 4.0 * c.depth() + 4.0; // the multilayer solution has no wall
        std::vector<double> radii{0.0, 0.2, 0.45, 0.9};
        for (const double r : radii) {
            c.sensors.push_back(deflection(r));
        }
        // Middles of the layers below the first, on the axis and beside the plate.
        std::vector<std::pair<double, double>> points;
        double top = s.layers[0].thickness;
        for (std::size_t i = 1; i < s.layers.size(); ++i) {
            const double z = top + std::min(0.5 * s.layers[i].thickness, 0.4);
            points.emplace_back(0.0, z);
            points.emplace_back(0.3, z);
            top += s.layers[i].thickness;
        }
        for (const auto& [r, z] : points) {
            c.sensors.push_back(strain_zz(z, 0.0, r));
        }
        const auto response = run(c);
        ASSERT_TRUE(response);
        const auto exact = [&](double r, double z) {
            return reference::multilayer_elastic(s.layers, reference::Floor::rigid_rough, s.radius, s.pressure, r, z);
        };
        const double w0 = exact(0.0, 0.0).u_z;
        for (std::size_t i = 0; i < radii.size(); ++i) {
            EXPECT_NEAR(response->values[i], exact(radii[i], 0.0).u_z,
                        0.005 * std::min(w0, 2.0 * std::abs(exact(radii[i], 0.0).u_z)))
                << radii[i];
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto [r, z] = points[i];
            const double strain = -exact(r, z).eps_zz;
            EXPECT_NEAR(response->values[radii.size() + i] / strain, 1.0, 0.005) << "r " << r << " z " << z;
        }
    }
}

TEST(Sensors, HorizontalStrainsAndStressesTurnWithTheAxes) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.sensors.clear();
    for (const auto& [x, y] : {std::pair{0.3, 0.0}, {0.0, 0.3}, {0.3 * std::sqrt(0.5), 0.3 * std::sqrt(0.5)}}) {
        for (const auto quantity :
             {Quantity::strain_xx, Quantity::strain_yy, Quantity::stress_xx, Quantity::stress_yy}) {
            c.sensors.push_back({0, quantity, x, y, 0.2, 0.0});
        }
    }
    const auto response = run(c);
    ASSERT_TRUE(response);
    const auto& v = response->values;
    for (const int i : {0, 2}) {
        EXPECT_DOUBLE_EQ(v[i], v[4 + i + 1]); // xx on the x axis is yy on the y axis
        EXPECT_DOUBLE_EQ(v[i + 1], v[4 + i]);
        EXPECT_NEAR(v[8 + i], (v[i] + v[i + 1]) / 2.0, 1e-9 * std::abs(v[i]) + 1e-9 * std::abs(v[i + 1]));
    }
    EXPECT_NE(v[0], v[1]);
}

// A section in motion under a recorded load: closed forms of a column, an independent transform solution, the limits
// of slow loads and of little mass, energy, derivatives.
#include "reference/layered_pulse.h"
#include "support/differences.h"
#include "support/motion.h"
#include "support/sections.h"

#include "fe/course.h"
#include "pavement/load_model.h"
#include "pavement/pulse.h"

#include <gtest/gtest.h>
#include <numbers>

using namespace test;
using Element = fe::AxisymmetricQ8;

namespace {

constexpr double pi = std::numbers::pi;

// Of sin^2(pi t / duration), from 0 to t.
double integral_of_haversine(double t, double duration) {
    t = std::clamp(t, 0.0, duration);
    return t / 2.0 - duration / (4.0 * pi) * std::sin(2.0 * pi * t / duration);
}

Load pulse(double duration, double until, double pressure = 700e3) {
    Load load = plate(0.15, pressure);
    load.history = haversine_history(duration, until);
    return load;
}

// A column of one linear layer, held sideways, pressed evenly over its top.
struct Column {
    static constexpr double length = 4.0, modulus = 80e6, density = 2000.0, wall = 0.1;
    static constexpr double duration = 0.02, until = 0.06, pressure = 1e5;
    static double speed() { return std::sqrt(modulus / density); } // Poisson's ratio 0: 200 m/s

    bool open = false;
    int cells = 16;
    double step = 1e-4;

    // The deflection of the top after every step.
    fe::Course course() const {
        Case c;
        c.layers = {linear_layer("column", length, modulus, 0.0)};
        c.layers[0].density = density;
        c.loads = {pulse(duration, until, pressure)};
        c.loads[0].radius = wall;
        c.settings.extent = wall;
        c.settings.time_step = step;
        std::vector<double> z(static_cast<std::size_t>(cells) + 1);
        for (int i = 0; i <= cells; ++i) {
            z[static_cast<std::size_t>(i)] = length * i / cells;
        }
        auto mesh = mesh::axisymmetric_mesh({0.0, wall / 2.0, wall}, z, {length});
        mesh.bottom_is_open = open;
        const auto model = fe::make_model(mesh, {true});
        const Eigen::VectorXd load = pressure * Axisymmetric::unit_load(mesh, model, c.loads[0]);
        fe::Functional<Element> top;
        top.on_displacement = {{model.topology->unknowns[0][1], 1.0}};
        fe::Solver<Element> solver(model);
        const auto layers = materials_of(c);
        auto marched = solver.pulse(layers, load, pulse_of(c, 0), {top}, {}, {});
        return std::move(marched->course);
    }
};

// The largest error at the top against a closed form, as a share of the largest value.
template <class Exact>
double error_of(const Column& column, Exact exact) {
    const auto course = column.course();
    double error = 0.0;
    double largest = 0.0;
    for (Eigen::Index i = 0; i < course.values.cols(); ++i) {
        const double value = exact(column.step * static_cast<double>(i + 1));
        error = std::max(error, std::abs(course.values(0, i) - value));
        largest = std::max(largest, std::abs(value));
    }
    return error / largest;
}

// On a rigid bottom waves return with the other sign every 2 length/speed: of the velocity, pressure/(density speed)
// (s(t) + 2 sum (-1)^j s(t - 2 j length/speed)).
double on_rigid_bottom(double t) {
    const double c = Column::speed();
    double sum = integral_of_haversine(t, Column::duration);
    for (int j = 1; j < 8; ++j) {
        sum += (j % 2 == 0 ? 2.0 : -2.0) * integral_of_haversine(t - 2.0 * j * Column::length / c, Column::duration);
    }
    return Column::pressure / (Column::density * c) * sum;
}

// What a rough linear section is made of.
Case layered_section(bool half_space) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.15, 3e9, 0.35), linear_layer("base", 0.4, 300e6, 0.35),
                linear_layer("subgrade", half_space ? 8.0 : 2.5, 80e6, 0.4)};
    c.layers[0].density = 2300.0;
    c.layers[1].density = 2000.0;
    c.layers[2].density = 1800.0;
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    c.half_space = half_space;
    c.loads = {pulse(0.025, 0.06)};
    c.settings.extent = 8.0;
    return c;
}

// Shares of the modulus fade within 10 and 100 ms.
Layer relaxing_asphalt(double modulus, double soon, double later, double damping_time) {
    Layer layer{"asphalt",
                0.15,
                2300.0,
                0.5,
                0.0,
                material::find_law("viscoelastic"),
                {modulus, 0.35, 20.0, 20.0, 261e3, soon, 0.01, later, 0.1, 0.0, 1.0, 0.0, 10.0}};
    layer.damping_time = damping_time;
    return layer;
}

Case captif_in_motion() {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 20e3});
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    c.loads[0].history = haversine_history(0.025, 0.03);
    c.settings.refine = 0.35;
    c.settings.time_step = 5e-4;
    return c;
}

} // namespace

TEST(Pulse, ConvergesInTimeAndSpaceToTheWavesOfAColumn) {
    const auto error = [](int cells, double step) {
        return error_of({.open = false, .cells = cells, .step = step}, on_rigid_bottom);
    };
    const double coarse = error(32, 4e-4);
    const double middle = error(32, 2e-4);
    EXPECT_LT(coarse, 0.01);
    EXPECT_NEAR(std::log2(coarse / middle), 2.0, 0.2);
    EXPECT_GT(std::log2(error(4, 2.5e-5) / error(8, 2.5e-5)), 2.5);
    EXPECT_LT(error(32, 2.5e-5), 1e-4);
}

// What comes down meets dashpots of its own impedance, which take it, beside springs k: with g the wave that comes
// back, 2 density speed g' = -k u there. k is Boussinesq's ratio, 2 G/length below the origin for Poisson's ratio 0.
TEST(Pulse, LeavesAColumnThroughAnOpenBottom) {
    const double c = Column::speed();
    const double impedance = Column::density * c;
    const double decay = 2.0 * (Column::modulus / 2.0) / Column::length / (2.0 * impedance);
    constexpr double dt = 1e-6;
    const auto lag = static_cast<std::size_t>(std::lround(Column::length / c / dt));
    const auto count = static_cast<std::size_t>(Column::until / dt) + 2;
    std::vector<double> back(count, 0.0); // as it leaves the bottom
    const auto top = [&](std::size_t i) {
        return Column::pressure / impedance * integral_of_haversine(dt * static_cast<double>(i), Column::duration) +
               (i < lag ? 0.0 : 2.0 * back[i - lag]);
    };
    for (std::size_t i = lag; i + 1 < count; ++i) {
        const double down = top(i - lag) - (i < 2 * lag ? 0.0 : back[i - 2 * lag]);
        back[i + 1] = back[i] - dt * decay * (down + back[i]);
    }
    const auto exact = [&](double t) { return top(static_cast<std::size_t>(std::lround(t / dt))); };
    EXPECT_LT(error_of({.open = true, .cells = 32, .step = 1e-4}, exact), 2e-3);
}

// At every sensor and time from 1.5 to 60 ms within 1 % of the sensor's largest of the transform solution.
void expect_transform_solution(Case c) {
    std::vector<reference::MovingLayer> layers;
    for (const Layer& layer : c.layers) {
        layers.push_back(
            {layer.thickness, layer.parameters[0], layer.parameters[1], layer.density, layer.damping_time});
        if (layer.law->relaxes()) {
            layers.back().fading_share = layer.parameters[*layer.law->index_of("g1")];
            layers.back().fading_time = layer.parameters[*layer.law->index_of("tau1_s")];
        }
    }
    const std::vector<double> radii{0.0, 0.3, 0.6, 0.9, 1.2, 1.8};
    std::vector<double> times;
    for (int i = 1; i <= 40; ++i) {
        times.push_back(1.5e-3 * i);
    }
    for (const double r : radii) {
        for (const double t : times) {
            c.sensors.push_back(deflection(r));
            c.sensors.back().time = t;
        }
    }
    const auto exact = reference::layered_pulse(layers, c.half_space, 0.15, 700e3, 0.025, radii, times);
    const auto found = run(c);
    ASSERT_TRUE(found);
    for (std::size_t i = 0; i < radii.size(); ++i) {
        double peak = 0.0;
        double error = 0.0;
        for (std::size_t j = 0; j < times.size(); ++j) {
            peak = std::max(peak, std::abs(exact[i][j]));
            error = std::max(error, std::abs(found->values[i * times.size() + j] - exact[i][j]));
        }
        EXPECT_LT(error, 0.01 * peak) << "at " << radii[i] << " m, half-space " << c.half_space;
    }
}

// Both kinds of bottom.
class PulseOnLayers : public testing::TestWithParam<bool> {};

TEST_P(PulseOnLayers, IsThatOfTheTransformSolution) {
    expect_transform_solution(layered_section(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(BothBottoms, PulseOnLayers, testing::Bool());

// Asphalt that relaxes, its damping time beside.
TEST(Pulse, OnAsphaltThatRelaxesIsThatOfTheTransformSolution) {
    Case c = layered_section(false);
    c.layers[0] = relaxing_asphalt(6e9, 0.6, 0.0, c.layers[0].damping_time);
    expect_transform_solution(c);
}

// A rock so near that the wall would stand near too: what comes back from there shows at the far sensors.
TEST(Pulse, HasItsWallFarEnoughWhereNothingIsStated) {
    Case c = layered_section(false);
    c.layers[2].thickness = 1.3;
    c.layers[2].parameters[0] = 45e6;
    c.settings.extent = c.default_extent();
    expect_transform_solution(c);
}

// Without damping, what the load did has left through the open sides once all is quiet, but for what the springs there
// hold of a section that still creeps back; nothing is taken while nothing arrives.
TEST(Pulse, LeavesWithTheEnergyThatTheLoadBrought) {
    Case c = layered_section(true);
    for (Layer& layer : c.layers) {
        layer.damping_time = 0.0;
    }
    const auto after = [&](double until) { return marched_until<Axisymmetric>(c, haversine_history(0.025, until)); };
    const auto early = after(0.012);
    EXPECT_GT(early.work, 0.0);
    EXPECT_LT(early.absorbed, 1e-3 * early.work);
    EXPECT_LT(early.kinetic, early.work);
    const auto late = after(0.25);
    EXPECT_NEAR(late.absorbed, late.work, 0.01 * late.work);
    EXPECT_LT(late.kinetic, 1e-3 * late.work);
}

// Over two seconds nothing has inertia: the peaks are those of the load at rest. The open wall gives way as far as what
// lies beyond it does.
TEST(Pulse, IsTheLoadAtRestWhenItIsSlow) {
    Case still = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 20e3});
    still.settings.extent = 6.0;
    Case slow = still;
    slow.loads[0].history = haversine_history(2.0, 2.0);
    slow.settings.time_step = 0.01;
    const auto at_rest = run(still);
    const auto moving = run(slow);
    ASSERT_TRUE(at_rest && moving);
    const double largest = at_rest->values[0];
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(moving->values[i], at_rest->values[i], 0.003 * largest) << i;
    }
    for (std::size_t i = 6; i < still.sensors.size(); ++i) {
        EXPECT_NEAR(moving->values[i] / at_rest->values[i], 1.0, 0.01) << i;
    }
}

// The moduli in the middle of a step are those that the step before foretells: of second order too.
TEST(Pulse, IsOfSecondOrderWhereStiffnessFollowsTheStress) {
    Case c = captif_in_motion();
    c.loads[0].history = haversine_history(0.024, 0.024);
    for (Sensor& sensor : c.sensors) {
        sensor.time = 0.0144; // a step ends there, whatever its length
    }
    const auto values_at = [&](double step) {
        c.settings.time_step = step;
        return run(c)->values;
    };
    const auto coarse = values_at(8e-4);
    const auto middle = values_at(4e-4);
    const auto fine = values_at(2e-4);
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        EXPECT_NEAR(std::log2(std::abs((coarse[i] - middle[i]) / (middle[i] - fine[i]))), 2.0, 0.4) << i;
    }
}

// Stress that goes back the way it came leaves no strain, and neither does a modulus that is constant; in motion it
// goes back another way, and what is left of the strain then is named.
TEST(Pulse, SaysWhatStrainItKeeps) {
    const auto kept = [](const Uzan& law, double duration, double step, double* at_end = nullptr) {
        Case c = captif(3000, 45, law);
        c.loads[0].history = haversine_history(duration, 1.8 * duration);
        c.settings.time_step = step;
        c.sensors = {strain_zz(0.2, 0.075), strain_zz(0.2, 0.075)};
        c.sensors[0].time = 0.5 * duration;
        c.sensors[1].time = 1.8 * duration;
        const auto found = run(c);
        if (at_end != nullptr) {
            *at_end = std::abs(found->values[1] / found->values[0]);
        }
        const bool warns = std::ranges::any_of(
            found->warnings, [](const std::string& w) { return w.find("after the pulse") != std::string::npos; });
        EXPECT_EQ(warns, found->statistics.kept_share > 0.1);
        return found->statistics.kept_share;
    };
    const Uzan law{.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4};
    EXPECT_LT(kept(law, 2.0, 5e-3), 0.01);
    EXPECT_LT(kept({.k1 = 1000, .k2 = 1e-6, .k3 = -1e-6, .n = 0.4}, 0.025, 2e-4), 1e-4);
    double at_end = 0.0;
    EXPECT_GT(kept(law, 0.025, 2e-4, &at_end), 0.3);
    EXPECT_GT(at_end, 0.3);

    // A load that stays is largest from its first step on, when nothing has moved yet; one that is cut off is not over.
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 60e3});
    c.settings.time_step = 2e-4;
    c.sensors = {deflection(0.0)};
    c.loads[0].history = {{0.0, 1.0}, {0.02, 1.0}, {0.021, 0.0}, {0.05, 0.0}};
    for (Layer& layer : c.layers) {
        layer.damping_time = 5e-4;
    }
    EXPECT_LT(run(c)->statistics.kept_share, 1.0);
    c.loads[0].history = {{0.0, 0.0}, {0.01, 1.0}};
    EXPECT_EQ(run(c)->statistics.kept_share, 0.0);
}

// A shock without damping: moduli that follow the stress make more motion of it than it brought.
TEST(Pulse, ThatGrowsWithoutEndHasNoAnswer) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 60e3});
    c.settings.time_step = 2e-4;
    c.sensors = {deflection(0.0)};
    c.loads[0].history = {{0.0, 1.0}, {0.02, 1.0}, {0.021, 0.0}, {0.05, 0.0}};
    const auto found = run(c);
    ASSERT_FALSE(found);
    EXPECT_NE(found.failure().reason.find("damping_time_ms"), std::string::npos);
}

TEST(Pulse, IsOverWithinTheTimeAllowed) {
    Case c = captif_in_motion();
    c.settings.solver.time_limit = 0.0;
    const auto found = run(c);
    ASSERT_FALSE(found);
    EXPECT_NE(found.failure().reason.find("time_limit_s"), std::string::npos);
}

namespace {

// Every kind of layer and reading that a pulse has.
Case of_all_kinds() {
    Case c = captif_in_motion();
    c.layers[0] = relaxing_asphalt(10e9, 0.5, 0.2, 1e-4);
    c.sensors = {
        deflection(0.0), deflection(0.9), strain_zz(0.2, 0.075), {0, Quantity::stress_zz, 0.0, 0.0, 0.25, 0.0}};
    for (const double time : {0.0082, 0.0141, 0.0213}) {
        for (std::size_t i = 0; i < 4; ++i) {
            c.sensors.push_back(c.sensors[i]);
            c.sensors.back().time = time;
        }
    }
    return c;
}
const std::initializer_list<const char*> all_kinds = {"asphalt.modulus_MPa",
                                                      "asphalt.tau1_s",
                                                      "asphalt.damping_time_ms",
                                                      "asphalt.density_kg_m3",
                                                      "base.k1",
                                                      "base.k2",
                                                      "base.k3",
                                                      "base.n",
                                                      "base.density_kg_m3",
                                                      "base.damping_time_ms",
                                                      "subgrade.modulus_MPa",
                                                      "subgrade.poisson",
                                                      "subgrade.density_kg_m3",
                                                      "subgrade.damping_time_ms",
                                                      "fwd.pressure_kPa",
                                                      "fwd.time_shift_ms",
                                                      "asphalt.thickness_mm",
                                                      "base.thickness_mm",
                                                      "subgrade.thickness_mm",
                                                      "fwd.radius_mm"};

} // namespace

TEST(Pulse, HasExactDerivatives) {
    Case c = of_all_kinds();
    for (const bool half_space : {false, true}) {
        c.half_space = half_space;
        SCOPED_TRACE(half_space ? "half-space" : "rock");
        expect_exact_derivatives(c, all_kinds, 2e-6);
    }
}

// A subspace that is all of the space, with all Gauss points, changes nothing but rounding: another way to the same
// numbers, and to their derivatives. The section read differs from the nominal one in its thicknesses too.
TEST(Pulse, InASubspaceThatIsTheWholeSpaceIsItself) {
    Case c = of_all_kinds();
    c.settings.refine = 0.2;
    c.settings.extent = 2.0;
    for (const bool half_space : {false, true}) {
        c.half_space = half_space;
        SCOPED_TRACE(half_space ? "half-space" : "rock");
        const auto parts = parts_of<Axisymmetric>(c, 0);
        const Eigen::Index unknowns = parts.model.free_unknowns();
        fe::Subspace all{Eigen::MatrixXd::Identity(unknowns, unknowns), {}};
        for (int q = 0; q < parts.model.elements() * Element::gauss; ++q) {
            if (c.layers[static_cast<std::size_t>(
                             parts.model.topology->layer[static_cast<std::size_t>(q / Element::gauss)])]
                    .law->stress_dependent()) {
                all.points.push_back({q, 1.0});
            }
        }
        Case moved = c;
        moved.layers[1].thickness *= 1.1;
        moved.layers[2].thickness *= 0.9;
        std::vector<Parameter> by;
        for (const char* path : all_kinds) {
            by.push_back(find_parameter(c, path, {}));
        }
        const ForwardModel whole(c);
        const ForwardModel reduced(c, {std::shared_ptr<const LoadModel>(make_pulse_model(c, 0, std::move(all)))});
        const auto expected = whole.run(moved, by, *whole.make_workspace());
        const auto found = reduced.run(moved, by, *reduced.make_workspace());
        ASSERT_TRUE(expected && found);
        for (std::size_t i = 0; i < c.sensors.size(); ++i) {
            EXPECT_NEAR(found->values[i], expected->values[i], 1e-8 * std::abs(expected->values[i])) << i;
        }
        for (Eigen::Index k = 0; k < expected->jacobian.cols(); ++k) {
            const auto column = expected->jacobian.col(k);
            EXPECT_LT((found->jacobian.col(k) - column).cwiseAbs().maxCoeff(), 1e-6 * column.cwiseAbs().maxCoeff())
                << by[static_cast<std::size_t>(k)].path;
        }
    }
}

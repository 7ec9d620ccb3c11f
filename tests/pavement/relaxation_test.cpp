// Layers that relax, against closed forms: a creep test, a half-space under a pulse, and what must not matter.
#include "support/differences.h"
#include "support/sections.h"

#include "base/error.h"
#include "base/random.h"
#include "pavement/load_model.h"
#include "reduced/reduced_load.h"

#include <gtest/gtest.h>
#include <numbers>

using namespace test;
using Element = fe::AxisymmetricQ8;

namespace {

constexpr double pi = std::numbers::pi;

struct Series {
    double modulus = 10e9; // Pa, instantaneous
    double g1 = 0.0, tau1 = 0.01;
    double g2 = 0.0, tau2 = 0.1;
    double temperature = 20.0;
    double poisson = 0.35;
};

Layer relaxing_layer(std::string name, double thickness, const Series& s) {
    return {std::move(name),
            thickness,
            2200.0,
            0.5,
            0.0,
            material::find_law("viscoelastic"),
            {s.modulus, s.poisson, s.temperature, 20.0, 261e3, s.g1, s.tau1, s.g2, s.tau2, 0.0, 1.0, 0.0, 10.0}};
}

// The closed forms are those of the standard linear solid: one term, E(t) = E0 (1 - g + g exp(-t/tau)), whose creep
// compliance is J(t) = (1 - g exp(-t/creep)) / (E0 (1 - g)) with creep = tau / (1 - g).
struct Standard {
    double modulus, g, tau;
    double lasting() const { return modulus * (1.0 - g); }
    double creep() const { return tau / (1.0 - g); }
    // Strain per stress under sin^2(pi t / duration): the convolution of J with its rate.
    double under_pulse(double t, double duration) const {
        const double w = 2.0 * pi / duration;
        const double r = 1.0 / creep();
        const double fading = (r * std::sin(w * t) - w * std::cos(w * t) + w * std::exp(-r * t)) / (r * r + w * w);
        const double s = std::sin(pi * t / duration);
        return (s * s - g * w / 2.0 * fading) / lasting();
    }
    double peak(double duration) const {
        double most = 0.0;
        for (int i = 0; i <= 20000; ++i) {
            most = std::max(most, under_pulse(duration * i / 20000.0, duration));
        }
        return most;
    }
};

// CAPTIF pavement 1 with asphalt that relaxes, and its strain read.
Case captif_relaxing(const Series& asphalt, double duration = 0.03) {
    Case c = captif(3000, 45, {.k1 = 2000, .k2 = 0.5, .k3 = -0.3, .n = 0.4, .residual_stress = 20e3});
    c.layers[0] = relaxing_layer("asphalt", 0.15, asphalt);
    c.layers[0].parameters[1] = 0.35;
    c.sensors = {deflection(0.0),
                 deflection(0.6),
                 deflection(1.8),
                 strain_zz(0.2, 0.075),
                 {0, Quantity::strain_xx, 0.0, 0.0, 0.145, 0.0},
                 {0, Quantity::stress_zz, 0.0, 0.0, 0.25, 0.0},
                 {0, Quantity::stress_xx, 0.05, 0.0, 0.14, 0.0},
                 {0, Quantity::stress_zz, 0.0, 0.0, 0.8, 0.0}};
    c.loads[0].duration = duration;
    c.settings.refine = 0.35;
    return c;
}

std::vector<double> values_of(const Case& c) {
    const auto response = run(c);
    EXPECT_TRUE(response);
    return response ? response->values : std::vector<double>(c.sensors.size(), 0.0);
}

// A section whose asphalt of 3000 MPa has no series is the one with linear asphalt, along a fine load path.
void expect_load_path(Case c) {
    const auto found = values_of(c);
    c.layers[0] = linear_layer("asphalt", 0.15, 3e9, 0.35);
    c.settings.solver.load_steps = 100;
    const auto exact = values_of(c);
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i] / exact[i], 1.0, 3e-3) << i;
    }
}

} // namespace

// Confined compression of one layer whose load is raised over one step and held: the strain follows J, averaged over
// the time of loading.
TEST(Relaxation, OfAColumnIsThatOfTheCreepTest) {
    const Standard solid{2e9, 0.6, 0.02};
    const double nu = 0.3;
    const double p = 1e5;
    Case c;
    c.layers = {relaxing_layer("asphalt", 1.0, {.modulus = solid.modulus, .g1 = solid.g, .tau1 = solid.tau})};
    c.layers[0].parameters[1] = nu;
    const auto layers = materials_of(c);
    const auto model = fe::make_model(mesh::axisymmetric_mesh({0.0, 0.5, 1.0}, {0.0, 0.5, 1.0}, {1.0}), {false});
    Eigen::VectorXd load = Eigen::VectorXd::Zero(model.free_unknowns());
    for (int e = 0; e < model.elements(); ++e) { // the force of a uniform vertical stress
        Element::Vector force = Element::Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& point = model.points[e * Element::gauss + g];
            Element::add_force(point, Element::Stress(0.0, 0.0, -p, 0.0), point.weight, force);
        }
        model.scatter_add(e, force, load.data());
    }
    const double constrained = (1 - nu) / ((1 + nu) * (1 - 2 * nu)); // times E
    const double duration = 0.1;
    fe::Solver<Element> solver(model);
    const auto probe = solver.incremental(layers, load, {}, {}); // elastic, with the instantaneous modulus
    ASSERT_TRUE(probe);
    Eigen::Index moving = 0;
    probe->displacement.cwiseAbs().maxCoeff(&moving);
    const double elastic = probe->displacement[moving];
    EXPECT_NEAR(std::abs(elastic), p / (solid.modulus * constrained), 1e-10 * std::abs(elastic)); // 1 m deep
    fe::Functional<Element> surface;
    surface.on_displacement = {{static_cast<int>(moving), 1.0}};
    double before = 0.0;
    for (const int steps : {10, 20, 40, 80, 160}) {
        const double h = duration / 10.0; // of loading, whatever the step
        const int rising = steps / 10;
        fe::History history{.step = duration / steps, .factors = {}};
        for (int i = 1; i <= steps; ++i) {
            history.factors.push_back(std::min(1.0, static_cast<double>(i) / rising));
        }
        const auto relaxed = solver.over_time(layers, load, history, {surface}, {}, {});
        ASSERT_TRUE(relaxed);
        double worst = 0.0;
        for (int i = rising; i <= steps; ++i) {
            const double t = i * history.step;
            const double r = 1.0 / solid.creep();
            const double exact =
                (1.0 - solid.g * std::expm1(r * h) / (r * h) * std::exp(-r * t)) / solid.lasting() * solid.modulus;
            worst = std::max(worst, std::abs(relaxed->course.values(0, i - 1) / elastic / exact - 1.0));
        }
        std::printf("  %3d steps: error %.1e\n", steps, worst);
        if (before > 0.0) { // second order
            EXPECT_GT(before / worst, 3.5);
        }
        before = worst;
    }
    EXPECT_LT(before, 3e-5);
}

TEST(Relaxation, OfAHalfSpaceUnderAPulseIsTheClosedForm) {
    const double a = 0.15, q = 600e3;
    for (const auto& [g, tau, duration] :
         {std::array{0.5, 0.01, 0.03}, std::array{0.8, 0.003, 0.03}, std::array{0.3, 0.2, 0.06},
          std::array{0.9, 1e-6, 0.03}, std::array{0.9, 1e5, 0.03}}) {
        const Standard solid{100e6, g, tau};
        Case c;
        c.layers = {relaxing_layer("soil", 400.0 * a, {.modulus = solid.modulus, .g1 = g, .tau1 = tau})};
        c.loads = {plate(a, q)};
        c.loads[0].duration = duration;
        c.settings.extent = 400.0 * a;
        c.sensors = {
            deflection(0.0), deflection(0.3), strain_zz(0.3, 0.0), {0, Quantity::stress_zz, 0.0, 0.0, 0.3, 0.0}};
        const auto found = values_of(c);
        const double nu = 0.35;
        EXPECT_NEAR(found[0] / (2 * (1 - nu * nu) * q * a * solid.peak(duration)), 1.0, 0.005);
        // Against the same section without relaxation: what the mesh errs in cancels.
        Case elastic = c;
        elastic.layers = {linear_layer("soil", 400.0 * a, solid.modulus, nu)};
        const auto reference = values_of(elastic);
        for (std::size_t i = 0; i < 3; ++i) {
            EXPECT_NEAR(found[i] / reference[i] / (solid.modulus * solid.peak(duration)), 1.0, 1e-3) << i << " " << g;
        }
        EXPECT_NEAR(found[3] / reference[3], 1.0, 1e-6); // stress does not know the modulus of a half-space
    }
}

// Of more terms, whose creep compliance has no handy form: stress is E0 ((1 - sum of g) strain + sum of g v) with
// v' = strain' - v/tau; for a given stress that is an ordinary differential equation, integrated here by the classical
// Runge-Kutta rule.
TEST(Relaxation, OfTwoTermsIsTheirDifferentialEquation) {
    const Series s{.modulus = 100e6, .g1 = 0.5, .tau1 = 0.004, .g2 = 0.3, .tau2 = 0.03};
    const double duration = 0.025;
    using State = std::array<double, 3>; // strain times E0 over the largest stress, v1, v2
    const auto rate = [&](double t, const State& y) {
        const double flow = s.g1 * y[1] / s.tau1 + s.g2 * y[2] / s.tau2;
        const double strain = pi / duration * std::sin(2.0 * pi * t / duration) + flow;
        return State{strain, strain - y[1] / s.tau1, strain - y[2] / s.tau2};
    };
    State y{};
    double most = 0.0;
    constexpr int steps = 20000;
    const double h = duration / steps;
    for (int i = 0; i < steps; ++i) {
        const auto moved = [&](const State& by, double factor) {
            return State{y[0] + factor * by[0], y[1] + factor * by[1], y[2] + factor * by[2]};
        };
        const double t = i * h;
        const State a = rate(t, y);
        const State b = rate(t + h / 2, moved(a, h / 2));
        const State c = rate(t + h / 2, moved(b, h / 2));
        const State d = rate(t + h, moved(c, h));
        for (std::size_t j = 0; j < y.size(); ++j) {
            y[j] += h / 6.0 * (a[j] + 2.0 * b[j] + 2.0 * c[j] + d[j]);
        }
        most = std::max(most, y[0]);
    }
    Case c;
    c.layers = {relaxing_layer("soil", 2.0, s)};
    c.loads = {plate()};
    c.loads[0].duration = duration;
    c.sensors = {deflection(0.0), strain_zz(0.3, 0.1)};
    Case elastic = c;
    elastic.layers = {linear_layer("soil", 2.0, s.modulus, s.poisson)};
    const auto found = values_of(c);
    const auto reference = values_of(elastic);
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i] / reference[i] / most, 1.0, 1e-3) << i;
    }
}

TEST(Relaxation, WithoutASeriesIsTheLoadPath) {
    expect_load_path(captif_relaxing({.modulus = 3e9, .g1 = 0.0}));
}

TEST(Relaxation, ShiftsWithTheTemperatureAsWithTheTimes) {
    const Series at_reference{.g1 = 0.4, .tau1 = 0.004, .g2 = 0.3, .tau2 = 0.05};
    Series warm = at_reference;
    warm.temperature = 31.0;
    Series quick = at_reference;
    const double shift = std::exp(261e3 / 8.314462618 * (1.0 / 304.15 - 1.0 / 293.15));
    quick.tau1 *= shift;
    quick.tau2 *= shift;
    const auto by_temperature = values_of(captif_relaxing(warm));
    const auto by_time = values_of(captif_relaxing(quick));
    const auto by_duration = values_of(captif_relaxing(at_reference, 0.03 / shift));
    const auto cold = values_of(captif_relaxing(at_reference));
    EXPECT_GT(by_temperature[0], 1.02 * cold[0]); // softer
    for (std::size_t i = 0; i < cold.size(); ++i) {
        EXPECT_NEAR(by_temperature[i], by_time[i], 1e-9 * std::abs(by_time[i]));
        EXPECT_NEAR(by_duration[i], by_time[i], 1e-9 * std::abs(by_time[i]));
    }
}

// In three dimensions: a homogeneous block under a dual wheel relaxes as any homogeneous body does, and a section with
// a stress-dependent base that does not relax is the load path.
TEST(Relaxation, InThreeDimensionsFollowsTheSameForms) {
    const Standard solid{100e6, 0.5, 0.01};
    Case c;
    c.layers = {relaxing_layer("soil", 1.5, {.modulus = solid.modulus, .g1 = solid.g, .tau1 = solid.tau})};
    c.loads = {dual_wheel()};
    c.settings.extent = 2.0;
    c.settings.refine = 0.2;
    c.settings.solver.linear_tolerance = 1e-8;
    c.sensors = {deflection(0.17), strain_zz(0.3, 0.075, 0.17), {0, Quantity::strain_yy, 0.1, 0.0, 0.2, 0.0}};
    Case elastic = c;
    elastic.layers = {linear_layer("soil", 1.5, solid.modulus, 0.35)};
    const auto relaxed = values_of(c);
    const auto stiff = values_of(elastic);
    for (std::size_t i = 0; i < relaxed.size(); ++i) {
        EXPECT_NEAR(relaxed[i] / stiff[i] / (solid.modulus * solid.peak(c.loads[0].duration)), 1.0, 1e-3) << i;
    }
    Case section = captif_relaxing({.modulus = 3e9, .g1 = 0.0});
    section.loads = c.loads;
    section.sensors = {deflection(0.17), strain_zz(0.2, 0.075, 0.17), {0, Quantity::stress_zz, 0.17, 0.0, 0.25, 0.0}};
    section.settings = c.settings;
    expect_load_path(section);
}

// Against fourth-order central differences; the steps of time are the same everywhere.
TEST(Relaxation, HasTheDerivativesOfCentralDifferences) {
    const std::vector<std::string> shared_paths{"asphalt.modulus_MPa",
                                                "asphalt.poisson",
                                                "asphalt.g1",
                                                "asphalt.tau1_s",
                                                "asphalt.g2",
                                                "asphalt.tau2_s",
                                                "asphalt.temperature_C",
                                                "asphalt.reference_C",
                                                "asphalt.activation_kJ_mol",
                                                "asphalt.density_kg_m3",
                                                "base.k1",
                                                "base.k2",
                                                "base.k3",
                                                "base.residual_stress_kPa",
                                                "subgrade.modulus_MPa",
                                                "duration_ms",
                                                "base.thickness_mm"};
    for (std::uint64_t stream = 0; stream < 8; ++stream) {
        const RandomStream random(97, stream);
        Case c = captif_relaxing({.modulus = 10e9,
                                  .g1 = 0.2 + 0.3 * random.uniform(0),
                                  .tau1 = 0.001 + 0.02 * random.uniform(1),
                                  .g2 = 0.3 * random.uniform(2),
                                  .tau2 = 0.02 + 0.1 * random.uniform(3),
                                  .temperature = 10.0 + 25.0 * random.uniform(4)},
                                 0.01 + 0.05 * random.uniform(5));
        std::vector<std::string> paths = shared_paths;
        const auto insert = [&paths](std::initializer_list<const char*> own) {
            paths.insert(paths.end(), own.begin(), own.end());
        };
        if (stream == 5 || stream == 7) {
            c.layers[1].law = material::find_law("uzan-separate");
            c.layers[1].parameters = {2000, 0.5, -0.3, 700, 0.8, -0.5, 600, 0.6, -0.2, 0.03, 1.0, 0.3, 0.35, 5e3, 0.0};
            insert({"base.k1_horizontal", "base.k2_horizontal", "base.k3_shear"});
        } else {
            insert({"base.n"});
        }
        const bool solid = stream >= 6;
        if (solid) {
            c.loads[0] = dual_wheel();
            c.loads[0].duration = 0.02;
            c.sensors = {
                deflection(0.15), strain_zz(0.1875, 0.075, 0.15), {0, Quantity::stress_xx, 0.15, 0.0, 0.12, 0.0}};
            c.settings.extent = 2.0;
            c.settings.refine = 0.2;
            c.settings.solver.linear_tolerance = 1e-12;
        }
        const ForwardModel model(c);
        const auto workspace = model.make_workspace();
        std::vector<Parameter> parameters;
        for (const std::string& path : paths) {
            const std::string of_load = path == "duration_ms" ? c.loads[0].name + "." : "";
            parameters.push_back(find_parameter(c, of_load + path, {}));
        }
        const auto exact = model.run(c, parameters, *workspace);
        ASSERT_TRUE(exact);
        for (std::size_t p = 0; p < parameters.size(); ++p) {
            const double value = parameters[p].get(c);
            const auto numeric =
                central_differences(model, c, parameters[p], 5e-4 * std::abs(value), *exact, *workspace);
            ASSERT_TRUE(numeric);
            const auto [worst, scale] = disagreement(*exact, p, value, numeric->rates);
            EXPECT_LT(worst, 1e-6 * scale + 1e-8) << paths[p] << ", case " << stream;
        }
    }
}

TEST(Relaxation, IsRefusedWhereItIsNotModelled) {
    Case c = captif_relaxing({.g1 = 0.5});
    EXPECT_EQ(reduced::why_not(c, 0), "a layer relaxes");
    c.settings.integration = Integration::secant;
    EXPECT_THROW(ForwardModel{c}, Error);
    Case all = captif_relaxing({.g1 = 0.7, .g2 = 0.3});
    const auto response = run(all);
    ASSERT_FALSE(response);
    EXPECT_EQ(response.status(), Status::invalid_parameters);
}

// Inertia: the pulse of a deflectometer against closed forms, and the extreme that is read.
#include "support/differences.h"
#include "support/effects.h"

#include "pavement/load_model.h"

#include <numbers>

using namespace test;

namespace {

// A load that rises and falls as sin^2(pi t / duration), and how its answer is followed.
struct Pulse {
    double duration = 0.03; // s
    double damping = 0.05;  // ratio to the critical one at the frequency 1/duration
    double inertia = 1.0;
    bool absorbs = true;
    double reach = 0.0; // m
    int steps = 80;
};

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
    fe::InertialCourse follow(const Pulse& pulse) {
        const fe::Inertia inertia{.factor = pulse.inertia,
                                  .delay = pulse.damping * pulse.duration / std::numbers::pi,
                                  .absorbs = pulse.absorbs,
                                  .reach = pulse.reach};
        const auto history = fe::haversine(pulse.duration, pulse.steps);
        return solver.inertial(solved, parts.load, history, inertia, readings).value();
    }
    // What inertia adds to the largest downward deflections.
    Eigen::ArrayXd excess(const Pulse& pulse) {
        const auto course = follow(pulse);
        Eigen::ArrayXd more(at_rest.size());
        for (Eigen::Index i = 0; i < more.size(); ++i) {
            more[i] = fe::peak(course.moving, i, 1.0).value - course.at_rest.values(i, 0);
        }
        return more;
    }
    Eigen::ArrayXd peaks(const Pulse& pulse) { return at_rest + excess(pulse); }
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

} // namespace

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
        for (double t = 0.0; t <= 2.0 * duration; t += duration / 400.0) {
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
            peak = std::max(peak, w);
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

namespace {

// On a floor at 1.5 m far deflections swing up as far as down: which swing is the larger changes with the size.
Case swinging() {
    Case c = captif(3000, 40, {.k1 = 1500, .k2 = 0.5, .k3 = -0.3, .n = 0.4});
    c.loads[0].pressure = 700e3;
    c.sensors = {deflection(0.0), deflection(1.2), deflection(1.5)};
    return c;
}

} // namespace

// Found among 320 steps a pulse in place of 80 and an interpolation, over a longer time.
TEST(Inertia, ReadsTheLargestDownwardDeflectionWhateverSwingsUp) {
    const Case c = swinging();
    Pulsed section(c);
    bool swung_up = false;
    for (const double size : {0.4, 0.45, 0.8, 1.6}) {
        const auto read = values_of(with(c, "inertia", size));
        const auto course = section.follow({.inertia = size, .reach = 3.0, .steps = 320});
        for (Eigen::Index i = 0; i < 3; ++i) {
            const auto row = course.moving.values.row(i);
            swung_up = swung_up || -row.minCoeff() > row.maxCoeff();
            const double expected = section.at_rest[i] + row.maxCoeff() - course.at_rest.values(i, 0);
            EXPECT_NEAR(read[static_cast<std::size_t>(i)] / expected, 1.0, 5e-3) << size << ", sensor " << i;
        }
    }
    EXPECT_TRUE(swung_up) << "the largest magnitude is another number";
}

// A polynomial of the sixth degree follows what is smooth, and nearly so a bend where a later swing becomes the
// largest; a jump to the swing upwards was 200 %.
TEST(Inertia, IsSmoothInItsSize) {
    const Case c = with(swinging(), *find_effect("inertia"), 0.5, true);
    const ForwardModel model(c);
    const auto workspace = model.make_workspace();
    constexpr int count = 25, degree = 6;
    Eigen::MatrixXd powers(count, degree + 1);
    Eigen::MatrixXd read(count, 3);
    for (int i = 0; i < count; ++i) {
        const double x = 2.0 * i / (count - 1) - 1.0;
        Case there = c;
        there.effects[0].size = 0.7 + 0.4 * x;
        const auto response = model.run(there, {}, *workspace);
        ASSERT_TRUE(response);
        for (int k = 0; k <= degree; ++k) {
            powers(i, k) = std::pow(x, k);
        }
        for (int k = 0; k < 3; ++k) {
            read(i, k) = response->values[static_cast<std::size_t>(k)];
        }
    }
    const Eigen::MatrixXd smooth = powers * powers.colPivHouseholderQr().solve(read);
    EXPECT_LT(((read - smooth).array() / read.array()).abs().maxCoeff(), 1e-2);
}

// Soft, thick subgrade: the wave is at 2.4 m some 60 ms after it leaves the plate. Followed three times as far, nothing
// changes; for no longer than a sensor at the plate needs, the farthest are cut off.
TEST(Inertia, WaitsUntilTheWaveHasArrived) {
    Case c;
    c.layers = {linear_layer("asphalt", 0.03, 3000e6, 0.35), linear_layer("base", 0.3, 150e6, 0.35),
                linear_layer("subgrade", 6.0, 8e6, 0.45)};
    c.loads = {plate(0.15, 700e3)};
    c.sensors = {deflection(0.0), deflection(1.8), deflection(2.1), deflection(2.4)};
    c.settings.extent = c.default_extent();
    const auto read = values_of(with(c, "inertia", 1.0));
    Pulsed section(c);
    const Eigen::ArrayXd longer = section.peaks({.reach = 7.2});
    const Eigen::ArrayXd cut_off = section.peaks({.reach = 0.0});
    for (Eigen::Index i = 0; i < longer.size(); ++i) {
        EXPECT_NEAR(read[static_cast<std::size_t>(i)] / longer[i], 1.0, 1e-6) << i;
    }
    EXPECT_GT(longer[3], 1.02 * cut_off[3]);
}

// Beside the plate the surface may heave at rest: a little inertia changes such a reading little.
TEST(Inertia, GrowsFromTheReadingAtRestWhereThatIsUpwards) {
    Case c = captif(3000, 40, {.k1 = 2000, .k2 = 0.4, .k3 = -0.3, .n = 0.4});
    c.sensors = {deflection(0.0), deflection(1.8)};
    const auto still = values_of(c);
    ASSERT_LT(still[1], 0.0);
    const auto present = values_of(with(c, *find_effect("inertia"), 0.0, true));
    EXPECT_NEAR(present[1], still[1], 1e-3 * std::abs(still[1]));
    const auto slight = values_of(with(c, "inertia", 1e-3));
    EXPECT_NEAR(slight[1], still[1], 0.01 * still[0]);
}

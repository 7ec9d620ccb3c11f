// Load paths in the lanes of vectors, against the solver of one path and against formulas.
#include "fe/batch_solver.h"

#include "base/random.h"
#include "fe/lanes/kernels.h"
#include "pavement/load_model.h"
#include "pavement/observation.h"
#include "support/sections.h"

#include <cstring>
#include <gtest/gtest.h>

namespace {

using namespace test;
using Element = fe::AxisymmetricQ8;
using Kind = fe::Variation::Kind;

std::vector<const fe::lanes::Kernels*> all_kernels() {
    const fe::lanes::Kernels* list[8];
    return {list, list + fe::lanes::usable_kernels(list, 8)};
}

// Units in the last place of the nearest double.
double ulps(double value, long double exact) {
    const auto nearest = static_cast<double>(exact);
    const double ulp = std::nextafter(std::abs(nearest), std::numeric_limits<double>::infinity()) - std::abs(nearest);
    return static_cast<double>(std::fabs(static_cast<long double>(value) - exact)) / ulp;
}

struct Functions {
    double log, log_1_plus, exp;
};
Functions functions_of(const fe::lanes::Kernels& kernels, double x) {
    alignas(fe::lanes::alignment) double in[8];
    alignas(fe::lanes::alignment) double out[3][8];
    std::fill(in, in + 8, x);
    kernels.functions(in, out[0], out[1], out[2]);
    return {out[0][kernels.lanes - 1], out[1][kernels.lanes - 1], out[2][kernels.lanes - 1]};
}

TEST(Lanes, LogarithmsAndPowersAreThoseOfTheMathematicalFunctions) {
    const RandomStream random(7, 1);
    for (const auto* kernels : all_kernels()) {
        std::uint64_t number = 0;
        for (int i = 0; i < 20000; ++i) {
            const double wide = std::exp(600.0 * random.uniform(number++) - 300.0);
            const double near_one = 0.5 + 1.5 * random.uniform(number++);
            const double power = (i % 2 == 0 ? 1400.0 : 4.0) * (random.uniform(number++) - 0.5);
            const double ratio = std::exp(50.0 * random.uniform(number++) - 40.0);
            ASSERT_LE(ulps(functions_of(*kernels, wide).log, std::log(static_cast<long double>(wide))), 2.0) << wide;
            ASSERT_LE(ulps(functions_of(*kernels, near_one).log, std::log(static_cast<long double>(near_one))), 2.0)
                << near_one;
            ASSERT_LE(ulps(functions_of(*kernels, power).exp, std::exp(static_cast<long double>(power))), 2.0) << power;
            ASSERT_LE(ulps(functions_of(*kernels, ratio).log_1_plus, std::log1p(static_cast<long double>(ratio))), 2.0)
                << ratio;
        }
        EXPECT_EQ(functions_of(*kernels, 0.0).exp, 1.0);
        EXPECT_EQ(functions_of(*kernels, 1.0).log, 0.0);
        EXPECT_EQ(functions_of(*kernels, -800.0).exp, 0.0);
        EXPECT_TRUE(std::isnan(functions_of(*kernels, 0.0).log));
        EXPECT_TRUE(std::isnan(functions_of(*kernels, std::numeric_limits<double>::quiet_NaN()).exp));
    }
}

// Sections on one mesh, drawn wide, with what a deflectometer and gauges read of them.
struct Sections {
    Case nominal = captif(3000, 40, {5500, 0.7, -1.5, 0.4});
    Parts<Axisymmetric> parts = parts_of<Axisymmetric>(nominal, 0);
    std::vector<fe::Functional<Element>> readings;
    std::vector<std::vector<fe::LayerMaterial>> layers;
    std::vector<fe::BatchRun> runs;

    explicit Sections(int count, const char* law = "uzan", double k2_low = 0.1, double k2_high = 1.0) {
        nominal.settings.solver.load_steps = 6;
        for (const Sensor& sensor : nominal.sensors) {
            readings.push_back(observe(sensor, parts.mesh, parts.model, parts.mesh, incompressible_layers(nominal)));
        }
        const RandomStream random(11, 2);
        std::uint64_t number = 0;
        const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(number++); };
        for (int i = 0; i < count; ++i) {
            Case c = nominal;
            c.layers[0].parameters = {std::exp(between(std::log(5e8), std::log(1e10))), between(0.2, 0.45)};
            c.layers[2].parameters = {std::exp(between(std::log(15e6), std::log(200e6))), between(0.2, 0.45)};
            c.layers[1].k0 = between(0.3, 1.0);
            c.layers[1].residual_stress = between(0.0, 2e4);
            Layer& base = c.layers[1];
            base.law = material::find_law(law);
            std::vector<double> parameters;
            for (const auto& info : base.law->parameters()) {
                const double usual = info.usual ? between(info.usual->low, info.usual->high) : 0.0;
                parameters.push_back(info.key == "k2"  ? between(k2_low, k2_high)
                                     : info.usual      ? usual * info.to_si
                                     : info.key == "n" ? between(0.2, 1.2)
                                                       : info.default_value.value_or(0.35) * info.to_si);
            }
            base.parameters = parameters;
            layers.push_back(materials_of(c));
        }
        for (const auto& own : layers) {
            runs.push_back({&own, &parts.load, &readings});
        }
    }
};

const std::vector<fe::Variation> many_variations{
    {Kind::law_parameter, 1, 1}, {Kind::law_parameter, 1, 2}, {Kind::law_parameter, 1, 3}, {Kind::law_parameter, 1, 4},
    {Kind::law_parameter, 1, 5}, {Kind::law_parameter, 1, 8}, {Kind::unit_weight, 0},      {Kind::k0, 1},
    {Kind::residual_stress, 1},  {Kind::load_factor},
};

// Largest |difference| of readings, and of derivatives, relative to the largest of their kind and column.
struct Apart {
    double values = 0.0;
    double derivatives = 0.0;
    int failed = 0;
};
Apart apart(const Sections& s, const std::vector<fe::Variation>& by, const fe::lanes::Kernels& kernels) {
    fe::BatchSolver batch(s.parts.model, &kernels);
    fe::Solver<Element> one(s.parts.model);
    const auto together = batch.incremental(s.runs, by, s.nominal.settings.solver);
    Apart result;
    for (std::size_t i = 0; i < s.runs.size(); ++i) {
        const auto alone = one.incremental(s.layers[i], s.parts.load, by, s.nominal.settings.solver);
        EXPECT_EQ(static_cast<bool>(alone), static_cast<bool>(together[i])) << i;
        if (!alone || !together[i]) {
            EXPECT_TRUE(alone || alone.failure().reason == together[i].failure().reason);
            ++result.failed;
            continue;
        }
        const auto n = static_cast<Eigen::Index>(s.readings.size());
        const auto count = static_cast<Eigen::Index>(by.size());
        Eigen::VectorXd values(n);
        Eigen::MatrixXd rates(n, count);
        for (Eigen::Index r = 0; r < n; ++r) {
            const auto& f = s.readings[static_cast<std::size_t>(r)];
            values[r] = f.of_displacement(alone->displacement.data());
            for (Eigen::Index k = 0; k < count; ++k) {
                rates(r, k) = f.of_displacement(alone->d_displacement.col(k).data());
            }
        }
        const fe::Course& at_rest = together[i]->at_rest;
        constexpr Eigen::Index deflections = 6;
        for (const auto& [first, size] :
             {std::pair(Eigen::Index{0}, deflections), std::pair(deflections, n - deflections)}) {
            const auto off = (at_rest.values.col(0) - values).segment(first, size).cwiseAbs().maxCoeff();
            result.values = std::max(result.values, off / values.segment(first, size).cwiseAbs().maxCoeff());
            for (Eigen::Index k = 0; k < count; ++k) {
                const auto d = (at_rest.d_values[0].col(k) - rates.col(k)).segment(first, size).cwiseAbs().maxCoeff();
                result.derivatives =
                    std::max(result.derivatives, d / rates.col(k).segment(first, size).cwiseAbs().maxCoeff());
            }
        }
        const fe::Statistics& a = alone->statistics;
        const fe::Statistics& b = together[i]->statistics;
        EXPECT_NEAR(a.tension_share, b.tension_share, 1e-9);
        EXPECT_NEAR(a.unstable_share, b.unstable_share, 1e-9);
        EXPECT_EQ(a.limited_share, b.limited_share);
        EXPECT_EQ(a.factorizations, b.factorizations);
        EXPECT_LT(b.residual_relative, 1e-9);
    }
    return result;
}

TEST(Lanes, ReadingsAreThoseOfOnePath) {
    const Sections sections(21);
    for (const auto* kernels : all_kernels()) {
        const Apart off = apart(sections, {}, *kernels);
        EXPECT_LT(off.values, 1e-11) << kernels->instructions;
        EXPECT_EQ(off.failed, 0);
    }
}

TEST(Lanes, DerivativesAreThoseOfOnePath) {
    const Sections sections(9);
    for (const auto* kernels : all_kernels()) {
        EXPECT_LT(apart(sections, many_variations, *kernels).derivatives, 1e-10) << kernels->instructions;
        auto with_linear = many_variations; // follows what is eliminated once as well
        with_linear.push_back({Kind::law_parameter, 2, 0});
        with_linear.push_back({Kind::law_parameter, 0, 1});
        EXPECT_LT(apart(sections, with_linear, *kernels).derivatives, 1e-10) << kernels->instructions;
    }
}

TEST(Lanes, LawsWithoutAFormOfTheirOwnAreAskedLaneByLane) {
    const std::vector<fe::Variation> by{{Kind::law_parameter, 1, 1}, {Kind::law_parameter, 1, 2}};
    for (const char* law : {"k-theta", "uzan-deviator", "bilinear"}) {
        const Apart off = apart(Sections(5, law), by, fe::lanes::kernels(8));
        EXPECT_LT(off.values, 1e-11) << law;
        EXPECT_LT(off.derivatives, 1e-10) << law;
    }
}

std::vector<std::uint64_t> bits(const Outcome<fe::BatchReading>& reading) {
    const auto& course = reading->at_rest;
    std::vector<std::uint64_t> all(static_cast<std::size_t>(course.values.size() + course.d_values[0].size()));
    std::memcpy(all.data(), course.values.data(), sizeof(double) * static_cast<std::size_t>(course.values.size()));
    std::memcpy(all.data() + course.values.size(), course.d_values[0].data(),
                sizeof(double) * static_cast<std::size_t>(course.d_values[0].size()));
    return all;
}

TEST(Lanes, BitsDependNeitherOnNeighboursNorOnTheirNumber) {
    const Sections sections(11);
    const std::vector<fe::Variation> by{{Kind::law_parameter, 1, 2}, {Kind::law_parameter, 2, 0}};
    const auto& settings = sections.nominal.settings.solver;
    fe::BatchSolver batch(sections.parts.model);
    const auto together = batch.incremental(sections.runs, by, settings);
    auto turned = sections.runs;
    std::reverse(turned.begin(), turned.end());
    const auto other_way = fe::BatchSolver(sections.parts.model).incremental(turned, by, settings);
    for (std::size_t i = 0; i < sections.runs.size(); ++i) {
        EXPECT_EQ(bits(together[i]), bits(other_way[sections.runs.size() - 1 - i])) << i;
        EXPECT_EQ(bits(together[i]), bits(batch.incremental({&sections.runs[i], 1}, by, settings)[0])) << i;
    }
}

TEST(Lanes, FusedWidthsHaveTheSameBits) {
    const Sections sections(8);
    const auto& settings = sections.nominal.settings.solver;
    std::vector<std::vector<Outcome<fe::BatchReading>>> of_widths;
    for (const auto* kernels : all_kernels()) {
        if (kernels->rounds_once) {
            of_widths.push_back(
                fe::BatchSolver(sections.parts.model, kernels).incremental(sections.runs, many_variations, settings));
        }
    }
    if (of_widths.size() < 2) {
        GTEST_SKIP() << "one width with fused multiplication, or none";
    }
    for (std::size_t i = 0; i < sections.runs.size(); ++i) {
        for (const auto& other : of_widths) {
            EXPECT_EQ(bits(of_widths[0][i]), bits(other[i])) << i;
        }
    }
}

TEST(Lanes, AreNoMoreThanTheRunsNeed) {
    for (int runs = 1; runs <= 9; ++runs) {
        const auto& chosen = fe::lanes::kernels(runs);
        for (const auto* kernels : all_kernels()) {
            EXPECT_EQ(chosen.rounds_once, all_kernels()[0]->rounds_once);
            if (kernels->rounds_once == chosen.rounds_once && kernels->lanes >= runs) {
                EXPECT_LE(chosen.lanes, kernels->lanes) << runs;
            }
        }
    }
}

// A base without a modulus, and asphalt with a negative one.
TEST(Lanes, ARunWithoutAnswerLeavesTheOthersAsTheyAre) {
    Sections sections(8);
    const auto& settings = sections.nominal.settings.solver;
    fe::BatchSolver batch(sections.parts.model);
    const auto before = batch.incremental(sections.runs, {}, settings);
    sections.layers[3][1].parameters[1] = std::numeric_limits<double>::quiet_NaN();
    sections.layers[5][0].parameters[0] = -1e9;
    const auto after = batch.incremental(sections.runs, {}, settings);
    for (std::size_t i = 0; i < sections.runs.size(); ++i) {
        if (i == 3 || i == 5) {
            continue;
        }
        ASSERT_TRUE(after[i]);
        EXPECT_EQ(bits(before[i]), bits(after[i])) << i;
    }
    fe::Solver<Element> one(sections.parts.model);
    const auto alone = one.incremental(sections.layers[5], sections.parts.load, {}, settings);
    ASSERT_FALSE(alone);
    ASSERT_FALSE(after[5]);
    EXPECT_EQ(alone.failure().reason, after[5].failure().reason);
    EXPECT_EQ(alone.status(), after[5].status());
}

TEST(Lanes, ServeNothingThatTheyCannotFollow) {
    const Sections sections(1);
    const auto& model = sections.parts.model;
    EXPECT_TRUE(fe::BatchSolver::serves(model, sections.layers[0], many_variations));
    EXPECT_FALSE(fe::BatchSolver::serves(model, sections.layers[0], {{Kind::spring}}));
    auto relaxing = sections.layers[0];
    relaxing[0].law = material::find_law("viscoelastic");
    EXPECT_FALSE(fe::BatchSolver::serves(model, relaxing, {}));
    auto linear = sections.layers[0];
    linear[1].law = material::find_law("linear");
    linear[1].parameters = {1e8, 0.35};
    EXPECT_FALSE(fe::BatchSolver::serves(model, linear, {}));
}

} // namespace

// Three linear layers on a half-space under a plate, by the layered engine: points, changed readings, landscapes and
// curves against the forward model asked by hand.
#include "analysis/explore/explore.h"

#include "pavement/forward.h"

#include <cmath>
#include <gtest/gtest.h>

namespace {

using namespace explore;

constexpr const char* text = R"(schema = 1
title = "layers"
[section]
bottom = "half-space"
[[layers]]
name = "top"
thickness_mm = 120
density_kg_m3 = 2300
k0 = 0.5
law = "linear"
modulus_MPa = 3000
poisson = 0.35
[[layers]]
name = "base"
thickness_mm = 300
density_kg_m3 = 2200
k0 = 0.5
law = "linear"
modulus_MPa = 250
poisson = 0.35
[[layers]]
name = "ground"
density_kg_m3 = 1900
k0 = 0.5
law = "linear"
modulus_MPa = 60
poisson = 0.40
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 700
[data]
files = ["bowl.csv"]
misfit = "weighted"
[[parameters]]
name = "top.modulus_MPa"
min = 500
max = 15000
scale = "log"
[[parameters]]
name = "base.modulus_MPa"
min = 50
max = 1500
scale = "log"
[[parameters]]
name = "ground.modulus_MPa"
min = 15
max = 300
scale = "log"
[[outputs]]
name = "strain"
load = "fwd"
quantity = "strain_zz"
depth_mm = 421
)";
constexpr double offsets[] = {0, 200, 300, 450, 600, 900, 1200, 1500};

std::string bowl(const std::vector<double>& um) {
    std::string csv = "load,quantity,x_mm,y_mm,depth_mm,gauge_mm,value,unit,sigma\n";
    for (std::size_t i = 0; i < um.size(); ++i) {
        csv += "fwd,deflection," + std::to_string(offsets[i]) + ",0,0,0," + std::to_string(um[i]) + ",um,2\n";
    }
    return csv;
}

// Responses in SI of the section with these moduli [MPa].
std::vector<double> responses(const study::Study& study, const std::vector<double>& moduli) {
    pave::pavement::Case c = study.model;
    for (std::size_t k = 0; k < moduli.size(); ++k) {
        study.parameters[k].in(c) = moduli[k] * 1e6;
    }
    const pave::pavement::ForwardModel model(study.model);
    return model.run(c, {}, *model.make_workspace()).value().values;
}

struct ExplorerTest : testing::Test {
    const std::vector<double> truth{4000, 200, 70};
    study::Study study;
    std::unique_ptr<analysis::Explorer> explorer;

    ExplorerTest() {
        const study::Study any = study::study_of(text, "layers", {{"bowl.csv", bowl(std::vector<double>(8, 100.0))}});
        study = study::study_of(text, "layers", {{"bowl.csv", bowl(readings_of(any, truth))}});
        analysis::Session session({.threads = 2, .show_progress = false});
        explorer = analysis::Explorer::make(session, study, 3.0);
    }

    static std::vector<double> readings_of(const study::Study& study, const std::vector<double>& moduli) {
        std::vector<double> um;
        for (const double si : responses(study, moduli)) {
            um.push_back(1e6 * si);
        }
        um.resize(8);
        return um;
    }
    double chi2(const std::vector<double>& moduli) const {
        const auto um = readings_of(study, moduli);
        double sum = 0.0;
        for (std::size_t i = 0; i < um.size(); ++i) {
            sum += std::pow((um[i] - study.readings[i].value) / 2.0, 2);
        }
        return sum;
    }
};

TEST_F(ExplorerTest, APointIsTheForwardModelThere) {
    EXPECT_FALSE(explorer->reduced());
    const std::vector<double> at{2000, 400, 50};
    const auto point = explorer->evaluate(at, {});
    const auto wanted = responses(study, at);
    ASSERT_TRUE(point.converged());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_NEAR(point.responses[i], wanted[i], 1e-12 * std::abs(wanted[i])) << i;
    }
    EXPECT_NEAR(explorer->chi2(point), chi2(at), 1e-3 * chi2(at)); // readings have six decimals in their file
    const auto off = explorer->residuals(point, {});
    EXPECT_NEAR(off[0], (1e6 * wanted[0] - study.readings[0].value) / 2.0, 1e-6 * std::abs(off[0]));
}

TEST_F(ExplorerTest, TheMinimumGoesWhereTheReadingsAre) {
    const auto& best = explorer->minima().front().minimum.evaluation.parameters;
    const std::vector<double> other{2500, 300, 55};
    analysis::ChangedReadings changes;
    const auto um = readings_of(study, other);
    for (std::size_t i = 0; i < um.size(); ++i) {
        changes.emplace_back(i, um[i]);
    }
    const auto found = explorer->fit(best, changes);
    ASSERT_TRUE(found);
    for (std::size_t k = 0; k < truth.size(); ++k) {
        EXPECT_NEAR(best[k], truth[k], 1e-3 * truth[k]);
        EXPECT_NEAR(found->minimum.evaluation.parameters[k], other[k], 1e-3 * other[k]);
    }
    // And back, whatever was asked before.
    EXPECT_NEAR(explorer->fit(other, {})->minimum.evaluation.parameters[1], truth[1], 1e-3 * truth[1]);
}

TEST_F(ExplorerTest, NodesOfALandscape) {
    const std::vector<double> at{4000, 200, 80};
    const auto grid = explorer->landscape(0, 1, at, {}, 4, false);
    ASSERT_TRUE(grid);
    ASSERT_EQ(grid->chi2.size(), 16);
    EXPECT_NEAR(grid->x_values.front(), 500, 1e-9);
    EXPECT_NEAR(grid->y_values.back(), 1500, 1e-9);
    for (const auto& [i, j] : {std::pair{1, 2}, std::pair{3, 0}}) {
        const double wanted = chi2({grid->x_values[i], grid->y_values[j], at[2]});
        EXPECT_NEAR(grid->chi2[4 * j + i], wanted, 1e-3 * wanted);
    }
    // With the third parameter fitted: the lowest of a golden section search over it.
    const auto fitted = explorer->landscape(0, 1, at, {}, 4, true);
    ASSERT_TRUE(fitted);
    for (const auto& [i, j] : {std::pair{1, 2}, std::pair{0, 1}}) {
        double low = std::log(15.0);
        double high = std::log(300.0);
        const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
        const auto of = [&](double v) { return chi2({fitted->x_values[i], fitted->y_values[j], std::exp(v)}); };
        for (int k = 0; k < 40; ++k) {
            const double a = high - golden * (high - low);
            const double b = low + golden * (high - low);
            (of(a) < of(b) ? high : low) = of(a) < of(b) ? b : a;
        }
        const double wanted = of(0.5 * (low + high));
        EXPECT_NEAR(fitted->chi2[4 * j + i], wanted, 2e-3 * wanted + 0.02);
        EXPECT_LE(fitted->lowest, 0.01);
    }
}

TEST_F(ExplorerTest, CurvesPassThroughTheSensors) {
    const std::vector<double> at{2000, 400, 50};
    const auto point = explorer->confirm(at, {});
    ASSERT_EQ(point.curves.size(), 1);
    const analysis::Curve& curve = point.curves[0];
    const auto wanted = responses(study, at);
    for (std::size_t i = 0; i < std::size(offsets); ++i) {
        const auto place = std::find(curve.at_mm.begin(), curve.at_mm.end(), offsets[i]);
        ASSERT_NE(place, curve.at_mm.end());
        EXPECT_DOUBLE_EQ(curve.values[static_cast<std::size_t>(place - curve.at_mm.begin())], 1e6 * wanted[i]);
    }
    for (std::size_t i = 1; i < curve.values.size(); ++i) {
        EXPECT_LT(curve.values[i], curve.values[i - 1]); // a bowl
    }
}

TEST_F(ExplorerTest, WhatCannotBeAsked) {
    EXPECT_THROW(explorer->evaluate({1, 2}, {}), std::invalid_argument);
    EXPECT_THROW(explorer->evaluate({1, 2, NAN}, {}), std::invalid_argument);
    EXPECT_THROW(explorer->evaluate({1, 2, 3}, {{8, 1.0}}), std::invalid_argument);
    EXPECT_THROW(explorer->landscape(1, 1, {1, 2, 3}, {}, 5, false), std::invalid_argument);
    EXPECT_THROW(explorer->landscape(0, 1, {1, 2, 3}, {}, 1, false), std::invalid_argument);
    // Out of the box: at its wall.
    const auto wall = explorer->evaluate({1, 2000, 70}, {}).parameters;
    EXPECT_EQ(wall[0], 500);
    EXPECT_EQ(wall[1], 1500);
    EXPECT_NEAR(wall[2], 70, 1e-9);
}

} // namespace

// Readings that the model cannot meet within their noise: chi2 stays that of the stated noise, and what may still be
// left is counted beside it.
TEST_F(ExplorerTest, Chi2IsByTheStatedNoiseThoughThatIsContradicted) {
    std::vector<double> um = readings_of(study, truth);
    for (std::size_t i = 0; i < um.size(); ++i) {
        um[i] += i % 2 == 0 ? 14.0 : -14.0; // of 2
    }
    study = study::study_of(text, "layers", {{"bowl.csv", bowl(um)}});
    analysis::Session session({.threads = 2, .show_progress = false});
    const auto other = analysis::Explorer::make(session, study, 3.0);
    const auto& found = other->minima().front();
    ASSERT_TRUE(found.acceptance && found.acceptance->widened);
    const auto& at = found.minimum.evaluation.parameters;
    EXPECT_NEAR(other->chi2(found.minimum.evaluation), chi2(at), 1e-3 * chi2(at));
    EXPECT_NEAR(other->chi2(found.minimum.evaluation), found.local.chi2, 1e-9 * found.local.chi2);
    EXPECT_NEAR(other->residuals(found.minimum.evaluation, {})[3],
                (1e6 * found.minimum.evaluation.responses[3] - study.readings[3].value) / 2.0, 1e-6);
    // F(1, 5) at 95 % times the variance that five degrees of freedom leave over.
    EXPECT_NEAR(*other->limit(), 6.6079 * chi2(at) / 5.0, 1e-3 * chi2(at));
}

// The reduced model against the full one, at points that it was not built from; the cubature; the derivatives.
#include "reduced/kriging.h"
#include "reduced/nonnegative.h"
#include "reduced/reduced_load.h"
#include "support/sections.h"

#include "base/random.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

using namespace test;

namespace {

const reduced::ForEach one_by_one = [](std::size_t n, const std::function<void(std::size_t)>& body) {
    for (std::size_t i = 0; i < n; ++i) {
        body(i);
    }
};

// CAPTIF pavement 1 with a coarse mesh, a strain gauge and a point of stress in the base and one in the subgrade.
Case section() {
    Case c = captif(3000, 45, {2500, 0.5, -0.4, 0.5});
    c.settings.refine = 0.5;
    c.sensors.resize(5);
    c.sensors.push_back(strain_zz(0.20, 0.075));
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.15, 0.0});
    c.sensors.push_back({0, Quantity::stress_zz, 0.0, 0.0, 0.60, 0.0});
    return c;
}

struct Range {
    const char* path;
    double low, high; // file units
};
constexpr Range box[] = {{"base.k1", 1000, 6000},         {"base.k2", 0.0, 0.7}, // two of the bounds are zero
                         {"base.k3", -1.0, 0.0},          {"base.n", 0.2, 1.0},  {"base.residual_stress_kPa", 0, 20},
                         {"subgrade.modulus_MPa", 25, 90}};

std::vector<Case> samples(const Case& nominal, int count, std::uint64_t seed) {
    const pave::RandomStream random(seed, 0);
    std::uint64_t draw = 0;
    std::vector<Case> list;
    for (int i = 0; i < count; ++i) {
        Case c = nominal;
        for (const Range& r : box) {
            const Parameter p = find_parameter(nominal, r.path, {});
            p.in(c) = p.to_si * (r.low + (r.high - r.low) * random.uniform(draw++));
        }
        list.push_back(std::move(c));
    }
    return list;
}

std::vector<Parameter> parameters(const Case& c) {
    std::vector<Parameter> list;
    for (const Range& r : box) {
        list.push_back(find_parameter(c, r.path, {}));
    }
    return list;
}

struct Built {
    reduced::Basis basis;
    reduced::BuildReport report;
};
const Built& built() {
    static const Built built = [] {
        reduced::BuildSettings settings;
        settings.most_runs = 120;
        settings.calibration = 40;
        reduced::BuildReport report;
        auto outcome = reduced::build(section(), 0, samples(section(), 200, 1), settings, one_by_one, &report);
        EXPECT_TRUE(outcome);
        EXPECT_LE(report.full_runs, settings.most_runs);
        return Built{std::move(outcome).value(), report};
    }();
    return built;
}
const reduced::Basis& basis() {
    return built().basis;
}

ForwardModel reduced_model() {
    return ForwardModel(section(), {std::shared_ptr<const LoadModel>(reduced::make_load_model(section(), 0, basis()))});
}

} // namespace

// Exact solutions with few positive entries; then the conditions of Kuhn and Tucker where there is no exact one.
TEST(NonnegativeLeastSquares, FindsTheSolutionAndMeetsTheConditionsOfKuhnAndTucker) {
    const pave::RandomStream random(3, 0);
    std::uint64_t draw = 0;
    Eigen::MatrixXd a(30, 20);
    for (double& x : a.reshaped()) {
        x = random.uniform(draw++) - 0.3;
    }
    Eigen::VectorXd known = Eigen::VectorXd::Zero(20);
    known[2] = 1.5;
    known[7] = 0.2;
    known[19] = 3.0;
    const Eigen::VectorXd found = reduced::nonnegative_least_squares(a, a * known, 1e-10, 20);
    EXPECT_LT((found - known).norm(), 1e-8);

    Eigen::VectorXd b(30);
    for (double& x : b) {
        x = random.uniform(draw++) - 0.5;
    }
    const Eigen::VectorXd x = reduced::nonnegative_least_squares(a, b, 0.0, 20);
    const Eigen::VectorXd slope = a.transpose() * (b - a * x);
    EXPECT_GE(x.minCoeff(), 0.0);
    for (int i = 0; i < 20; ++i) {
        EXPECT_LE(slope[i], 1e-9);
        EXPECT_NEAR(slope[i] * x[i], 0.0, 1e-9);
    }
    EXPECT_LE((reduced::nonnegative_least_squares(a, b, 0.0, 3).array() > 0.0).count(), 3);
}

// A smooth function of two coordinates out of three and its gradient by the formula; what does not matter gets a longer
// length; values with noise are not followed.
TEST(Kriging, FollowsASmoothFunctionAndItsGradientButNotNoise) {
    const pave::RandomStream random(11, 0);
    std::uint64_t draw = 0;
    const auto place = [&] {
        Eigen::VectorXd x(3);
        for (int i = 0; i < 3; ++i) {
            x[i] = 2.0 * random.uniform(draw++) - 1.0;
        }
        return x;
    };
    const auto value = [](const Eigen::VectorXd& x) { return std::sin(2.0 * x[0]) + 0.5 * x[0] * x[1]; };
    constexpr int count = 150;
    Eigen::MatrixXd places(3, count);
    Eigen::VectorXd values(count);
    for (int i = 0; i < count; ++i) {
        places.col(i) = place();
        values[i] = value(places.col(i));
    }
    const reduced::Kriging exact = reduced::krige(places, values);
    EXPECT_GT(exact.lengths[2], 2.0 * exact.lengths[0]);
    Eigen::VectorXd noisy = values;
    for (double& v : noisy) {
        v += 0.2 * (random.uniform(draw++) - 0.5);
    }
    const reduced::Kriging smoothed = reduced::krige(places, noisy);
    double square = 0.0;
    for (int i = 0; i < 50; ++i) {
        const Eigen::VectorXd x = place();
        Eigen::VectorXd gradient;
        const double found = exact.at(x, &gradient);
        EXPECT_NEAR(found, value(x), 0.02);
        EXPECT_NEAR(gradient[0], 2.0 * std::cos(2.0 * x[0]) + 0.5 * x[1], 0.2);
        EXPECT_NEAR(gradient[1], 0.5 * x[0], 0.2);
        EXPECT_NEAR(gradient[2], 0.0, 0.2);
        square += std::pow(smoothed.at(x, nullptr) - value(x), 2);
    }
    EXPECT_LT(std::sqrt(square / 50.0), 0.2 / std::sqrt(12.0)) << "of the noise of a sample";
}

TEST(ReducedModel, HasAPositiveCubatureOfTheVolumeOfTheBase) {
    const auto parts = parts_of<Axisymmetric>(section(), 0);
    double volume = 0.0;
    for (std::size_t q = 0; q < parts.model.points.size(); ++q) {
        volume += parts.model.topology->layer[q / fe::AxisymmetricQ8::gauss] == 1 ? parts.model.points[q].weight : 0.0;
    }
    double sum = 0.0;
    for (const auto& point : basis().points) {
        EXPECT_GT(point.weight, 0.0);
        EXPECT_EQ(parts.model.topology->layer[static_cast<std::size_t>(point.gauss) / fe::AxisymmetricQ8::gauss], 1);
        sum += point.weight;
    }
    EXPECT_NEAR(sum / volume, 1.0, 0.05);
}

TEST(ReducedModel, AgreesWithTheFullModelWhereItWasNotBuiltAndKnowsItsError) {
    const ForwardModel full(section());
    const ForwardModel reduced = reduced_model();
    auto full_space = full.make_workspace();
    auto reduced_space = reduced.make_workspace();
    std::map<Quantity, std::vector<double>> errors;
    std::vector<double> largest;
    int covered = 0;
    const auto cases = samples(section(), 60, 99);
    for (const Case& c : cases) {
        const auto truth = full.run(c, {}, *full_space);
        const auto quick = reduced.run(c, {}, *reduced_space);
        ASSERT_TRUE(truth && quick);
        ASSERT_EQ(quick->errors.size(), truth->values.size());
        const auto scale = reduced::scales(c, 0, truth->values);
        bool all = true;
        largest.push_back(0.0);
        for (std::size_t i = 0; i < truth->values.size(); ++i) {
            const double error = std::abs(quick->values[i] - truth->values[i]);
            largest.back() = std::max(largest.back(), error / scale[i]);
            errors[c.sensors[i].quantity].push_back(error / scale[i]);
            all = all && error <= quick->errors[i];
        }
        covered += all ? 1 : 0;
    }
    const std::map<Quantity, double> allowed{
        {Quantity::deflection, 0.005}, {Quantity::strain_zz, 0.02}, {Quantity::stress_zz, 0.03}};
    for (auto& [quantity, list] : errors) {
        std::sort(list.begin(), list.end());
        EXPECT_LT(list[list.size() * 95 / 100], allowed.at(quantity)) << info(quantity).name;
        EXPECT_GT(list.back(), 1e-7) << "the reduced model is not the full one";
    }
    // What the report says of the error, from other points; both are quantiles of some fifty samples.
    std::sort(largest.begin(), largest.end());
    const double own = largest[largest.size() * 95 / 100];
    EXPECT_LT(built().report.error_95, 2.0 * own);
    EXPECT_GT(built().report.error_95, 0.5 * own);
    EXPECT_GE(covered, 51) << "of " << cases.size(); // 95 % are meant; fewer than 51 of 60 has a chance of 1e-4 then
}

// Corners, and the middles of the faces: beyond all samples, and where two quantities are zero.
TEST(ReducedModel, HasNumbersAndKnowsItsErrorAtTheCornersAndFacesOfTheBox) {
    std::vector<Case> places;
    constexpr unsigned dimensions = std::size(box);
    const auto place = [&](const std::array<double, dimensions>& share) {
        Case c = section();
        for (unsigned d = 0; d < dimensions; ++d) {
            const Parameter p = find_parameter(c, box[d].path, {});
            p.in(c) = p.to_si * (box[d].low + (box[d].high - box[d].low) * share[d]);
        }
        places.push_back(std::move(c));
    };
    for (unsigned corner = 0; corner < 1U << dimensions; ++corner) {
        std::array<double, dimensions> share{};
        for (unsigned d = 0; d < dimensions; ++d) {
            share[d] = (corner >> d) % 2;
        }
        place(share);
    }
    for (unsigned d = 0; d < dimensions; ++d) {
        for (const double side : {0.0, 1.0}) {
            std::array<double, dimensions> share{};
            share.fill(0.5);
            share[d] = side;
            place(share);
        }
    }
    const ForwardModel full(section());
    const ForwardModel reduced = reduced_model();
    auto full_space = full.make_workspace();
    auto reduced_space = reduced.make_workspace();
    const auto by = parameters(section());
    int covered = 0;
    double worst = 0.0;
    for (const Case& c : places) {
        const auto truth = full.run(c, {}, *full_space);
        const auto quick = reduced.run(c, by, *reduced_space);
        ASSERT_TRUE(truth && quick);
        EXPECT_TRUE(quick->jacobian.allFinite());
        const auto scale = reduced::scales(c, 0, truth->values);
        bool all = true;
        for (std::size_t i = 0; i < truth->values.size(); ++i) {
            const double error = std::abs(quick->values[i] - truth->values[i]);
            EXPECT_TRUE(std::isfinite(error) && std::isfinite(quick->errors[i]));
            worst = std::max(worst, error / scale[i]);
            all = all && error <= 3.0 * quick->errors[i];
        }
        covered += all ? 1 : 0;
    }
    std::printf("  largest error %.3f, covered three times over at %d of %zu\n", worst, covered, places.size());
    EXPECT_GE(covered, static_cast<int>(places.size() * 9 / 10));
}

// By logarithms where the samples are even in them; a range that begins at zero is not, whatever the smallest sample.
TEST(ReducedModel, TakesLogarithmsOnlyOfWhatIsEvenInThem) {
    const pave::RandomStream random(5, 0);
    std::vector<std::vector<fe::LayerMaterial>> layers;
    std::vector<Load> loads;
    for (std::uint64_t i = 0; i < 200; ++i) {
        Case c = section();
        c.layers[1].parameters[1] = 500.0 * std::pow(24.0, random.uniform(3 * i)); // k1
        c.layers[1].parameters[2] = random.uniform(3 * i + 1);                     // k2
        c.layers[1].residual_stress = 40e3 * random.uniform(3 * i + 2);
        layers.push_back(materials_of(c));
        loads.push_back(c.loads[0]);
    }
    const auto coordinates = reduced::coordinates_of(layers, loads);
    ASSERT_EQ(coordinates.size(), 3U);
    Case zero = section();
    zero.layers[1].parameters[2] = 0.0;
    zero.layers[1].residual_stress = 0.0;
    for (const auto& c : coordinates) {
        EXPECT_EQ(c.logarithmic, c.kind == fe::Variation::Kind::law_parameter && c.index == 1);
        EXPECT_LT(std::abs(c.at(materials_of(zero), zero.loads[0])), 1.1);
    }
}

// A correction that is not a number makes a reading a failure with a reason, never a number that is accepted.
TEST(ReducedModel, FailsWhereItsCorrectionIsNoNumber) {
    reduced::Basis spoilt = basis();
    spoilt.correction[0].mean = std::numeric_limits<double>::quiet_NaN();
    const ForwardModel model(section(),
                             {std::shared_ptr<const LoadModel>(reduced::make_load_model(section(), 0, spoilt))});
    const auto outcome = model.run(section(), {}, *model.make_workspace());
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.status(), pave::Status::failed);
    EXPECT_NE(outcome.failure().reason.find("not a finite number"), std::string::npos);
}

TEST(ReducedModel, HasDerivativesThatAgreeWithDifferencesOfItsReadings) {
    const ForwardModel reduced = reduced_model();
    auto space = reduced.make_workspace();
    const auto by = parameters(section());
    Case c = samples(section(), 1, 5)[0];
    const auto here = reduced.run(c, by, *space);
    ASSERT_TRUE(here);
    const auto scale = reduced::scales(c, 0, here->values);
    for (std::size_t k = 0; k < by.size(); ++k) {
        const double width = 8e-3 * by[k].get(c); // the matrix of single precision leaves some noise
        Case up = c, down = c;
        by[k].in(up) += by[k].to_si * width;
        by[k].in(down) -= by[k].to_si * width;
        const auto above = reduced.run(up, {}, *space);
        const auto below = reduced.run(down, {}, *space);
        ASSERT_TRUE(above && below);
        for (std::size_t i = 0; i < scale.size(); ++i) {
            const double difference = (above->values[i] - below->values[i]) / (2.0 * width);
            const auto row = static_cast<Eigen::Index>(i);
            EXPECT_NEAR(here->jacobian(row, static_cast<Eigen::Index>(k)) * by[k].get(c) / scale[i],
                        difference * by[k].get(c) / scale[i], 1e-4)
                << by[k].path << ", sensor " << i;
        }
    }
}

// Its load path takes the same steps everywhere, as the full model's does: of five points in a row the middle one lies
// on the cubic through the others.
TEST(ReducedModel, HasReadingsOnTheCubicThroughTheirNeighbours) {
    const ForwardModel reduced = reduced_model();
    auto space = reduced.make_workspace();
    const auto by = parameters(section());
    for (const Case& from : samples(section(), 6, 9)) {
        std::vector<std::vector<double>> at;
        for (int i = 0; i < 15; ++i) {
            Case c = from;
            for (std::size_t k = 0; k < by.size(); ++k) {
                by[k].in(c) *= 1.0 + 0.004 * i * (k % 2 == 0 ? 1.0 : -1.0);
            }
            const auto response = reduced.run(c, {}, *space);
            ASSERT_TRUE(response);
            at.push_back(response->values);
        }
        const auto scale = reduced::scales(from, 0, at[0]);
        for (std::size_t i = 2; i + 2 < at.size(); ++i) {
            for (std::size_t r = 0; r < scale.size(); ++r) {
                const double cubic = (4.0 * (at[i - 1][r] + at[i + 1][r]) - at[i - 2][r] - at[i + 2][r]) / 6.0;
                EXPECT_NEAR(at[i][r] / scale[r], cubic / scale[r], 1e-5) << "sensor " << r;
            }
        }
    }
}

TEST(ReducedModel, SurvivesBeingPackedAndKnowsWhatIsNoBasis) {
    const std::string bytes = reduced::packed(basis());
    const auto again = reduced::unpacked(bytes);
    ASSERT_TRUE(again);
    EXPECT_EQ(reduced::packed(*again), bytes);
    const ForwardModel model(section(),
                             {std::shared_ptr<const LoadModel>(reduced::make_load_model(section(), 0, *again))});
    const ForwardModel own = reduced_model();
    EXPECT_EQ(model.run(section(), {}, *model.make_workspace())->values,
              own.run(section(), {}, *own.make_workspace())->values);
    EXPECT_FALSE(reduced::unpacked(bytes + "x"));
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{7}, std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
        EXPECT_FALSE(reduced::unpacked(bytes.substr(0, size))) << size;
    }
    EXPECT_FALSE(reduced::unpacked(std::string(1000, '\xff')));
}

TEST(ReducedModel, SaysWhatItDoesNotCover) {
    Case c = section();
    EXPECT_EQ(reduced::why_not(c, 0), "");
    c.settings.integration = Integration::secant;
    EXPECT_NE(reduced::why_not(c, 0), "");
    c = section();
    c.layers[0].compliance = 1e-9;
    EXPECT_NE(reduced::why_not(c, 0), "");
    c = section();
    c.layers[1] = linear_layer("base", 0.277, 300e6, 0.35);
    EXPECT_NE(reduced::why_not(c, 0), "");

    const ForwardModel reduced = reduced_model();
    c = section();
    c.layers[1].thickness *= 1.01;
    const auto moved = reduced.run(c, {}, *reduced.make_workspace());
    ASSERT_FALSE(moved);
    EXPECT_NE(moved.failure().reason.find("geometry"), std::string::npos);
}

// A whole pulse on a base that follows the stress over a rock at a depth that varies too, at sections that the build
// has not seen: deflections within what the full model is from the transform solution (1 %), all within what the
// estimates say. (What is left of a strain in the base after the peak depends on all of the path, and is estimated so.)
TEST(ReducedPulse, ReadsWhatTheFullModelReads) {
    Case nominal = section();
    nominal.sensors = {deflection(0.0), deflection(0.3), deflection(0.9), deflection(1.8), strain_zz(0.20, 0.075)};
    for (std::size_t i = 0; i < 5; ++i) {
        for (const double time : {0.008, 0.014, 0.020}) {
            nominal.sensors.push_back(nominal.sensors[i]);
            nominal.sensors.back().time = time;
        }
    }
    nominal.loads[0].history = haversine_history(0.025, 0.03);
    nominal.settings.time_step = 5e-4;
    constexpr Range varied[] = {{"base.k1", 1000, 4000},
                                {"base.n", 0.3, 1.0},
                                {"subgrade.modulus_MPa", 30, 90},
                                {"subgrade.damping_time_ms", 0.2, 1.0},
                                {"subgrade.thickness_mm", 1500, 4000}};
    const auto drawn = [&](int count, std::uint64_t seed) {
        const pave::RandomStream random(seed, 0);
        std::uint64_t draw = 0;
        std::vector<Case> list;
        for (int i = 0; i < count; ++i) {
            Case c = nominal;
            c.layers[1].residual_stress = 20e3;
            for (const Range& r : varied) {
                const Parameter p = find_parameter(nominal, r.path, {});
                p.in(c) = p.to_si * (r.low + (r.high - r.low) * random.uniform(draw++));
            }
            list.push_back(std::move(c));
        }
        return list;
    };
    reduced::BuildReport report;
    auto built = reduced::build(nominal, 0, drawn(150, 1), {}, one_by_one, &report);
    ASSERT_TRUE(built);
    EXPECT_LT(report.points, 200);
    const ForwardModel full(nominal);
    const ForwardModel reduced(
        nominal, {std::shared_ptr<const LoadModel>(reduced::make_load_model(nominal, 0, std::move(built).value()))});
    auto full_space = full.make_workspace();
    auto reduced_space = reduced.make_workspace();
    int covered = 0;
    std::vector<double> errors;
    constexpr int count = 20;
    for (const Case& c : drawn(count, 2)) {
        const auto truth = full.run(c, {}, *full_space);
        const auto quick = reduced.run(c, {}, *reduced_space);
        ASSERT_TRUE(truth && quick);
        const auto scale = reduced::scales(c, 0, truth->values);
        bool all = true;
        for (std::size_t i = 0; i < scale.size(); ++i) {
            const double error = std::abs(quick->values[i] - truth->values[i]);
            if (c.sensors[i].quantity == Quantity::deflection) {
                errors.push_back(error / scale[i]);
            }
            all = all && error <= quick->errors[i];
        }
        covered += all ? 1 : 0;
    }
    std::sort(errors.begin(), errors.end());
    std::printf("  %d runs, %d modes, %d points, largest error %.4f, covered at %d of %d\n", report.full_runs,
                report.modes, report.points, errors.back(), covered, count);
    EXPECT_LT(errors[errors.size() * 95 / 100], 0.01);
    EXPECT_GT(errors.back(), 1e-7) << "the reduced model is not the full one";
    EXPECT_GE(covered, 15); // 95 % are meant; fewer has a chance of 3e-4 then
}

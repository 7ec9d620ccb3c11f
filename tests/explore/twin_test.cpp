// The twin experiment of the paper (section III): data made by the model are given back as the parameters they were
// made with.
#include "landscape/multistart.h"
#include "study/problems.h"
#include "support/folder.h"
#include "support/sections.h"

#include "base/random.h"

#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

using namespace explore;

namespace {

// Bounds of k1, k2, k3, n.
constexpr double low[] = {500, 0.2, -1.5, 0.1};
constexpr double high[] = {8000, 0.9, 0.0, 1.0};

// A study on disk with an FWD basin and a stack of seven 75 mm gauges, the data made with the truth.
std::string write_twin(const std::string& folder, const std::vector<double>& truth) {
    using namespace test;
    const Case c = captif(3000, 40, {.k1 = truth[0], .k2 = truth[1], .k3 = truth[2], .n = truth[3]});
    const auto response = test::run(c);
    if (!response) {
        ADD_FAILURE() << response.failure().reason;
        return {};
    }
    std::ofstream data(folder + "twin.csv");
    data << data::measurement_header() << "\n";
    for (std::size_t i = 0; i < c.sensors.size(); ++i) {
        const Sensor& s = c.sensors[i];
        const auto& kind = info(s.quantity);
        data << fmt::format("fwd,{},{},0,{},{},{},{},\n", kind.name, s.x * 1e3, s.depth * 1e3, s.gauge * 1e3,
                            response->values[i] / kind.to_si, kind.unit);
    }
    std::ofstream study(folder + "twin.toml");
    study << R"(schema = 1
[[layers]]
name = "asphalt"
thickness_mm = 30
density_kg_m3 = 2200
k0 = 0.5
law = "linear"
modulus_MPa = 3000
poisson = 0.35
[[layers]]
name = "base"
thickness_mm = 277
density_kg_m3 = 2200
k0 = 0.5
law = "uzan"
k1 = 2000
k2 = 0.5
k3 = -0.5
n = 0.5
poisson_12 = 0.35
poisson_31 = 0.35
[[layers]]
name = "subgrade"
thickness_mm = 1193
density_kg_m3 = 2200
k0 = 0.5
law = "linear"
modulus_MPa = 40
poisson = 0.40
[[loads]]
name = "fwd"
type = "plate"
radius_mm = 150
pressure_kPa = 595
[data]
files = ["twin.csv"]
)";
    const char* const names[] = {"base.k1", "base.k2", "base.k3", "base.n"};
    for (int k = 0; k < 4; ++k) {
        study << fmt::format("[[parameters]]\nname = \"{}\"\nmin = {}\nmax = {}\nscale = \"{}\"\n", names[k], low[k],
                             high[k], k == 0 ? "log" : "linear");
    }
    return folder + "twin.toml";
}

} // namespace

TEST(TwinExperiment, GivesBackTheParametersOfNoiseFreeDataFromAtLeast19Of20RandomTruths) {
    int recovered = 0;
    constexpr int truths = 20;
    for (int t = 0; t < truths; ++t) {
        const pave::RandomStream random(51, t);
        std::vector<double> truth;
        for (int k = 0; k < 4; ++k) {
            const double u = random.uniform(k);
            truth.push_back(k == 0 ? low[0] * std::pow(high[0] / low[0], u) : low[k] + u * (high[k] - low[k]));
        }
        const study::Study study = study::load_study(write_twin(test::own_folder(), truth));
        const problem::Problem problem = study::make_problem(study);
        run::Engine engine(problem, nullptr, 0, {.threads = 0, .show_progress = false});
        const auto result = landscape::multistart(engine, problem, search::sobol(problem.space, 64, 1), {.starts = 3});
        ASSERT_TRUE(result);
        ASSERT_FALSE(result->minima.empty());
        const auto& best = result->minima[0].evaluation;
        double worst = 0.0;
        for (int k = 0; k < 4; ++k) {
            worst = std::max(worst, std::abs(best.parameters[k] / truth[k] - 1.0));
        }
        std::printf("  truth k1 %6.0f k2 %.3f k3 %6.3f n %.3f: misfit %.1e, largest error %.4f %%\n", truth[0],
                    truth[1], truth[2], truth[3], best.misfit, 100 * worst);
        recovered += worst < 0.01 ? 1 : 0;
    }
    EXPECT_GE(recovered, truths - 1);
}

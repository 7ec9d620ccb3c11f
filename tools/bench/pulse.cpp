// What a whole pulse costs beside the same load at rest: 60 ms in steps of 0.2 ms with five derivatives, all unknowns
// and the reduced model, on the section of grids/pulse.toml with a base that follows the stress. Medians of runs in
// turn. usage: pulse [RUNS], from the top of the repository
#include "base/random.h"
#include "material/catalog.h"
#include "pavement/forward.h"
#include "reduced/reduced_load.h"
#include "study/problems.h"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace {

using namespace pave::pavement;

struct Range {
    const char* path;
    double low, high; // file units
};
constexpr Range box[] = {{"asphalt.modulus_MPa", 1000, 10000},
                         {"base.k1", 800, 5000},
                         {"base.k2", 0.2, 0.8},
                         {"base.n", 0.2, 1.0},
                         {"subgrade.modulus_MPa", 40, 160}};

double seconds_of(const ForwardModel& model, const Case& c, const std::vector<Parameter>& by,
                  ForwardModel::Workspace& workspace) {
    const auto start = std::chrono::steady_clock::now();
    if (!model.run(c, by, workspace)) {
        fmt::print("no answer\n");
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

} // namespace

int main(int argc, char** argv) {
    const int runs = argc > 1 ? std::atoi(argv[1]) : 15;
    Case moving = explore::study::load_study("grids/pulse.toml").model;
    Layer& base = moving.layers[1];
    base.law = pave::material::find_law("uzan");
    base.parameters = {
        0.0, 2000.0, 0.5, -0.3, 0.4, 0.35, 0.35, pave::material::not_given, 5e3, pave::material::not_given};
    base.residual_stress = 20e3;
    moving.settings.time_step = 2e-4;
    moving.loads[0].history.push_back({0.06, 0.0});
    Case at_rest = moving;
    at_rest.loads[0].history.clear();
    std::erase_if(at_rest.sensors, [](const Sensor& s) { return s.time && *s.time > 0.0021; }); // one of each place
    for (Sensor& sensor : at_rest.sensors) {
        sensor.time.reset();
    }
    std::vector<Parameter> by;
    for (const Range& r : box) {
        by.push_back(find_parameter(moving, r.path, {}));
    }
    std::vector<Case> samples;
    const pave::RandomStream random(1, 0);
    for (std::uint64_t i = 0; i < 160; ++i) {
        Case& c = samples.emplace_back(moving);
        for (std::size_t k = 0; k < by.size(); ++k) {
            by[k].in(c) = by[k].to_si * (box[k].low + random.uniform(by.size() * i + k) * (box[k].high - box[k].low));
        }
    }
    pave::reduced::BuildReport report;
    auto basis = pave::reduced::build(
        moving, 0, samples, {},
        [](std::size_t n, const std::function<void(std::size_t)>& body) { tbb::parallel_for(std::size_t{0}, n, body); },
        &report);
    if (!basis) {
        fmt::print("{}\n", basis.failure().reason);
        return 1;
    }
    const ForwardModel rest(at_rest);
    const ForwardModel full(moving);
    const ForwardModel reduced(moving, {std::shared_ptr<const LoadModel>(
                                           pave::reduced::make_load_model(moving, 0, std::move(basis).value()))});
    const auto rest_space = rest.make_workspace();
    const auto full_space = full.make_workspace();
    const auto reduced_space = reduced.make_workspace();
    std::vector<double> of_rest, of_full, of_reduced, full_ratio, reduced_ratio;
    for (int i = 0; i < runs; ++i) {
        of_rest.push_back(seconds_of(rest, at_rest, by, *rest_space));
        of_full.push_back(seconds_of(full, moving, by, *full_space));
        of_reduced.push_back(seconds_of(reduced, moving, by, *reduced_space));
        full_ratio.push_back(of_full.back() / of_rest.back());
        reduced_ratio.push_back(of_reduced.back() / of_rest.back());
    }
    fmt::print("built of {} full runs: {} modes, {} points, 95 % of errors below {:.2f} %\n", report.full_runs,
               report.modes, report.points, 100.0 * report.error_95);
    fmt::print("at rest {:.1f} ms, pulse {:.0f} ms, reduced {:.1f} ms; ratios to the load at rest {:.1f} and {:.1f}\n",
               1e3 * median(of_rest), 1e3 * median(of_full), 1e3 * median(of_reduced), median(full_ratio),
               median(reduced_ratio));
}

// The reduced model against the full one, on points of a study's box that it was not built from.
// usage: reduced STUDY [POINTS]
#include "reduced/reduced_load.h"
#include "search/design.h"
#include "study/pavement_function.h"
#include "study/study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace {

using namespace pave::pavement;

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Case> cases(const explore::study::Study& study, int count, std::uint64_t seed) {
    std::vector<Case> list;
    for (const auto& unit : explore::search::sobol(study.space, count, seed).points) {
        list.push_back(explore::study::case_at(study.model, study.parameters, study.space.physical(unit)).value());
    }
    return list;
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty() ? NAN : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

} // namespace

int main(int argc, char** argv) {
    const auto study = explore::study::load_study(argv[1]);
    const int points = argc > 2 ? std::atoi(argv[2]) : 500;
    const auto samples = cases(study, 512, 1);
    std::vector<std::shared_ptr<const LoadModel>> models(study.model.loads.size());
    const pave::reduced::ForEach one_by_one = [](std::size_t n, const std::function<void(std::size_t)>& body) {
        for (std::size_t i = 0; i < n; ++i) {
            body(i);
        }
    };
    double begin = seconds();
    for (std::size_t l = 0; l < models.size(); ++l) {
        if (std::none_of(study.model.sensors.begin(), study.model.sensors.end(),
                         [&](const Sensor& s) { return s.load == static_cast<int>(l); })) {
            continue;
        }
        if (const auto why = pave::reduced::why_not(study.model, static_cast<int>(l)); !why.empty()) {
            fmt::print("{}: {}\n", study.model.loads[l].name, why);
            return 1;
        }
        pave::reduced::BuildReport report;
        auto basis = pave::reduced::build(study.model, static_cast<int>(l), samples, {}, one_by_one, &report);
        if (!basis) {
            fmt::print("{}\n", basis.failure().reason);
            return 1;
        }
        fmt::print("{}: {} full runs, {} modes, {} points, 95 % of calibration errors below {:.2f} %\n",
                   study.model.loads[l].name, report.full_runs, report.modes, report.points, 100.0 * report.error_95);
        models[l] = pave::reduced::make_load_model(study.model, static_cast<int>(l), std::move(basis).value());
    }
    fmt::print("built in {:.1f} s\n", seconds() - begin);

    const ForwardModel full(study.model);
    const ForwardModel reduced(study.model, models);
    auto full_space = full.make_workspace();
    auto reduced_space = reduced.make_workspace();
    std::map<std::string, std::vector<double>> errors;
    std::vector<double> slopes, ratios;
    std::vector<double> estimates;
    int covered = 0, all = 0, different = 0;
    for (const Case& c : cases(study, points, 7)) {
        begin = seconds();
        const auto truth = full.run(c, study.parameters, *full_space);
        const double middle = seconds();
        const auto quick = reduced.run(c, study.parameters, *reduced_space);
        const double end = seconds();
        if (!truth || !quick) {
            different += truth.status() != quick.status() ? 1 : 0;
            continue;
        }
        ratios.push_back((middle - begin) / (end - middle));
        bool covers = true;
        double estimate = 0.0;
        for (std::size_t l = 0; l < models.size(); ++l) {
            const auto scale = pave::reduced::scales(c, static_cast<int>(l), truth->values);
            for (std::size_t i = 0; i < scale.size(); ++i) {
                if (c.sensors[i].load != static_cast<int>(l)) {
                    continue;
                }
                const double error = std::abs(quick->values[i] - truth->values[i]);
                errors[std::string(info(c.sensors[i].quantity).name)].push_back(error / scale[i]);
                estimate = std::max(estimate, quick->errors[i] / scale[i]);
                covers = covers && error <= quick->errors[i];
                for (Eigen::Index k = 0; k < truth->jacobian.cols(); ++k) {
                    const auto row = static_cast<Eigen::Index>(i);
                    const double width = study.space.axes[static_cast<std::size_t>(k)].high -
                                         study.space.axes[static_cast<std::size_t>(k)].low;
                    slopes.push_back(std::abs(quick->jacobian(row, k) - truth->jacobian(row, k)) * width / scale[i]);
                }
            }
        }
        covered += covers ? 1 : 0;
        estimates.push_back(estimate);
        ++all;
    }
    for (const auto& [name, list] : errors) {
        fmt::print("{:<12} error: median {:.3f} %, 95th percentile {:.3f} %, largest {:.3f} %\n", name,
                   100.0 * quantile(list, 0.5), 100.0 * quantile(list, 0.95), 100.0 * quantile(list, 1.0));
    }
    fmt::print("derivatives over the box, relative to the reading: 95th percentile of errors {:.2f} %\n",
               100.0 * quantile(slopes, 0.95));
    fmt::print("estimate covers all readings at {} of {} points ({:.1f} %); other status at {}\n", covered, all,
               100.0 * covered / all, different);
    fmt::print("largest estimate at a point: median {:.2f} %, 75 % {:.2f} %, 90 % {:.2f} %, 95 % {:.2f} %\n",
               100.0 * quantile(estimates, 0.5), 100.0 * quantile(estimates, 0.75), 100.0 * quantile(estimates, 0.9),
               100.0 * quantile(estimates, 0.95));
    fmt::print("full over reduced with derivatives: median ratio {:.1f}\n", quantile(ratios, 0.5));
}

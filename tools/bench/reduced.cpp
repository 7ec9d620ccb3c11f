// The reduced model against the full one, on points of a study's box that it was not built from.
// usage: reduced STUDY [POINTS [REFINE [LOAD]]]        LOAD: only what is read under that load
// Builds and compares on all cores; times are of the first points, one at a time.
#include "pavement/forward.h"
#include "reduced/reduced_load.h"
#include "search/design.h"
#include "study/pavement_function.h"
#include "study/problems.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace {

using namespace pave::pavement;

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::vector<Case> cases(const explore::study::Study& study, const std::vector<std::vector<double>>& units) {
    std::vector<Case> list;
    for (const auto& unit : units) {
        list.push_back(explore::study::case_at(study.model, study.parameters, study.space.physical(unit)).value());
    }
    return list;
}

double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty() ? NAN : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// A workspace of every thread.
using Spaces = tbb::enumerable_thread_specific<ForwardModel::WorkspacePointer>;
std::unique_ptr<Spaces> spaces_of(const ForwardModel& model) {
    return std::make_unique<Spaces>([&model] { return model.make_workspace(); });
}

} // namespace

int main(int argc, char** argv) {
    auto study = explore::study::load_study(argv[1]);
    const int points = argc > 2 ? std::atoi(argv[2]) : 500;
    if (argc > 3) {
        study.model.settings.refine = std::atof(argv[3]);
    }
    if (argc > 4) {
        std::erase_if(study.model.sensors, [&](const Sensor& s) {
            return study.model.loads[static_cast<std::size_t>(s.load)].name != argv[4];
        });
    }
    const auto samples = cases(study, explore::search::sobol(study.space, 512, 1).points);
    std::vector<std::shared_ptr<const LoadModel>> models(study.model.loads.size());
    const pave::reduced::ForEach at_once = [](std::size_t n, const std::function<void(std::size_t)>& body) {
        tbb::parallel_for(std::size_t{0}, n, body);
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
        auto basis = pave::reduced::build(study.model, static_cast<int>(l), samples, {}, at_once, &report);
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
    const auto units = explore::search::sobol(study.space, points, 7).points;
    const auto where = cases(study, units);
    struct Answers {
        pave::Outcome<Response> truth, quick;
        double ratio;
    };
    std::vector<std::optional<Answers>> at(where.size());
    const auto full_spaces = spaces_of(full);
    const auto reduced_spaces = spaces_of(reduced);
    const auto compare = [&](std::size_t i) {
        const auto& full_space = full_spaces->local();
        const auto& reduced_space = reduced_spaces->local();
        const double start = seconds();
        auto truth = full.run(where[i], study.parameters, *full_space);
        const double middle = seconds();
        auto quick = reduced.run(where[i], study.parameters, *reduced_space);
        at[i].emplace(std::move(truth), std::move(quick), (middle - start) / (seconds() - middle));
    };
    constexpr std::size_t timed_points = 40;
    const std::size_t timed = std::min(timed_points, where.size());
    for (std::size_t i = 0; i < timed; ++i) {
        compare(i);
    }
    at_once(where.size() - timed, [&](std::size_t i) { compare(timed + i); });

    std::map<std::string, std::vector<double>> errors;
    std::vector<double> slopes, ratios;
    std::vector<double> estimates;
    int covered = 0, all = 0, different = 0;
    for (std::size_t n = 0; n < at.size(); ++n) {
        const Case& c = where[n];
        const auto& [truth, quick, ratio] = *at[n];
        if (!truth || !quick) {
            different += truth.status() != quick.status() ? 1 : 0;
            continue;
        }
        if (n < timed) {
            ratios.push_back(ratio);
        }
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
                    const auto axis = static_cast<std::size_t>(k);
                    const double width = study.space.axes[axis].d_physical(units[n][axis]);
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
    fmt::print("full over reduced with derivatives: median ratio {:.1f} of {} points\n", quantile(ratios, 0.5),
               ratios.size());
}

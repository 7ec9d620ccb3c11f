#include "analysis/survey/survey_outputs.h"

#include "landscape/held_ranges.h"
#include "landscape/prediction_error.h"
#include "run/parallel.h"
#include "study/problems.h"

#include <cmath>
#include <fmt/format.h>
#include <mutex>

namespace explore::analysis {
namespace {

struct Prediction {
    const StationTask* task = nullptr;
    problem::Problem problem; // of the outputs
    int run = 0;              // of the store
};

void set_outputs(const Prediction& prediction, const problem::Evaluation& there) {
    StationFit& fit = *prediction.task->station->fit;
    if (!there.converged()) {
        fit.why_no_outputs = there.reason.empty() ? std::string(to_string(there.status)) : there.reason;
        return;
    }
    const auto& axes = prediction.problem.space.axes;
    for (std::size_t o = 0; o < there.responses.size(); ++o) {
        Eigen::VectorXd gradient = there.jacobian.row(static_cast<Eigen::Index>(o)).transpose();
        for (std::size_t k = 0; k < axes.size(); ++k) {
            gradient[static_cast<Eigen::Index>(k)] *= axes[k].d_physical(fit.best.unit[k]);
        }
        const double value = there.responses[o];
        const double half =
            fit.quantile * landscape::prediction_error(gradient, fit.best, prediction.task->problem, fit.local);
        const auto held = fit.held_by.empty()
                              ? std::nullopt
                              : landscape::held_range(prediction.task->problem, fit.best, fit.local, gradient);
        const bool is_known = held || std::isfinite(half);
        fit.outputs.push_back({.value = value,
                               .low = held       ? value + held->low
                                      : is_known ? value - half
                                                 : value,
                               .high = held       ? value + held->high
                                       : is_known ? value + half
                                                  : value,
                               .determined = is_known});
    }
}

} // namespace

bool predict_outputs(Session& session, SurveyResult& result, const std::vector<StationTask>& tasks) {
    if (result.study->outputs().empty()) {
        return true;
    }
    std::vector<Prediction> predictions;
    for (const StationTask& task : tasks) {
        if (task.station->is_fitted()) {
            const study::Study study =
                study::station_outputs(*result.study, task.station->station, task.station->bowl());
            // The point is the fit's: what determines it belongs to the run.
            const int run = session.begin(
                study, "survey-outputs",
                fmt::format("{} at {}", task.words(), fmt::join(task.station->fit->best.evaluation.parameters, " ")));
            predictions.push_back({&task, study::make_prediction_problem(study), run});
        }
    }
    const int at_once = run::concurrency(session.options().threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, at_once);
    tbb::task_arena arena(at_once);
    std::mutex mutex;
    std::size_t finished = 0;
    run::for_each_index(arena, predictions.size(), [&](std::size_t i) {
        const Prediction& prediction = predictions[i];
        run::Engine engine(prediction.problem, session.store(), prediction.run,
                           {.threads = session.options().threads, .show_progress = false});
        const auto there =
            engine.evaluate({.name = "best fit", .points = {prediction.task->station->fit->best.unit}}, true);
        if (there) {
            const std::scoped_lock lock(mutex);
            set_outputs(prediction, (*there)[0]);
            result.computed += engine.tally().computed;
            ++finished;
        }
    });
    return finished == predictions.size();
}

} // namespace explore::analysis

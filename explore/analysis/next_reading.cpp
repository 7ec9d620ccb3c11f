#include "analysis/next_reading.h"

#include "study/candidates.h"
#include "study/problems.h"

#include <cmath>
#include <ctime>

namespace explore::analysis {

NextReading next_reading(const study::Study& study, const problem::Problem& problem, const landscape::Uniqueness& u) {
    NextReading next;
    const study::Study list = study::candidates(study);
    const problem::Problem readings = study::make_prediction_problem(list);
    const auto workspace = readings.function->make_workspace();
    const auto& best = u.minima[0];
    const auto evaluate = [&](const std::vector<double>& unit, bool with_jacobian) {
        const std::clock_t begin = std::clock();
        auto evaluation = readings.evaluate(unit, with_jacobian, *workspace);
        next.forward_cpu_seconds += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
        return evaluation;
    };
    const auto here = evaluate(best.unit, true);
    if (!here.converged()) {
        next.failed = here.reason;
        return next;
    }
    const auto d = static_cast<Eigen::Index>(best.unit.size());
    next.candidates = list.readings;
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(list.readings.size()), d);
    for (std::size_t i = 0; i < next.candidates.size(); ++i) {
        data::Reading& candidate = next.candidates[i];
        candidate.value = candidate.in_unit(here.responses[i]);
        candidate.noise.absolute = study::candidate_noise(list.model.sensors[i].quantity, here.responses[i]);
        rows.row(static_cast<Eigen::Index>(i)) =
            here.jacobian.row(static_cast<Eigen::Index>(i)) / candidate.noise.absolute;
    }
    const auto outputs = study.outputs();
    Eigen::MatrixXd predictions(static_cast<Eigen::Index>(outputs.size()), d);
    for (std::size_t o = 0; o < outputs.size() && best.evaluation.jacobian.rows() > 0; ++o) {
        predictions.row(static_cast<Eigen::Index>(o)) =
            best.evaluation.jacobian.row(static_cast<Eigen::Index>(outputs[o]));
    }
    for (Eigen::Index k = 0; k < d; ++k) {
        const double stretch =
            problem.space.axes[static_cast<std::size_t>(k)].d_physical(best.unit[static_cast<std::size_t>(k)]);
        rows.col(k) *= stretch;
        predictions.col(k) *= stretch;
    }
    next.effects = landscape::rank_candidates(problem, *u.acceptance, best, rows, predictions);
    if (u.traces.size() == 2) {
        std::vector<std::vector<double>> ends;
        for (const landscape::Branch& trace : u.traces) {
            ends.push_back(trace.points.empty() ? best.unit : trace.points.back().unit);
        }
        const auto a = evaluate(ends[0], false);
        const auto b = evaluate(ends[1], false);
        for (std::size_t i = 0; a.converged() && b.converged() && i < next.candidates.size(); ++i) {
            next.separation.push_back(std::abs(a.responses[i] - b.responses[i]) / next.candidates[i].noise.absolute);
        }
    }
    return next;
}

} // namespace explore::analysis

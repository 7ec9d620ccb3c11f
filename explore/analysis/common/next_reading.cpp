#include "analysis/common/next_reading.h"

#include "analysis/common/candidate_readings.h"

#include <cmath>

namespace explore::analysis {

NextReading next_reading(const study::Study& study, const problem::Problem& problem, const landscape::Uniqueness& u) {
    NextReading next;
    if (study.has_own_model) { // what else it can read it does not say
        return next;
    }
    CandidateReadings candidates(study);
    const auto& best = u.minima[0];
    const auto here = candidates.at(best.unit, true);
    next.forward_cpu_seconds = candidates.forward_cpu_seconds();
    if (!here.converged()) {
        next.failed = here.reason;
        return next;
    }
    next.candidates = candidates.readings(here);
    const Eigen::MatrixXd rows = candidates.rows(here, best.unit, next.candidates);
    const auto d = static_cast<Eigen::Index>(best.unit.size());
    const auto outputs = study.outputs();
    Eigen::MatrixXd predictions(static_cast<Eigen::Index>(outputs.size()), d);
    for (std::size_t o = 0; o < outputs.size() && best.evaluation.jacobian.rows() > 0; ++o) {
        predictions.row(static_cast<Eigen::Index>(o)) =
            best.evaluation.jacobian.row(static_cast<Eigen::Index>(outputs[o]));
    }
    for (Eigen::Index k = 0; k < d; ++k) {
        predictions.col(k) *=
            problem.space.axes[static_cast<std::size_t>(k)].d_physical(best.unit[static_cast<std::size_t>(k)]);
    }
    next.effects = landscape::rank_candidates(problem, *u.acceptance, best, rows, predictions);
    if (u.traces.size() == 2) {
        std::vector<std::vector<double>> ends;
        for (const landscape::Branch& trace : u.traces) {
            ends.push_back(trace.limit_unit);
        }
        const auto a = candidates.at(ends[0], false);
        const auto b = candidates.at(ends[1], false);
        for (std::size_t i = 0; a.converged() && b.converged() && i < next.candidates.size(); ++i) {
            next.separation.push_back(std::abs(a.responses[i] - b.responses[i]) / next.candidates[i].noise.absolute);
        }
    }
    next.forward_cpu_seconds = candidates.forward_cpu_seconds();
    return next;
}

} // namespace explore::analysis

#include "analysis/common/best_so_far.h"

#include <cmath>

namespace explore::analysis {
namespace {

// Of the study's own model; explores: of what explores in its place.
bool is_of(const run::RunHeader& run, std::string_view command, const study::Study& study, bool explores) {
    const std::string_view name = run.key.command;
    const std::string_view hash = run.key.study_hash;
    const bool by_reduced_model = name == "explore" || name == "sample-reduced";
    const bool is_own = hash == study.hash;
    // "HASH on a mesh of ...", "HASH with ..." of mended data; an effect has a parameter more.
    const bool is_varied = hash.starts_with(study.hash + " ") && run.parameters.size() == study.space.axes.size();
    if (!by_reduced_model && name != command && !name.starts_with(std::string(command) + "-")) {
        return false;
    }
    return explores ? (is_own && by_reduced_model) || is_varied : is_own && !by_reduced_model;
}

} // namespace

BestSoFar best_so_far(Session& session, const study::Study& study, std::string_view command) {
    BestSoFar found;
    const run::Store* store = session.store();
    if (store == nullptr) {
        return found;
    }
    const bool by_own_misfit = command == "fit" || command == "map"; // the others compare in units of the noise
    const problem::Problem problem = by_own_misfit ? study::make_problem(study, study::Scope::fitted)
                                                   : study::make_noise_problem(study, study::Scope::fitted);
    for (const bool explores : {false, true}) {
        for (const run::RunHeader& run : store->runs()) {
            if (!is_of(run, command, study, explores)) {
                continue;
            }
            const bool same_data = run.key.study_hash == study.hash;
            store->each(run.id, [&](run::RunNumber, const problem::Evaluation& e) {
                ++found.evaluations;
                if (!e.converged()) {
                    return;
                }
                ++found.answered;
                // Not a number: of a run that compares a part of the readings.
                const double misfit = same_data ? problem.misfit(e) : e.misfit;
                if (std::isfinite(misfit) && (!found.best || misfit < found.best->misfit) &&
                    problem.broken_limits(e).empty()) {
                    found.best = e;
                    found.best->misfit = misfit;
                }
            });
        }
        if (found.evaluations > 0) {
            found.is_explored = explores;
            break;
        }
    }
    if (found.best && !found.is_explored && problem.noise_is_stated()) {
        const problem::Problem readings = problem.of_readings().in_units_of_noise();
        found.chi2 = readings.residuals(*found.best).squaredNorm();
        found.degrees_of_freedom = readings.degrees_of_freedom(study.space.axes.size());
    }
    return found;
}

} // namespace explore::analysis

// The answer so far of an analysis that was ended early.
#pragma once

#include "analysis/common/session.h"

namespace explore::analysis {

struct BestSoFar {
    std::int64_t evaluations = 0; // runs of the study's own model that this command kept
    std::int64_t answered = 0;    // those that have an answer
    bool is_explored = false;     // no such run yet: these are of its reduced model, a coarser mesh or mended data
    std::optional<problem::Evaluation> best; // the one with the lowest misfit, if there is one
    // Of the best point, with the stated noise; none where no noise is stated or the point is of another model.
    std::optional<double> chi2;
    int degrees_of_freedom = 0; // readings less parameters
};

// The best point that the session's folder keeps of the command with this name: of the study's own model or, while
// there is none, of the model that explores in its place. Points that break a constraint do not count.
BestSoFar best_so_far(Session& session, const study::Study& study, std::string_view command);

} // namespace explore::analysis

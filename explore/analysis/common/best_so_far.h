// The answer so far of an analysis that was ended early.
#pragma once

#include "analysis/common/session.h"

namespace explore::analysis {

struct BestSoFar {
    std::int64_t evaluations = 0;            // kept of the study's own model, by this command
    std::int64_t answered = 0;               // of them
    bool is_explored = false;                // none yet: by its reduced model, a coarser mesh or with mended data
    std::optional<problem::Evaluation> best; // of the lowest misfit that the command compares; nothing: none
    // Of the best point's readings by their stated noise; nothing: it is not stated, or the point is explored.
    std::optional<double> chi2;
    int degrees_of_freedom = 0; // readings less parameters
};

// Of the points that the session's folder keeps of the command with this name: those of the study's own model, or
// where it has none yet those of what explores in its place. Points that break a constraint are none.
BestSoFar best_so_far(Session& session, const study::Study& study, std::string_view command);

} // namespace explore::analysis

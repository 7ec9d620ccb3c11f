// A problem as a local search sees it.
#pragma once

#include "optimise/local_search.h"
#include "problem/problem.h"

namespace explore::run {

// The rows of the problem at a converged evaluation with a jacobian, with all derivatives and limits.
inline optimise::Sample sample_of(const problem::Problem& problem, const problem::Evaluation& evaluation) {
    return {.residuals = problem.residuals(evaluation),
            .jacobian = problem.residual_jacobian(evaluation),
            .limits = problem.beyond_limits(evaluation),
            .limit_jacobian = problem.limit_jacobian(evaluation),
            .limit_rows = problem.limit_rows()};
}

} // namespace explore::run

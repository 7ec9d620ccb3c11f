// The stand-in of a study's own model (study/stand_in.h), made from runs that the run's folder keeps.
#pragma once

#include "analysis/common/session.h"

namespace explore::analysis {

// The problem with its stand-in. The model runs at a few points of Sobol's sequence and then where the stand-in is
// least sure of what matters, until it is sure of most of the ranges or has some hundreds of points. fitted: the
// study's fitted readings. Nothing: interrupted. Throws std::runtime_error where the model has too few answers.
std::optional<ReducedProblem> stand_in(Session& session, const problem::Problem& fitted, const study::Study& study,
                                       const ModelOptions& model);

} // namespace explore::analysis

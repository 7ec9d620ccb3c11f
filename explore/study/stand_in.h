// A cheap function in place of a study's own model whose run is expensive: made from points where that was run.
#pragma once

#include "inference/kriging.h"
#include "problem/problem.h"
#include "study/study.h"

namespace explore::study {

struct StandIn {
    inference::Kriging between;
    std::vector<std::vector<double>> holes; // points of the unit cube where the model has no answer
    double factor = 2.0; // what the process's deviations are to be multiplied by: most errors are then below
};

// The point of an evaluation of make_prediction_problem(study), which has converged.
inference::KnownPoint known_point(const Study& study, const problem::Evaluation& evaluation);

// The largest error of a response, estimated at this point, of what is allowed there; above 1 the full model has to
// run. Of a reading that is fitted `limit` (a share) of the larger one of how far it lies off and, where its noise is
// stated, ten standard deviations, else of the measured value; where there are constraints, of an output `limit` of its
// range over the known points.
double error_of_allowed(const Study& study, const StandIn& stand_in, double limit,
                        const inference::Kriging::Answer& answer);

// A problem of the study's fitted readings with the stand-in in place of the model, which runs where the errors are
// above what is allowed, and where a hole is nearer than a known point; such evaluations say so (in_place_of_reduced).
problem::Problem with_stand_in(problem::Problem fitted, const Study& study, std::shared_ptr<const StandIn> stand_in,
                               double limit);

} // namespace explore::study

// The calibration problems of a study.
#pragma once

#include "pavement/forward.h"
#include "problem/problem.h"
#include "study/study.h"

namespace explore::study {

inline constexpr std::size_t most_parameters = 40; // of a problem

// The responses as a function of these parameters, in file units, whatever the model; the others stand at the study's
// own values. loads: which to compute, empty: all.
std::shared_ptr<const problem::ForwardFunction> function_of(const Study& study,
                                                            const std::vector<pave::pavement::Parameter>& parameters,
                                                            const std::vector<bool>& loads);

// The response of a study's own model at the values that `at` has, with derivatives by all parameters or without.
pave::Outcome<pave::pavement::Response> own_response(const Study& study, const pave::pavement::Case& at,
                                                     bool with_jacobian);

// Responses that a problem computes at every point: all, or those of the loads with readings that are fitted (the
// others are then not numbers).
enum class Scope { everything, fitted };

// Of each load: whether readings under it are fitted.
std::vector<bool> fitted_loads(const Study& study);

// Of each load: whether a problem of what is fitted computes it: for its readings, or for a constraint.
std::vector<bool> computed_loads(const Study& study);

// The problem the explorer works on, with the study's own misfit: the readings that are not held out, weighed. Throws
// pave::Error when the study has no parameters or no measurements.
problem::Problem make_problem(const Study& study, Scope scope = Scope::everything);
// One group of readings alone, each with weight 1, and no priors.
problem::Problem make_problem(const Study& study, const Group& group);
// The same problem with every residual in units of its stated noise, whatever the misfit and the weights of the study:
// what statements of probability need. The same as make_problem where the noise is not stated.
problem::Problem make_noise_problem(const Study& study, Scope scope);
// The same with nothing to compare with: for what needs responses and no data. Throws pave::Error when the study has no
// parameters.
problem::Problem make_prediction_problem(const Study& study);
// The responses under these loads alone, without constraints.
problem::Problem make_prediction_problem(const Study& study, const std::vector<bool>& loads);

// The root mean square residual of a group at the responses of the study's sensors, each reading with weight 1.
double group_rms(const Study& study, const Group& group, const std::vector<double>& responses);

} // namespace explore::study

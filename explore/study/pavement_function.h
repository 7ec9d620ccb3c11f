// The forward model as the explorer sees it, and its way to another process.
#pragma once

#include "base/outcome.h"
#include "pavement/forward.h"
#include "problem/forward_function.h"

namespace explore::study {

// The case at these values of its parameters, in file units; invalid-parameters where one is out of its range.
pave::Outcome<pave::pavement::Case> case_at(const pave::pavement::Case& model,
                                            const std::vector<pave::pavement::Parameter>& parameters,
                                            std::span<const double> values);
// The response there. with_jacobian: with its derivatives by all of them.
pave::Outcome<pave::pavement::Response> respond(const pave::pavement::ForwardModel& model,
                                                const std::vector<pave::pavement::Parameter>& parameters,
                                                std::span<const double> values, bool with_jacobian,
                                                pave::pavement::ForwardModel::Workspace& workspace);
// A response as the explorer sees it. with_jacobian: else it has none.
problem::Prediction prediction_of(pave::pavement::Response response, bool with_jacobian);

// The responses of a case as a function of its parameters' values in file units. loads: which to compute, empty: all.
std::shared_ptr<const problem::ForwardFunction> make_function(const pave::pavement::Case& model,
                                                              const std::vector<pave::pavement::Parameter>& parameters,
                                                              const std::vector<bool>& loads);

// The same function from its description(), by the same build of the program. Throws std::runtime_error for bytes that
// are none.
std::shared_ptr<const problem::ForwardFunction> make_function(const std::string& description);

} // namespace explore::study

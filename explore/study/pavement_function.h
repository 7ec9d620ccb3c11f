// The forward model as the explorer sees it, and its way to another process.
#pragma once

#include "pavement/forward.h"
#include "problem/forward_function.h"

namespace explore::study {

// The responses of a case as a function of its parameters' values in file units. loads: which to compute, empty: all.
std::shared_ptr<const problem::ForwardFunction> make_function(const pave::pavement::Case& model,
                                                              const std::vector<pave::pavement::Parameter>& parameters,
                                                              const std::vector<bool>& loads);

// The same function from its description(), by the same build of the program. Throws std::runtime_error for bytes that
// are none.
std::shared_ptr<const problem::ForwardFunction> make_function(const std::string& description);

} // namespace explore::study

// Conditions between the numbers of a study and its outputs, as a user writes them.
#pragma once

#include "problem/limit.h"
#include "study/study.h"

#include <memory>

namespace explore::study {

// Reads "LEFT <= RIGHT", ">=" or "==" over paths of the study and names of its outputs. Throws pave::Error at `place`.
Constraint read_constraint(const Study& study, const std::string& text, const pave::Place& place);

// The conditions of a study for its problems, in their order.
std::vector<std::shared_ptr<const problem::Limit>> limits_of(const Study& study);

// Loads whose outputs the conditions read.
std::vector<bool> constrained_loads(const Study& study);

} // namespace explore::study

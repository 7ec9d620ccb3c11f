// Numbers of a case that follow others.
#pragma once

#include "base/expression.h"
#include "pavement/parameter.h"

namespace pave::pavement {

// Ties path to the value of the expression over other paths of the case, all in file units. Throws Error at `place` for
// an expression that cannot be read, that reads the path itself, also through other ties, or a path that names nothing.
void add_tie(Case& c, const std::string& path, const std::string& expression, const Place& place);

// Values of these paths, in file units. Throws Error for a path that names nothing.
std::vector<double> values_at(const Case& c, const std::vector<std::string>& paths);

// Sets what is tied, in the order of the ties. What is out of its range, in words, or "".
std::string apply_ties(Case& c);

} // namespace pave::pavement

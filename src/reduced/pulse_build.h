// The basis of a whole pulse.
#pragma once

#include "reduced/reduced_load.h"

namespace pave::reduced {

// As build(), of a load with a history: modes and points from the motion at the samples, more of them until the next
// ones are read within a tolerance. Errors are those at the last samples, by sensor; nothing corrects them.
Outcome<Basis> build_pulse(const pavement::Case& nominal, int load, std::span<const pavement::Case> samples,
                           const BuildSettings& settings, const ForEach& for_each, BuildReport& report);

} // namespace pave::reduced

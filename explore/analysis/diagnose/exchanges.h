// Instruments that were exchanged, as the study's model sees it: for those of which no bowl shows it.
#pragma once

#include "data/bowl_faults.h"
#include "diagnose/workbench.h"
#include "study/study.h"

#include <optional>

namespace explore::analysis {

// How many exchanges of two instruments of one kind that read under the same loads there are.
std::size_t possible_exchanges(const study::Study& study, const std::vector<std::size_t>& rows);

// The exchange of two instruments with which the study's model misses the readings least, by its derivatives at its
// best fit: where that leaves no more than noise explains (p = 0.001), or a fifth of what is left as they stand. rows:
// the readings that were fitted; model: fitted to them. Nothing: none, or the errors of readings are correlated.
std::optional<data::BowlFault> likely_exchange(const study::Study& study, const problem::Problem& problem,
                                               const std::vector<std::size_t>& rows, const diagnose::Model& model);

} // namespace explore::analysis

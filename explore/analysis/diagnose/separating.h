// The next reading that would tell explanations apart.
#pragma once

#include "analysis/diagnose/diagnose.h"

namespace explore::analysis {

// The rows of the readings whose own errors are among the first `most` explanations.
std::vector<std::size_t> suspected_readings(const std::vector<study::Variant>& all, const diagnose::Diagnosis& d,
                                            std::size_t most);

// Every explanation predicts what could be read; the best reading is the one whose least separation from the best
// explanation is largest, in standard deviations of the reading and of what the fits leave open.
std::vector<SeparatingReading> separating_readings(const study::Study& study, const std::vector<study::Variant>& all,
                                                   diagnose::Workbench& bench, const diagnose::Diagnosis& d);

} // namespace explore::analysis

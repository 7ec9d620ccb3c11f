// The uncertainty that one more reading would leave.
#pragma once

#include "landscape/next_measurement.h"
#include "landscape/uniqueness.h"
#include "study/study.h"

namespace explore::analysis {

struct NextReading {
    std::vector<data::Reading> candidates; // their value: at the best minimum; their noise: assumed
    std::vector<double>
        separation; // of the ends of the valley by each candidate, in its standard deviations; may be empty
    std::vector<landscape::CandidateEffect> effects; // best first
    double forward_cpu_seconds = 0.0;
    std::string failed; // why there are no candidates; empty: there are
};

// u: of the study's fitted problem, with a best minimum that is accepted.
NextReading next_reading(const study::Study& study, const problem::Problem& problem, const landscape::Uniqueness& u);

} // namespace explore::analysis

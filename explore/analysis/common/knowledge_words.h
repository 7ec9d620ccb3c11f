// The influence of priors and constraints on an answer, in sentences.
#pragma once

#include "landscape/prior_influence.h"

#include <string>
#include <vector>

namespace explore::analysis {

// "0.6 +- 0.1"; of a logarithmic axis "500, times or divided by 1.22"
std::string prior_words(const problem::Axis& axis);

// Conflicts first, then what only the priors determine, then the share of information that each prior contributes.
std::vector<std::string> prior_findings(const problem::Problem& problem, const landscape::PriorInfluence& influence);

// Which constraints hold the answer back, and whether the readings contradict what they demand.
struct ActiveConstraints {
    std::string words; // "": none
    bool contradicted = false;
};
ActiveConstraints active_constraints(const problem::Problem& problem, const landscape::Minimum& answer);

} // namespace explore::analysis

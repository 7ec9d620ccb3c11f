// The readings as the prior predicts them, before any fit: which of them can it not reach?
#pragma once

#include "analysis/common/session.h"
#include "analysis/sample/predictive.h"

namespace explore::analysis {

struct PriorCheck {
    study::Study study;
    std::size_t points = 0, answered = 0;     // drawn from the prior; with an answer
    double effective = 0.0;                   // of those, by their weights
    std::vector<PredictedReading> readings{}; // none: no answer that the constraints allow
    std::int64_t computed = 0, kept = 0;
    std::string missing{}; // why there are no readings

    bool failed() const { return readings.empty(); }
    const std::string& reason() const { return missing; }
    // Rows of the readings beyond 99 % of what the prior predicts.
    std::vector<std::size_t> unreached() const;
};

// Draws points of the prior (uniform on the scale of each parameter over the box, or as the study states it, with its
// correlations and constraints as weights) and computes them by the study's own model. A size of the noise that is
// sought is taken as stated. Throws pave::Error as sample does. Nothing: interrupted.
std::optional<PriorCheck> prior_check(Session& session, const study::Study& study, int points);

// The result in sentences.
std::vector<std::string> findings(const PriorCheck& check);

} // namespace explore::analysis

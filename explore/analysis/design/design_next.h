// The best next step towards a narrower life: a further reading, or a core.
#pragma once

#include "landscape/uniqueness.h"
#include "study/study.h"

namespace explore::analysis {

// To first order at the best set, the parameters with the variance of the data together with that of the box.
struct NarrowingStep {
    std::optional<data::Reading> reading{}; // its noise: assumed; nothing: a core
    std::string parameter{};                // that a core tells, to core_error
    bool is_at_hand = true;                 // known to be possible: a core, and what the study has or says
    double left = 1.0;                      // standard deviation of ln(life) with it, over that without

    std::string words() const;
};

inline constexpr double core_error = 0.1; // relative, of the modulus of the top layer by a test of a core

// Every reading that could be taken, and a core of a linear top layer whose modulus is fitted, the most telling first.
// study: without what its criteria read; fitted: its problem, in units of noise; best: its best minimum, with
// derivatives; gradient: of ln(life) by the unit coordinates. Empty: no answer there.
std::vector<NarrowingStep> narrowing_steps(const study::Study& study, const problem::Problem& fitted,
                                           const landscape::Acceptance& acceptance, const landscape::Minimum& best,
                                           const Eigen::VectorXd& gradient);

} // namespace explore::analysis

// The number of steps of a load path, and the error that they leave in each reading compared with its noise.
#pragma once

#include "analysis/common/session.h"
#include "study/problems.h"

#include <optional>

namespace explore::analysis {

// Estimated at one point from a path with twice as many steps.
struct PathError {
    int steps = 0;
    std::size_t reading = 0; // the reading whose error is the largest share of its noise
    double change = 0.0;     // relative error of that reading
    double share = 0.0;      // |error| over the standard deviation of its noise
    int enough() const;      // steps that leave at most a tenth of the noise; the error falls with their third power
    bool shows() const;      // more than a tenth
};

// Whether a reading of the study that is fitted lies at the end of a load path.
bool follows_load_path(const study::Study& study);

// study: whose problem it is; answer: of that problem, converged. noise: standard deviation of a residual. Nothing: no
// load path, or no answer in twice as many steps.
std::optional<PathError> path_error(const study::Study& study, const problem::Problem& problem,
                                    const problem::Evaluation& answer, double noise);

// The study with the number of steps that an analysis takes all along: its own where it states one or not every reading
// states its noise; else five to the default, if so many leave a fiftieth of the noise in every reading where a short
// search ends and a tenth at the points of a small sample of the box that fit best; else as many as leave a tenth at
// all of them, at most three times the default.
study::Study with_enough_load_steps(study::Study study, const Session& session);

// The same for data that the study's own values make, with errors of this share of each.
study::Study with_enough_load_steps(study::Study study, double relative_noise);

// A forward run at these values, with a warning of the error that the steps of its load paths leave, where that is more
// than 1 % of a value (of a tenth of the largest of its quantity, where the value is less). Loads that need three
// dimensions are not run again.
pave::Outcome<pave::pavement::Response> with_path_warning(const study::Study& study, const pave::pavement::Case& at,
                                                          pave::Outcome<pave::pavement::Response> outcome);

// The error of the load path in a sentence; "": the default is enough at the answer.
std::string path_words(const study::Study& study, const std::optional<PathError>& error);

} // namespace explore::analysis

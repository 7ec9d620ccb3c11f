// The data groups of a fit: how well each is fitted, and what a fit of one alone predicts for the others.
#pragma once

#include "analysis/common/session.h"
#include "landscape/multistart.h"

namespace explore::analysis {

// Computes the responses that a fit skips and a report needs: those of loads held out or without readings.
class Predictor {
public:
    explicit Predictor(const study::Study& study);
    // Fills in the responses and warnings of all loads; leaves those that have no answer as they are, with a warning.
    void complete(problem::Evaluation& evaluation) const;

private:
    problem::Problem problem_;
};

// A fit of all fitted groups together, or of one alone.
struct GroupFit {
    std::string fitted; // "all" or the name of a group
    landscape::Minimum minimum;
    landscape::LocalAnalysis local;
    problem::Evaluation best; // the minimum's, with the responses of every load
    std::vector<double> rms;  // of the residuals of every group of the study, each reading with weight 1
};

GroupFit group_fit(const study::Study& study, const Predictor& predictor, std::string fitted,
                   const problem::Problem& problem, landscape::Minimum minimum);

// The root mean square residual of every group of the study at an evaluation.
std::vector<double> group_rms(const study::Study& study, const problem::Evaluation& evaluation);

// Fits each group that is not held out alone, from the points explored for all of them and from the joint answer.
// Empty where there are fewer than two; none if interrupted.
std::optional<std::vector<GroupFit>> fit_alone(Session& session, const study::Study& study, const Predictor& predictor,
                                               const search::Design& design, const landscape::MultistartResult& joint,
                                               const std::string& settings, landscape::MultistartSettings multistart);

} // namespace explore::analysis

// Outputs of a sample under loads that no reading has, by few runs.
#pragma once

#include "analysis/common/session.h"

namespace explore::analysis {

// A surface through runs at some draws, with their derivatives, compared with runs at others.
struct OutputSurface {
    std::size_t runs = 0;
    std::size_t checks = 0;
    std::vector<double> error; // of each output: root mean square at the checks, SI
};

struct DrawnOutputs {
    std::vector<std::size_t> rows;        // of the study's readings: the outputs whose load has no reading
    Eigen::MatrixXd values;               // a row a draw, SI; not a number: not computed there
    std::optional<OutputSurface> surface; // nothing: none is good enough, and the runs stand for themselves
    std::int64_t computed = 0, kept = 0;
};

// Outputs of the study that the loads of a problem of fitted readings do not give.
std::vector<std::size_t> outputs_besides(const study::Study& study);

// At every draw (unit coordinates, a row each, with weights) by a polynomial of second degree through few runs, where
// its error at other draws is small compared with the spread of the output over the draws; else by runs at `most` of
// the draws. settings: what the draws depend on. Nothing: interrupted.
std::optional<DrawnOutputs> outputs_at_draws(Session& session, const study::Study& study, const Eigen::MatrixXd& units,
                                             const std::vector<double>& weights, std::size_t most,
                                             const std::string& settings);

} // namespace explore::analysis

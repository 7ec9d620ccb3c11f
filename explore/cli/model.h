// --model: whether the full or the reduced model answers.
#pragma once

#include "cli/common.h"
#include "problem/problem.h"

namespace explore::cli {

struct ModelOptions {
    std::string model = "full"; // full, reduced, auto
    double limit_percent = 3.0; // estimated error above which the full model runs

    bool reduced() const { return model != "full"; }
    bool alone() const { return model == "reduced"; }  // what is reported is the reduced model's
    bool confirmed() const { return model == "auto"; } // it is the full model's
};

// alone: whether the command can do with the reduced model alone.
void add_model(CLI::App& app, ModelOptions& options, bool alone = true);

struct ReducedProblem {
    problem::Problem problem;
    std::string settings; // what to add to those of a run
    report::Json json;    // what was built, the same whether now or before
    std::string words;    // a line a load
    bool built = false;   // now
};

// A problem of the study's fitted readings with its reduced model: that of the run's folder when it is still the right
// one, else built and kept there. Nothing: interrupted. Throws pave::Error for a study that has none,
// std::runtime_error where the full model has too few answers.
std::optional<ReducedProblem> reduced_problem(const problem::Problem& fitted, const study::Study& study,
                                              const ModelOptions& options, const std::string& folder, int threads);

} // namespace explore::cli

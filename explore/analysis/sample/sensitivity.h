// How much each parameter moves each response, near the study's own values and over the box.
#pragma once

#include "analysis/common/session.h"
#include "landscape/sensitivity.h"

namespace explore::analysis {

struct SensitivityOptions {
    std::vector<std::string> parameters{}; // empty: all of the study
    double range = 50.0;                   // percent
    int points = 11;
    int samples = 256;
};

struct SensitivityResult {
    struct Curve {
        std::size_t parameter;
        std::vector<problem::Evaluation> points;
    };
    study::Study study; // with the chosen parameters alone
    SensitivityOptions options;
    std::vector<std::size_t> responses; // that are reported: the outputs, or without any the readings
    std::vector<double> changes{};      // of the parameter along a curve, percent
    problem::Evaluation own{};          // at the study's own values, with jacobian
    Eigen::MatrixXd elasticity{};       // responses of the model x parameters
    std::vector<Curve> curves{};        // of the parameters that are not zero
    std::vector<problem::Evaluation> sample{};
    landscape::GlobalSensitivity global{};
    run::Tally tally{};

    bool failed() const { return !own.converged(); }
    std::string reason() const { return "the study's own values have no answer: " + own.reason; }
};

// Throws pave::Error for parameters that there are not. Nothing: interrupted.
std::optional<SensitivityResult> sensitivity(Session& session, study::Study study, const SensitivityOptions& options);

// The findings of the global indices.
std::vector<std::string> findings(const SensitivityResult& result);
// The parameters by decreasing total index.
std::vector<std::size_t> ranked(const landscape::SobolIndices& indices);

} // namespace explore::analysis

// Synthetic data from a study, in the layout of its own measurements.
#pragma once

#include "base/outcome.h"
#include "study/study.h"

namespace explore::analysis {

struct TwinOptions {
    // Standard deviation of a reading's own error as a share of its value; correlated, and with an error in common, as
    // [data.noise] states. 0: exact data.
    double noise = 0.0;
    std::vector<std::pair<std::string, double>> effects{}; // name and size: what the data have and the study does not
    std::uint64_t seed = 1;
};

struct TwinResult {
    study::Study study; // with the effects
    TwinOptions options;
    pave::Status status = pave::Status::converged;
    std::string reason{};                  // when not converged
    std::vector<data::Reading> readings{}; // the synthetic ones
    std::vector<double> exact{};           // of each, without noise, in its unit
};

// Throws pave::Error for a study without a layout of readings, and effects that it cannot have.
TwinResult twin(study::Study study, const TwinOptions& options);

} // namespace explore::analysis

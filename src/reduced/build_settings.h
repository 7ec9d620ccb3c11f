// How a reduced model is built, and what became of it.
#pragma once

#include <cstdint>

namespace pave::reduced {

struct BuildSettings {
    double tolerance = 2e-3; // of readings, at the samples of the build
    int most_runs = 280;     // of the full model, in all
    int calibration = 90;    // of them, to learn what the estimates are worth
    std::uint64_t seed = 1;
};

struct BuildReport {
    int full_runs = 0;
    int modes = 0;
    int points = 0;
    double error_95 = 0.0; // at the calibration samples
};

} // namespace pave::reduced

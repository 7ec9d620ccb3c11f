// The noise of FWD readings, estimated from repeated drops, as [data.noise] states it.
#pragma once

#include "data/repeated_drops.h"

namespace explore::analysis {

// Of ln(deflection / pressure) of one drop:
//     C_ij = common^2 + s_i s_j exp(-|x_i - x_j| / correlation),   s_i^2 = relative^2 + (absolute / D_i)^2.
struct NoiseModel {
    enum Part { relative, common, absolute, correlation };
    static constexpr int parts = 4;
    double value[parts] = {0.0, 0.0, 0.0, 0.0}; // shares; um; mm; 0: not there
    double low[parts] = {0.0, 0.0, 0.0, 0.0};   // 95 % range, by the curvature of the likelihood in logarithms
    double high[parts] = {0.0, 0.0, 0.0, 0.0};
};

struct SensorNoise {
    double offset_mm = 0.0;
    double deflection_um = 0.0; // median over the groups of drops
    int degrees = 0;            // drops less groups
    // Standard deviation of ln(deflection / pressure) and its correlation with the next sensor and the first one: of
    // the drops, and of the model for the same drops.
    double scatter = 0.0, scatter_of_model = 0.0;
    std::optional<double> with_next{}, with_next_of_model{};
    std::optional<double> with_first{}, with_first_of_model{};
};

struct NoiseResult {
    std::size_t stations = 0;
    std::size_t groups = 0; // of repeated drops: a level at a station
    int drops = 0;          // in them
    int degrees = 0;        // drops less groups
    NoiseModel model;
    double resolution_um = 0.0;          // steps of the files, the coarsest
    std::vector<SensorNoise> sensors;    // by offset
    std::vector<std::string> left_out{}; // drops and readings that their repeats contradict, in words

    // The absolute part that a study should state [um]: with what rounding leaves in the mean of the drops, which
    // repeats that round to one digit do not show, where that is more than a sensor errs by anyway.
    double stated_absolute_um() const;
};

// The most likely model (restricted maximum likelihood: the scatter of a group of m drops is Wishart with m - 1 degrees
// of freedom; Fisher scoring in the logarithms of the parts), less the parts without which -2 ln likelihood rises by
// less than 2.71, the 5 % of a part that cannot be negative. Throws pave::Error where no drop is repeated.
NoiseResult noise_of_drops(const std::vector<data::FwdFile>& files);

// The result in sentences.
std::vector<std::string> findings(const NoiseResult& result);

} // namespace explore::analysis

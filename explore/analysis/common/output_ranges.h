// Ranges of the outputs: if the model is right, and if it may lack something.
//
// A model that may be wrong lacks one effect of the catalogue (study/variants.h), or the modulus of a layer or the
// readings carry a smooth correction that nobody knows (pavement/correction.h): one hypothesis each effect or channel
// and strength, all equally probable beforehand; wheels in three dimensions have the corrections alone, for a run each.
// Every hypothesis has a marginal likelihood and gives ln|output| a normal distribution (diagnose/model_average.h).
// Those that explain most are taken around their own best points (Laplace's approximation), the others around the
// answer. The range is that of the mixture: where the data see what is wrong they weigh it, where they are silent the
// strengths stated beforehand do.
#pragma once

#include "study/problems.h"

namespace explore::analysis {

struct OutputUncertainty {
    std::size_t reading = 0;                // of the study
    double best = 0.0;                      // SI, as the following
    double low = 0.0, high = 0.0;           // 95 %, if the model is right: to first order over all minima, or as set
    double wide_low = 0.0, wide_high = 0.0; // 95 %, if it lacks something; need not hold the other
    double of_mesh = 0.0;                   // error of ln|output| by the mesh, which is in both
    double deviation = 0.0;                 // standard deviation of ln|output| by the noise at the best minimum
    std::string channel;                    // or effect, that the data and the strengths allow most: "base-depth"
    double share = 0.0;                     // its probability among them
    bool may_be_right = true;               // the model; else low and high are the wide range
    // Whether the data hold the ends of |output| in the wide range. One that is a factor of e away is not: nothing is
    // linear there any more, and its value means nothing.
    bool least_is_held = true, most_is_held = true;

    // Where the model is not right: nothing is said of what it would be if it were. shown: a value that stands beside
    // the range, which it holds.
    void take_back(double shown);
};

// Of every output with a value other than 0. unit: the answer; others: minima that are as good; noise: standard
// deviation of a residual of study::make_noise_problem. Empty: no output, or no run has an answer.
std::vector<OutputUncertainty> output_ranges(const study::Study& study, const std::vector<double>& unit, double noise,
                                             int threads, const std::vector<std::vector<double>>& others = {});

// A range of an output [SI], widened to what it may be if the model lacks something, where that was computed.
std::pair<double, double> widened(std::pair<double, double> range, const std::vector<OutputUncertainty>& ranges,
                                  std::size_t reading);

// A sentence each.
std::vector<std::string> output_words(const study::Study& study, const std::vector<OutputUncertainty>& ranges);

} // namespace explore::analysis

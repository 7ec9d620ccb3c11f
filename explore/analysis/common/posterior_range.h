// Ranges that were walked beside those of the posterior, and why they differ.
#pragma once

#include "analysis/sample/sample.h"
#include "landscape/uniqueness.h"

namespace explore::analysis {

// From 2.5 % to 97.5 % of the draws.
struct PosteriorRange {
    double low = 0.0, high = 0.0; // physical, of an output SI
    std::string reason{};         // why an end is off by more than a fifth of the walked range; "": it is not
};

struct PosteriorRanges {
    std::vector<PosteriorRange> parameters, outputs; // none: it has not converged
    std::string missing;                             // why
};

// u: with ranges of all parameters; those of outputs may be missing. problem: of u. Lengths are taken on the scales of
// the parameters.
PosteriorRanges posterior_ranges(const problem::Problem& problem, const landscape::Uniqueness& u,
                                 const SampleResult& sampled);

// Which differ, or that none does.
std::vector<std::string> posterior_words(const study::Study& study, const PosteriorRanges& ranges);

} // namespace explore::analysis

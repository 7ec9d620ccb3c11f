// The reduced model (src/reduced) as the explorer sees it: built for a study's box, kept in a file, checked before use.
#pragma once

#include "base/outcome.h"
#include "reduced/reduced_load.h"
#include "study/problems.h"

namespace explore::study {

struct ReducedLoad {
    pave::reduced::Basis basis;
    pave::reduced::BuildReport report;
};
// One a load; none where nothing is fitted.
using ReducedLoads = std::vector<std::optional<ReducedLoad>>;

// Why this study has no reduced model, or "".
std::string why_no_reduced_model(const Study& study);

// The key of a reduced model: section, loads, sensors, parameters and their ranges, samples.
std::string reduced_key(const Study& study, std::size_t samples, const pave::reduced::BuildSettings& settings);

// samples: points of the unit cube in random order. Failure: the full model has too few answers.
pave::Outcome<ReducedLoads> build_reduced(const Study& study, const std::vector<std::vector<double>>& samples,
                                          const pave::reduced::BuildSettings& settings,
                                          const pave::reduced::ForEach& for_each);

// Throws pave::Error where the file cannot be written. Nothing: there is none, it is of another key, or damaged.
void save_reduced(const std::string& file, const std::string& key, const ReducedLoads& loads);
std::optional<ReducedLoads> load_reduced(const std::string& file, const std::string& key);

// A problem of the study's fitted readings with the reduced model in place of the full one, which runs where the
// reduced one estimates an error of any fitted reading above `limit` (relative to pave::reduced::scales) or does not
// cover the point; such evaluations say so (in_place_of_reduced).
problem::Problem with_reduced_model(problem::Problem fitted, const Study& study, const ReducedLoads& loads,
                                    double limit);

} // namespace explore::study

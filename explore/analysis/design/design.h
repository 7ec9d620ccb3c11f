// Life by the answer of a fit: the repetitions that are left and the overlay that is needed, each with its range over
// the parameter sets that the data accept.
#pragma once

#include "analysis/common/output_ranges.h"
#include "analysis/common/session.h"
#include "analysis/design/criterion_life.h"
#include "analysis/design/design_next.h"
#include "landscape/uniqueness.h"

namespace explore::analysis {

struct DesignOptions {
    double reliability_percent = usual_reliability_percent;
    double years = usual_years;
    landscape::UniquenessSettings settings{};
    ModelOptions model{}; // full, or automatic
};

struct DesignResult {
    study::Study study; // with what the criteria read
    DesignOptions options;
    landscape::Uniqueness answer;
    std::vector<CriterionLife> criteria;
    std::optional<Overlay> overlay{};
    std::vector<NarrowingStep> next{}; // what narrows the life that ends first most, best first
    // Runs under the axles between which the walks interpolated strains (analysis/design/design_walks.h), and the
    // largest error of the interpolation in ln(life) at an end.
    std::size_t runs_between = 0;
    double off_between = 0.0;
    std::string no_range{}; // why no range is given; "" where it is
    std::string failure{};  // why there is no answer
    std::int64_t computed = 0, kept = 0;
    double seconds = 0.0;

    bool failed() const { return !failure.empty(); }
    const CriterionLife& governing() const { return ends_first(criteria); }
};

// Throws pave::Error for a study without criteria and one that cannot be fitted. Nothing: interrupted.
std::optional<DesignResult> design(Session& session, const study::Study& study, const DesignOptions& options);

// The answer and what to do next, in sentences.
std::vector<std::string> findings(const DesignResult& result);

} // namespace explore::analysis

// Life by the answer of a fit: how many repetitions are left, and how thick an overlay, each over every
// parameter set that the data accept.
#pragma once

#include "analysis/common/output_ranges.h"
#include "analysis/common/session.h"
#include "analysis/design/design_next.h"
#include "landscape/uniqueness.h"
#include "study/criteria.h"

#include <cmath>

namespace explore::analysis {

struct DesignOptions {
    double reliability_percent = 95.0; // that an overlay lasts its traffic, over what the data accept
    double years = 20.0;               // of traffic that an overlay must last, where a criterion states none
    landscape::UniquenessSettings settings{};
};

// Best estimate, and 95 % over what the data accept; not a number: not known.
struct LifeRange {
    double best = 0.0;
    double low = 0.0, high = 0.0;
    double wide_low = 0.0, wide_high = 0.0; // if the model may lack something
};

struct CriterionLife {
    study::Criterion criterion;
    data::Reading place{}; // where its strain is largest at the best set
    LifeRange strain{};    // microstrain; of a plate not a number
    LifeRange allowable{}; // repetitions; infinite: no strain of its sign
    LifeRange remaining{}; // the same less those that passed, not below 0
    LifeRange years{};     // of the remaining ones
    double required = 0.0; // repetitions, with those that passed, that an overlay must last
    double governs = 0.0;  // probability that its life ends first
    // Whether the data hold the short and the long end of its life if the model may lack something; else those are not
    // numbers.
    bool short_is_held = true, long_is_held = true;

    // Repetitions between which the guide uses the law: a life beyond is only known to be beyond.
    double least() const { return criterion.guide != nullptr ? criterion.guide->least : 0.0; }
    double most() const { return criterion.guide != nullptr ? criterion.guide->most : INFINITY; }
    // Of allowable repetitions: below the law -1, beyond it 1, where it is used 0.
    int beyond(double repetitions) const { return repetitions < least() ? -1 : repetitions > most() ? 1 : 0; }
    bool extrapolated() const { return beyond(allowable.best) != 0; }
};

struct Overlay {
    // Added to the top layer [mm], below 0: what may be milled off. Nothing: no thickness of those tried is enough, or
    // there is no answer.
    std::optional<double> best, low, high; // of the best set, and over the sets at the ends of the ranges
    std::optional<double> reliable;        // at the stated reliability: to be built
    double most = 0.0;                     // thickest that was tried, mm

    // Thickness that is built for want of knowledge [mm]; nothing: not known.
    std::optional<double> cost() const;
};

struct DesignResult {
    study::Study study; // with what the criteria read
    DesignOptions options;
    landscape::Uniqueness answer;
    std::vector<CriterionLife> criteria;
    std::optional<Overlay> overlay{};
    std::vector<NarrowingStep> next{}; // what narrows the life that ends first most, best first
    std::string no_range{};            // why no range is said; "": it is
    std::string failure{};             // why nothing is said
    std::int64_t computed = 0, kept = 0;
    double seconds = 0.0;

    bool failed() const { return !failure.empty(); }
    const CriterionLife& governing() const; // the shortest best life
};

// Throws pave::Error for a study without criteria and one that cannot be fitted. Nothing: interrupted.
std::optional<DesignResult> design(Session& session, const study::Study& study, const DesignOptions& options);

// The answer and what to do next, in sentences.
std::vector<std::string> findings(const DesignResult& result);

// An end of a range, or the best value, in words: "2.6e7"; "> 1e9" beyond the law of the criterion; "-": not known.
std::string repetitions_words(const CriterionLife& c, double allowable);
// The years that are left after so many repetitions in all: "12"; "> 200"; "-".
std::string years_words(const CriterionLife& c, double allowable);

} // namespace explore::analysis

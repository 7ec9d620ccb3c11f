// The life that a criterion allows, and the overlay that all of them need: the basis of a decision.
#pragma once

#include "study/criteria.h"

#include <cmath>
#include <optional>

namespace explore::analysis {

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
    // Allowable repetitions, rising, and the probability that the life is shorter: normal deviates by the root of the
    // rise of chi2 along the profile. Empty: not known.
    std::vector<std::pair<double, double>> distribution{};
    // Whether the data hold the short and the long end of its life if the model may lack something; else those are not
    // numbers.
    bool short_is_held = true, long_is_held = true;

    // Repetitions between which the guide uses the law: a life beyond is only known to be beyond.
    double least() const { return criterion.guide != nullptr ? criterion.guide->least : 0.0; }
    double most() const { return criterion.guide != nullptr ? criterion.guide->most : INFINITY; }
    // Of allowable repetitions: below the law -1, beyond it 1, where it is used 0.
    int beyond(double repetitions) const { return repetitions < least() ? -1 : repetitions > most() ? 1 : 0; }
    bool extrapolated() const { return beyond(allowable.best) != 0; }
    // The remaining repetitions and the years of the allowable ones.
    void set_remaining();
};

// The one with the shortest best life. lives: at least one.
const CriterionLife& ends_first(const std::vector<CriterionLife>& lives);

struct Overlay {
    // Thickness added to the top layer [mm]; below 0: it may be milled off. None where no thickness tried is enough or
    // there is no answer.
    std::optional<double> best, low, high; // of the best set, and over the sets at the ends of the ranges
    std::optional<double> reliable;        // at the stated reliability: to be built
    double most = 0.0;                     // thickest that was tried, mm

    // Thickness that is built for want of knowledge [mm]; nothing: not known.
    std::optional<double> cost() const;
};

inline constexpr double usual_reliability_percent = 95.0; // that an overlay lasts, over what the data accept
inline constexpr double usual_years = 20.0; // of traffic that an overlay must last, where a criterion states none

// 2.6e7, not 2.6e+07.
std::string repetitions_figure(double value);
// An end of a range, or the best value, in words: "2.6e7"; "> 1e9" beyond the law of the criterion; "-": not known.
std::string repetitions_words(const CriterionLife& c, double allowable);
// The years that are left after so many repetitions in all: "12"; "> 200"; "-".
std::string years_words(const CriterionLife& c, double allowable);

} // namespace explore::analysis

// Stations that deflect clearly more than the others of their section.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// One of a survey's stations. Its ln D0 at the road's common pressure lies more than weak_deviations robust standard
// deviations (1.4826 times the median absolute deviation, at least weak_scatter) above the median of its section; of
// its profile and lane where there are no sections. Fewer than section_stations stations are not judged.
struct WeakStation {
    std::size_t station = 0;
    double d0_ratio = 1.0;                // over the median
    std::optional<std::size_t> parameter; // that is lowest against the median of the others, in the same deviations
    double parameter_ratio = 1.0;         // over the median
};
inline constexpr double weak_deviations = 3.5; // Iglewicz and Hoaglin (1993)
inline constexpr double weak_scatter = 0.05;   // stations of a uniform road differ by that

// Worst first; nothing: there are too few stations to judge any.
std::optional<std::vector<WeakStation>> weak_stations(const SurveyResult& result);

// In a sentence; "": there is none, or none is judged.
std::string weak_words(const SurveyResult& result);

} // namespace explore::analysis

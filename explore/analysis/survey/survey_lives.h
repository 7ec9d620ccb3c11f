// Life and overlay at every station of a road whose study has criteria, and what is typical of its sections.
#pragma once

#include "analysis/survey/survey_stations.h"

namespace explore::analysis {

// Throws pave::Error where the criteria of a survey's study cannot be evaluated.
void check_criteria(const study::Study& survey);

// A station whose fit is finished: how well a quantity with this gradient by the unit coordinates is known there, its
// standard error; infinity: not known.
struct StationToLast {
    StationResult* station = nullptr;
    std::string words; // of the store
    std::function<double(const Eigen::VectorXd& gradient)> error;
};

// Sets StationFit::lives. To first order: ln of the life is normal about that of the best fit, with the error of its
// gradient; an overlay at an end of the range, or at a reliability, is that of the best fit for as many more
// repetitions as the life may be shorter there. False: interrupted.
bool predict_lives(Session& session, SurveyResult& result, const std::vector<StationToLast>& stations);

// Of a section of the road: the years that 85 % of its stations exceed, the overlay that is enough at 85 % of them.
struct SectionLife {
    std::size_t stations = 0;
    double years = 0.0, years_low = 0.0, years_high = 0.0;     // by the best fits, and by the ends of their ranges
    std::optional<double> overlay_mm{}, overlay_reliable_mm{}; // nothing: no thickness of those tried is enough
};
std::optional<SectionLife> life_of_section(const SurveyResult& result, const RoadSection& section);

} // namespace explore::analysis

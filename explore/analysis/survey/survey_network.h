// Searches of a stress-dependent road by reduced models that many stations share.
#pragma once

#include "analysis/survey/survey_stations.h"

namespace explore::analysis {

inline constexpr std::size_t network_stations = 8; // from so many on a reduced model of their layout pays

// A station with the points from which to search it.
struct StationSearch {
    const StationTask* task = nullptr;
    std::string settings; // of its run
    std::vector<std::vector<double>> starts;
    // By a reduced model: of so many searches those that ended in its best minimum, and how many minima there were.
    // Then `starts` are the best of these minima.
    std::vector<int> members{};
    std::size_t minima = 0, searched = 0;

    bool by_network() const { return searched > 0; }
};

// The reduced models of a road, one for every plate and set of sensors that enough of its stations have.
class Networks {
public:
    Networks(Session& session, SurveyResult& result) : session_(session), result_(result) {}

    // False: interrupted.
    bool build(const std::vector<StationTask>& tasks);
    // Of these sensors; none: too few stations have them, or the study has no reduced model.
    const ReducedProblem* of(const data::DeflectionBowl& layout) const;
    // Searches the stations that have one, and puts what was found in place of their starts. False: interrupted.
    bool search(std::vector<StationSearch>& searches, const landscape::MultistartSettings& settings);

private:
    Session& session_;
    SurveyResult& result_;
    std::map<std::vector<double>, ReducedProblem> networks_; // by layout_key()
};

// The problem of bowls with this model in place of the finite elements.
problem::Problem on_network(problem::Problem problem, const ReducedProblem& network,
                            const std::vector<const data::DeflectionBowl*>& bowls, const data::DeflectionBowl& layout);

} // namespace explore::analysis

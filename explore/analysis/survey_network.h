// Searches of a stress-dependent road by reduced models that many stations share.
#pragma once

#include "analysis/survey_stations.h"

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

// Searches the stations of every layout that has enough of them by one reduced model, and puts what it found in place
// of their starts. False: interrupted.
bool search_by_networks(Session& session, SurveyResult& result, std::vector<StationSearch>& searches,
                        const landscape::MultistartSettings& settings);

} // namespace explore::analysis

#include "analysis/survey/survey_places.h"

#include "data/median.h"

#include <fmt/format.h>
#include <set>

namespace explore::analysis {
namespace {

constexpr double plate_m = 0.3;
constexpr double to_m = 1000.0; // from kilometres
constexpr std::size_t least_places = 3;

double median_spacing(const std::vector<double>& places) {
    std::vector<double> spacing;
    for (std::size_t i = 1; i < places.size(); ++i) {
        spacing.push_back(places[i] - places[i - 1]);
    }
    return data::median(spacing);
}

} // namespace

std::string doubtful_places(const SurveyResult& result) {
    std::set<double> distinct;
    for (const StationResult& s : result.stations) {
        if (s.station.chainage_m) {
            distinct.insert(*s.station.chainage_m);
        }
    }
    const std::vector<double> places(distinct.begin(), distinct.end());
    if (places.size() < least_places) {
        return "";
    }
    if (const double spacing = median_spacing(places);
        spacing < plate_m && places.back() - places.front() < plate_m * static_cast<double>(places.size())) {
        return fmt::format(
            "Stations lie {:.2g} m apart (median), closer than a loading plate is wide: are their places "
            "in kilometres?",
            spacing);
    }
    for (std::size_t i = 1; i + 1 < places.size(); ++i) { // the first i + 1 are in kilometres
        const std::vector<double> near(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        const double first = to_m * near.front();
        const double last = to_m * near.back();
        const double range = places.back() - places[i + 1];
        const bool goes_on = first > places[i + 1] - 2.0 * range - (last - first) && last < places.back() + range;
        if (near.front() > 0.0 && median_spacing(near) < plate_m && places[i + 1] > 0.5 * first && goes_on &&
            places[i + 1] > to_m / 10.0 * near.back()) {
            return fmt::format("Places from {:g} to {:g} m stand beside places from {:g} to {:g} m: kilometres beside "
                               "metres in one column?",
                               near.front(), near.back(), places[i + 1], places.back());
        }
    }
    return "";
}

} // namespace explore::analysis

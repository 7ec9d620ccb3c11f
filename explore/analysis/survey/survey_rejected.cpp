#include "analysis/survey/survey_rejected.h"

#include "base/units.h"
#include "data/bowl_faults.h"

#include <algorithm>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

bool is_rejected(const StationResult& s) {
    return !s.has_bowl();
}

// Of the last drops of the first stations that are rejected, each taken for a load; "": none.
std::string common_fault(const SurveyResult& result) {
    constexpr int most_bowls = 20;
    constexpr double repeats_within = 0.02; // of a reading: what neighbours are compared by
    std::vector<data::BowlPoint> points;
    int bowls = 0;
    for (const StationResult& s : result.stations) {
        if (!is_rejected(s) || s.station.drops.empty() || bowls == most_bowls) {
            continue;
        }
        const data::FwdDrop& drop = s.station.drops.back();
        for (const data::FwdReading& reading : drop.readings) {
            const double value = reading.deflection_um * pave::unit::um;
            points.push_back({.row = points.size(),
                              .load = bowls,
                              .offset = std::abs(reading.offset_mm) * pave::unit::mm,
                              .value = value,
                              .deviation = repeats_within * std::abs(value)});
        }
        ++bowls;
    }
    const auto faults = bowls > 1 ? data::bowl_faults(points) : std::vector<data::BowlFault>();
    const auto found =
        std::ranges::find_if(faults, [](const data::BowlFault& f) { return f.is_mendable() && !f.of_one_load; });
    return found != faults.end() ? found->words() : "";
}

} // namespace

std::string rejected_words(const SurveyResult& result) {
    const std::size_t count = result.count(is_rejected);
    if (count == 0) {
        return "";
    }
    const auto& first = *std::ranges::find_if(result.stations, is_rejected);
    const std::string fault = 2 * count > result.stations.size() ? common_fault(result) : "";
    return fmt::format("{} {} rejected. {}{}: {}", count, count == 1 ? "station is" : "stations are",
                       fault.empty() ? "" : fmt::format("As they all read, {}. ", fault), first.station.name,
                       first.reason);
}

} // namespace explore::analysis

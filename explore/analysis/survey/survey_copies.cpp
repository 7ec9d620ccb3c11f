#include "analysis/survey/survey_copies.h"

#include <fmt/format.h>
#include <map>

namespace explore::analysis {
namespace {

// All that was measured, in the order of the file.
std::vector<double> numbers_of(const data::FwdStation& station) {
    std::vector<double> numbers;
    for (const data::FwdDrop& drop : station.drops) {
        for (const data::FwdReading& reading : drop.readings) {
            numbers.push_back(reading.deflection_um);
        }
    }
    return numbers;
}

} // namespace

std::string copied_stations(const SurveyResult& result) {
    constexpr std::size_t least_numbers = 5; // fewer may be alike by chance
    std::map<std::vector<double>, const StationResult*> known;
    std::size_t count = 0;
    std::string first;
    for (const StationResult& s : result.stations) {
        std::vector<double> numbers = numbers_of(s.station);
        if (numbers.size() < least_numbers) {
            continue;
        }
        const auto [at, is_new] = known.try_emplace(std::move(numbers), &s);
        if (!is_new && ++count == 1) {
            first = fmt::format("{} reads what {} does in all {} numbers", s.station.name, at->second->station.name,
                                at->first.size());
        }
    }
    return count == 0 ? ""
                      : fmt::format(
                            "{}{}: a copy? Measured twice, no deflections are the same to the last digit.", first,
                            count > 1 ? fmt::format(", and so {} {} more", count == 2 ? "does" : "do", count - 1) : "");
}

} // namespace explore::analysis

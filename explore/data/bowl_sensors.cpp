#include "data/bowl_sensors.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace explore::data {
namespace {

constexpr double contradicts = 1.25; // an outer deflection over an inner one, and
constexpr double contradicts_um = 4.0;
constexpr double dead_share = 0.25; // of a sensor further out
constexpr double faint_fall = 4.0;  // of two neighbours
constexpr double far_mm = 600.0;

} // namespace

std::optional<double> most_contradicted(const std::map<double, BowlReading>& readings) {
    std::map<double, int> others;
    std::optional<double> dead; // the inner one of a pair
    for (auto inner = readings.begin(); inner != readings.end(); ++inner) {
        for (auto outer = std::next(inner); outer != readings.end(); ++outer) {
            const double low = inner->second.deflection_um;
            const double high = outer->second.deflection_um;
            if (high > contradicts * low + contradicts_um) {
                ++others[inner->first];
                ++others[outer->first];
                dead = low < dead_share * high && !dead ? std::optional(inner->first) : dead;
            }
        }
    }
    const auto most = std::max_element(others.begin(), others.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    return most != others.end() && most->second > 1 ? std::optional(most->first) : dead;
}

std::vector<std::string> faint_sensors(const std::vector<BowlReading>& readings) {
    std::vector<std::string> words;
    for (std::size_t i = 1; i < readings.size(); ++i) {
        const BowlReading& inner = readings[i - 1];
        const BowlReading& outer = readings[i];
        const double usual = std::max(faint_fall, std::pow(outer.offset_mm / inner.offset_mm, 3.0));
        if (outer.offset_mm >= far_mm && inner.deflection_um > usual * outer.deflection_um) {
            words.push_back(fmt::format("the deflection falls from {:.1f} um at {:g} mm to {:.1f} um at {:g} mm: is "
                                        "that sensor nearly dead, or "
                                        "the line cut off?",
                                        inner.deflection_um, inner.offset_mm, outer.deflection_um, outer.offset_mm));
        }
    }
    return words;
}

} // namespace explore::data

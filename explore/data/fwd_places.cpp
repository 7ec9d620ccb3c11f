#include "data/fwd_places.h"

#include "data/csv.h"
#include "data/fwd_table.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace explore::data {
namespace {

constexpr double station_m = 20.0;
constexpr double kilometre_m = 1000.0;

// "163+10"; nothing: something else.
std::optional<std::pair<double, double>> sum(std::string_view cell) {
    const std::size_t plus = cell.find('+');
    if (plus == std::string_view::npos || plus == 0) {
        return std::nullopt;
    }
    const auto before = number_or_nothing(trimmed(cell.substr(0, plus)));
    const auto after = number_or_nothing(trimmed(cell.substr(plus + 1)));
    return before && after && *before >= 0.0 && *after >= 0.0 ? std::optional(std::pair(*before, *after))
                                                              : std::nullopt;
}

// How often the chainage turns back.
int reversals(const std::vector<double>& places) {
    int found = 0;
    double way = 0.0;
    for (std::size_t i = 1; i < places.size(); ++i) {
        const double step = places[i] - places[i - 1];
        found += step * way < 0.0 ? 1 : 0;
        way = step != 0.0 ? step : way;
    }
    return found;
}

} // namespace

PlaceForms::PlaceForms(const std::vector<std::vector<std::string>>& rows, std::size_t header, std::size_t column,
                       char decimal) {
    for (std::size_t r = header; r < rows.size(); ++r) {
        if (column >= rows[r].size()) {
            continue;
        }
        const std::string cell = with_point(trimmed(rows[r][column]), decimal);
        if (const auto both = sum(cell)) {
            sums_.push_back(*both);
            as_kilometres_.push_back(kilometre_m * both->first + both->second);
            as_stations_.push_back(station_m * both->first + both->second);
            example_ = example_.empty() ? std::string(trimmed(rows[r][column])) : example_;
        } else if (const auto number = measured(cell)) {
            plain_.push_back(*number);
            as_kilometres_.push_back(*number);
            as_stations_.push_back(station_m * *number);
        }
    }
}

PlaceForms::Meaning PlaceForms::meaning(std::string_view column_name) const {
    if (sums_.empty()) {
        return Meaning::plain;
    }
    const bool is_short = std::all_of(sums_.begin(), sums_.end(), [](const auto& s) {
        return s.second < station_m && s.first == std::floor(s.first);
    });
    const auto [low, high] = std::minmax_element(sums_.begin(), sums_.end());
    const auto lie_between = [&](double from, double to) {
        return std::all_of(plain_.begin(), plain_.end(), [&](double n) { return n >= from && n <= to; });
    };
    if (is_short && lower_case(column_name).find("estaca") != std::string::npos) {
        return Meaning::stations_of_20_m;
    }
    if (mixes()) {
        const bool are_whole = std::all_of(plain_.begin(), plain_.end(), [](double n) { return n == std::floor(n); });
        constexpr double beside = 5.0;
        // Neighbours of the sums as kilometres + metres: one way of writing beside another.
        const bool are_metres = lie_between(kilometre_m * (low->first - 1.0), kilometre_m * (high->first + 2.0));
        const int turns_less = reversals(as_kilometres_) - reversals(as_stations_);
        if (is_short && are_whole && lie_between(low->first - beside, high->first + beside) &&
            (are_metres ? turns_less > 0 : turns_less >= 0)) {
            return Meaning::stations_of_20_m;
        }
        return are_metres ? Meaning::plain : Meaning::doubtful;
    }
    // Places a kilometre apart of which none lies 20 m or more behind a full one.
    std::set<double> numbers;
    std::set<double> metres;
    for (const auto& [number, after] : sums_) {
        numbers.insert(number);
        metres.insert(after);
    }
    return is_short && numbers.size() >= 3 && metres.size() >= 2 ? Meaning::doubtful : Meaning::plain;
}

std::optional<double> chainage_of_20_m(std::string_view cell) {
    if (const auto both = sum(trimmed(cell))) {
        return station_m * both->first + both->second;
    }
    const auto number = measured(cell);
    return number ? std::optional(station_m * *number) : std::nullopt;
}

} // namespace explore::data

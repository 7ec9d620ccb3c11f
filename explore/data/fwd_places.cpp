#include "data/fwd_places.h"

#include "data/csv.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

namespace explore::data {
namespace {

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

// Whether most follow each other by one or two: no road is measured at every metre.
bool are_next_to_each_other(const std::vector<double>& places) {
    std::size_t near = 0;
    std::size_t steps = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
        const double step = std::abs(places[i] - places[i - 1]);
        steps += step > 0.0 ? 1 : 0;
        near += step > 0.0 && step <= 2.0 ? 1 : 0;
    }
    return steps > 0 && 2 * near > steps;
}

bool is_whole(double number) {
    return number == std::floor(number);
}

} // namespace

Places::Places(const std::vector<std::string>& cells, std::string_view column_name, std::optional<double> to_m,
               bool is_american)
    : to_m_(to_m),
      is_american_(is_american) {
    for (const std::string& text : cells) {
        const std::string_view cell = trimmed(text);
        if (const auto both = sum(cell)) {
            sums_.push_back(*both);
            numbers_.push_back(both->first);
            after_.emplace_back(both->second);
            example_ = example_.empty() ? std::string(cell) : example_;
        } else if (const auto number = measured(cell)) {
            plain_.push_back(*number);
            numbers_.push_back(*number);
            after_.emplace_back();
            plain_example_ = plain_example_.empty() ? std::string(cell) : plain_example_;
        }
    }
    if (to_m_ && *to_m_ != 1.0 && *to_m_ != foot_m) {
        return;
    }
    meaning_ = meaning(column_name);
    const bool in_feet = is_in_feet();
    if (meaning_ == Meaning::stations) {
        remark_ = in_feet ? fmt::format("plain numbers such as \"{}\" are taken for full stations of 100 ft, as \"{}\" "
                                        "stands beside them",
                                        plain_example_, example_)
                          : fmt::format("places such as \"{}\" are taken for stations of 20 m: 20 x number + metres",
                                        example_.empty() ? plain_example_ : example_);
    } else if (meaning_ == Meaning::doubtful) {
        remark_ = in_feet ? fmt::format("plain numbers such as \"{}\" are taken for feet, \"{}\" in the same column "
                                        "for stations of 100 ft: is that so?",
                                        plain_example_, example_)
                          : fmt::format("places such as \"{}\" are taken for kilometres + metres{}: are they stations "
                                        "of 20 m, or of 100 ft?",
                                        example_, mixes() ? ", plain numbers in the same column for metres" : "");
    } else if (in_feet && !to_m_ && mixes()) {
        remark_ = fmt::format("plain numbers such as \"{}\" are taken for feet, as \"{}\" (stations of 100 ft) stands "
                              "beside them",
                              plain_example_, example_);
    }
}

bool Places::is_in_feet() const {
    return to_m_ ? *to_m_ == foot_m : is_american_ && !sums_.empty();
}

double Places::whole() const {
    return is_in_feet() ? 100.0 : 1000.0;
}

double Places::step() const {
    constexpr double estaca_m = 20.0;
    return is_in_feet() ? 100.0 * foot_m : estaca_m;
}

Places::Meaning Places::meaning(std::string_view column_name) const {
    const bool are_whole = std::all_of(plain_.begin(), plain_.end(), is_whole);
    // Nothing after a plus is as long as a station.
    const bool is_short = std::all_of(sums_.begin(), sums_.end(), [&](const auto& s) {
        return s.second * (is_in_feet() ? foot_m : 1.0) < step() && is_whole(s.first);
    });
    const bool is_estaca = !is_in_feet() && lower_case(column_name).find("estaca") != std::string::npos;
    if (is_estaca && is_short && are_whole && (!sums_.empty() || are_next_to_each_other(plain_))) {
        return Meaning::stations;
    }
    if (sums_.empty()) {
        return Meaning::plain;
    }
    if (mixes()) {
        const auto [low, high] = std::minmax_element(sums_.begin(), sums_.end());
        const auto lie_between = [&](double from, double to) {
            return std::all_of(plain_.begin(), plain_.end(), [&](double n) { return n >= from && n <= to; });
        };
        std::vector<double> as_they_are;
        std::vector<double> as_stations;
        for (std::size_t i = 0; i < numbers_.size(); ++i) {
            as_they_are.push_back(after_[i] ? whole() * numbers_[i] + *after_[i] : numbers_[i]);
            as_stations.push_back(step() * numbers_[i] + after_[i].value_or(0.0) * (is_in_feet() ? foot_m : 1.0));
        }
        constexpr double beside = 5.0;
        // Neighbours of the sums in units: one way of writing beside another.
        const bool are_units = lie_between(whole() * (low->first - 1.0), whole() * (high->first + 2.0));
        const int turns_less = reversals(as_they_are) - reversals(as_stations);
        if (is_short && are_whole && lie_between(low->first - beside, high->first + beside) &&
            (are_units ? turns_less > 0 : turns_less >= 0)) {
            return Meaning::stations;
        }
        return are_units ? Meaning::plain : Meaning::doubtful;
    }
    if (is_in_feet()) {
        return Meaning::plain;
    }
    // Places a kilometre apart of which none lies 20 m or more behind a full one.
    std::set<double> before;
    std::set<double> after;
    for (const auto& [number, metres] : sums_) {
        before.insert(number);
        after.insert(metres);
    }
    return is_short && before.size() >= 3 && after.size() >= 2 ? Meaning::doubtful : Meaning::plain;
}

std::optional<double> Places::metres(std::string_view cell) const {
    cell = trimmed(cell);
    const bool in_feet = is_in_feet();
    if (meaning_ == Meaning::stations) {
        if (const auto number = measured(cell)) {
            return step() * *number;
        }
        if (const auto both = in_feet ? std::nullopt : sum(cell)) {
            return step() * both->first + both->second;
        }
    }
    return chainage(cell, in_feet || is_sum_in_feet_by_neighbours(cell) ? foot_m : to_m_.value_or(1.0));
}

bool Places::is_sum_in_feet_by_neighbours(std::string_view cell) const {
    return !to_m_ && is_american_ && cell.find('+') != std::string_view::npos;
}

} // namespace explore::data

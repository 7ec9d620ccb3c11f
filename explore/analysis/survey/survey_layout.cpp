#include "analysis/survey/survey_layout.h"

#include "analysis/survey/survey_sensors.h"
#include "analysis/survey/survey_trials.h"
#include "base/error.h"
#include "data/median.h"
#include "data/usual_layouts.h"
#include "study/laws.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace explore::analysis {
namespace {

// Of the squared misfit: where bowls are far off, and where they are not, but a sensor or the section is suspect.
constexpr double worth_naming = 0.5;
constexpr double worth_naming_of_near = 0.15;

using Offsets = std::vector<double>; // mm

// The bowl as if its sensors stood there, fitted from the answer and from the middle of the box: the answer may lie on
// bounds that the file's layout drove it to.
std::optional<Trial> fitted_as(const SurveyResult& result, const StationResult& s, const Offsets& offsets) {
    data::DeflectionBowl bowl = bowl_to_try(s);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        bowl.readings[i].offset_mm = offsets[i];
    }
    const std::vector<double>& best = s.fit->best.unit;
    return try_fit(result, *result.study, s, bowl, {best, std::vector<double>(best.size(), 0.5)});
}

} // namespace

std::optional<BetterLayout> better_layout(const SurveyResult& result) {
    if (!result.study || !study::stress_dependent_layers(*result.study).empty()) {
        return std::nullopt;
    }
    constexpr std::size_t most_stations = 9;
    const auto stations = stations_to_try(result, most_stations);
    std::vector<double> rms;
    for (const StationResult* s : stations) {
        rms.push_back(s->fit->rms_percent);
    }
    // One sensor that explains all needs no other layout; of few sensors nothing tells whether it does.
    const bool is_suspicious =
        result.section_is_suspect || (result.suspect && !left_over_without(result, result.suspect->offset_mm));
    if (stations.size() < least_stations || !(data::median(rms) > tried_percent || is_suspicious)) {
        return std::nullopt;
    }
    Offsets own;
    for (const data::BowlReading& r : bowl_to_try(*stations[0]).readings) {
        own.push_back(r.offset_mm);
    }
    try {
        std::vector<std::optional<Trial>> as_it_is;
        for (const StationResult* s : stations) {
            as_it_is.push_back(fitted_as(result, *s, own));
        }
        std::optional<BetterLayout> best;
        double least = data::median(rms) > tried_percent ? worth_naming : worth_naming_of_near;
        for (const Offsets& offsets : data::usual_layouts()) {
            if (offsets.size() != own.size() || offsets == own) {
                continue;
            }
            const auto moved =
                std::inner_product(own.begin(), own.end(), offsets.begin(), 0, std::plus<>(), std::not_equal_to<>());
            if (moved == 1 && result.suspect) { // that one is named
                continue;
            }
            std::vector<double> ratio;
            std::vector<double> before;
            std::vector<double> after;
            for (std::size_t i = 0; i < stations.size(); ++i) {
                const auto there = as_it_is[i] ? fitted_as(result, *stations[i], offsets) : std::nullopt;
                if (there) {
                    ratio.push_back(std::pow(there->misfit / as_it_is[i]->misfit, 2));
                    before.push_back(as_it_is[i]->rms_percent);
                    after.push_back(there->rms_percent);
                }
            }
            if (ratio.size() >= least_stations && data::median(ratio) < least) {
                least = data::median(ratio);
                best = BetterLayout{.offsets_mm = offsets,
                                    .stations = ratio.size(),
                                    .rms_percent = data::median(after),
                                    .rms_percent_of_file = data::median(before),
                                    .misfit_ratio = least};
            }
        }
        // Another section that misses half as much of what is left is the answer.
        const bool is_section =
            best && !result.trials.empty() && result.trials[0].misfit_ratio < 0.5 * best->misfit_ratio;
        return is_section ? std::nullopt : best;
    } catch (const pave::Error&) { // a sensor that the study has no room for
        return std::nullopt;
    }
}

} // namespace explore::analysis

#include "analysis/survey_layout.h"

#include "analysis/survey_stations.h"
#include "base/error.h"
#include "data/median.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"
#include "study/laws.h"
#include "study/problems.h"

#include <algorithm>
#include <cmath>

namespace explore::analysis {
namespace {

constexpr double tried_percent = 5.0;
constexpr double worth_saying = 0.5; // of the squared misfit
constexpr std::size_t least_stations = 3;
constexpr std::size_t most_stations = 9;

// mm. Deflectometers of Dynatest, Grontmij and KUAB as roads are tested with them; inches are those of American ones.
using Offsets = std::vector<double>;
const std::vector<Offsets>& usual_layouts() {
    static const std::vector<Offsets> all = {
        {0, 300, 600, 900, 1200},
        {0, 200, 450, 600, 900},
        {0, 300, 600, 900, 1200, 1500},
        {0, 200, 300, 600, 900, 1200},
        {0, 200, 300, 450, 600, 900},
        {0, 200, 300, 600, 900, 1200, 1500},
        {0, 200, 300, 450, 600, 900, 1200},
        {0, 200, 300, 450, 600, 900, 1500},
        {0, 200, 300, 450, 650, 900, 1200},
        {0, 300, 450, 600, 900, 1200, 1500},
        {0, 300, 600, 900, 1200, 1500, 1800},
        {0, 300, 600, 900, 1200, 1500, 2100},
        {0, 210, 315, 475, 630, 925, 1535},
        {0, 203.2, 304.8, 457.2, 609.6, 914.4, 1524},
        {0, 304.8, 609.6, 914.4, 1219.2, 1524, 1828.8},
        {0, 200, 300, 450, 600, 900, 1200, 1500},
        {0, 200, 300, 450, 600, 900, 1200, 1800},
        {0, 300, 450, 600, 900, 1200, 1500, 1800},
        {0, 200, 300, 450, 600, 900, 1200, 1500, 1800},
        {0, 200, 300, 450, 600, 900, 1200, 1500, 2100},
        {0, 300, 450, 600, 900, 1200, 1500, 1800, 2100},
        {0, 203.2, 304.8, 457.2, 609.6, 914.4, 1219.2, 1524, 1828.8},
    };
    return all;
}

Offsets offsets_of(const data::DeflectionBowl& bowl) {
    Offsets offsets;
    for (const data::BowlReading& r : bowl.readings) {
        offsets.push_back(r.offset_mm);
    }
    return offsets;
}

struct Trial {
    double misfit = INFINITY;
    double rms_percent = INFINITY;
};

// The bowl as if its sensors stood there, fitted from a point.
std::optional<Trial> fitted_as(const SurveyResult& result, const StationResult& s, const Offsets& offsets) {
    data::DeflectionBowl bowl = s.bowls->levels[s.fit->levels.back()];
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        bowl.readings[i].offset_mm = offsets[i];
    }
    const study::Study study = study::station_study(*result.study, s.station, {&bowl}, result.repeatability);
    const problem::Problem problem = study::make_noise_problem(study, study::Scope::fitted);
    const auto workspace = problem.function->make_workspace();
    optimise::SearchSettings settings;
    settings.max_evaluations = 25;
    Trial best;
    const optimise::Objective objective = [&](std::span<const double> point, optimise::Sample& sample) {
        const auto e = problem.evaluate(point, true, *workspace);
        if (!e.converged()) {
            return optimise::Answer::no_answer;
        }
        sample = run::sample_of(problem, e);
        if (e.misfit < best.misfit) {
            double squares = 0.0;
            for (std::size_t i = 0; i < problem.readings(); ++i) {
                squares += std::pow(e.responses[problem.response_of(i)] / problem.measured(i) - 1.0, 2);
            }
            best = {e.misfit, 100.0 * std::sqrt(squares / static_cast<double>(problem.readings()))};
        }
        return optimise::Answer::computed;
    };
    // The answer there may lie on bounds that the file's layout drove it to.
    for (const std::vector<double>& start : {s.fit->best.unit, std::vector<double>(s.fit->best.unit.size(), 0.5)}) {
        optimise::gauss_newton(start, objective, settings);
    }
    return std::isfinite(best.misfit) ? std::optional(best) : std::nullopt;
}

// Stations to try at: with a fit, of the layout that most have, over all D0.
std::vector<const StationResult*> stations_to_try(const SurveyResult& result) {
    std::vector<const StationResult*> all;
    for (const StationResult& s : result.stations) {
        if (s.fit) {
            all.push_back(&s);
        }
    }
    if (all.empty()) {
        return {};
    }
    const Offsets own = offsets_of(all[all.size() / 2]->bowls->bowl());
    std::erase_if(all,
                  [&](const StationResult* s) { return offsets_of(s->bowls->levels[s->fit->levels.back()]) != own; });
    std::stable_sort(all.begin(), all.end(), [&](const StationResult* a, const StationResult* b) {
        return result.d0_at_common(*a) < result.d0_at_common(*b);
    });
    std::vector<const StationResult*> some;
    const std::size_t count = std::min(most_stations, all.size());
    for (std::size_t i = 0; i < count; ++i) {
        some.push_back(all[(2 * i + 1) * all.size() / (2 * count)]);
    }
    return some;
}

} // namespace

std::optional<BetterLayout> better_layout(const SurveyResult& result) {
    if (!result.study || !study::stress_dependent_layers(*result.study).empty()) {
        return std::nullopt;
    }
    const auto stations = stations_to_try(result);
    std::vector<double> rms;
    for (const StationResult* s : stations) {
        rms.push_back(s->fit->rms_percent);
    }
    if (stations.size() < least_stations || !(data::median(rms) > tried_percent)) {
        return std::nullopt;
    }
    const Offsets own = offsets_of(stations[0]->bowls->levels[stations[0]->fit->levels.back()]);
    try {
        std::vector<std::optional<Trial>> as_it_is;
        for (const StationResult* s : stations) {
            as_it_is.push_back(fitted_as(result, *s, own));
        }
        std::optional<BetterLayout> best;
        double least = worth_saying;
        for (const Offsets& offsets : usual_layouts()) {
            if (offsets.size() != own.size() || offsets == own) {
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
        return best;
    } catch (const pave::Error&) { // a sensor that the study has no room for
        return std::nullopt;
    }
}

} // namespace explore::analysis

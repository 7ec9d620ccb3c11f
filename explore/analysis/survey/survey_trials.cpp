#include "analysis/survey/survey_trials.h"

#include "base/error.h"
#include "base/text.h"
#include "data/median.h"
#include "optimise/gauss_newton.h"
#include "run/least_squares.h"
#include "study/laws.h"
#include "study/problems.h"
#include "study/readings.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

constexpr double worth_saying = 0.7;              // of the squared misfit
constexpr double parted_at_m[] = {0.5, 1.0, 2.0}; // below the top of the last layer
constexpr double floor_at_m = 3.0;                // the same

std::vector<double> offsets_of(const data::DeflectionBowl& bowl) {
    std::vector<double> offsets;
    for (const data::BowlReading& r : bowl.readings) {
        offsets.push_back(r.offset_mm);
    }
    return offsets;
}

// Another section, and a start in it where the study has one.
struct Section {
    std::string words;
    study::Study study;
    std::optional<std::size_t> repeated{}; // axis whose value a further, last axis starts from: of a parted layer
};

// The last layer in two, each with a modulus of its own; nothing: its modulus is not fitted, or it is too thin.
std::optional<Section> parted(study::Study study, double depth_m) {
    auto& layers = study.model.layers;
    const std::string path = layers.back().name + ".modulus_MPa";
    auto& axes = study.space.axes;
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const auto& a) { return a.name == path; });
    if (axis == axes.end() || (!study.model.half_space && layers.back().thickness < 2.0 * depth_m)) {
        return std::nullopt;
    }
    const auto at = static_cast<std::size_t>(axis - axes.begin());
    auto upper = layers.back();
    upper.name = "upper " + upper.name;
    upper.thickness = depth_m;
    layers.back().thickness -= study.model.half_space ? 0.0 : depth_m;
    auto further = *axis;
    further.name = "upper " + path;
    const std::string words =
        fmt::format("a further layer, {} parted {:g} m below its top", layers.back().name, depth_m);
    layers.insert(layers.end() - 1, upper);
    axes.push_back(further);
    for (auto& parameter : study.parameters) {
        parameter = pave::pavement::find_parameter(study.model, parameter.path, {});
    }
    study.parameters.push_back(pave::pavement::find_parameter(study.model, further.name, {}));
    return Section{words, std::move(study), at};
}

std::vector<Section> sections_to_try(const study::Study& study) {
    std::vector<Section> sections;
    const auto is_sought = [&](const std::string& path) {
        return std::any_of(study.parameters.begin(), study.parameters.end(),
                           [&](const auto& p) { return p.path == path; });
    };
    for (const double depth_m : parted_at_m) {
        if (auto section = parted(study, depth_m)) {
            sections.push_back(std::move(*section));
        }
    }
    const std::string& last = study.model.layers.back().name;
    if (is_sought(last + ".thickness_mm")) {
        return sections;
    }
    Section other{study.model.half_space ? fmt::format("a floor {:g} m below the top of {}", floor_at_m, last)
                                         : "a half-space in place of the floor",
                  study};
    other.study.model.half_space = !study.model.half_space;
    if (study.model.half_space) {
        other.study.model.layers.back().thickness = floor_at_m;
    }
    other.study.model.settings.layered = true;
    sections.push_back(std::move(other));
    for (Section& section : sections) {
        study::settle_extent(section.study);
    }
    return sections;
}

bool can_try(const study::Study& study) {
    const auto& model = study.model;
    return !study.has_own_model && study::stress_dependent_layers(study).empty() && study.constraints.empty() &&
           model.effects.empty() && model.ties.empty() && model.corrections.empty();
}

} // namespace

const data::DeflectionBowl& bowl_to_try(const StationResult& station) {
    return station.bowls->levels[station.fit->levels.back()];
}

std::vector<const StationResult*> stations_to_try(const SurveyResult& result, std::size_t most) {
    std::vector<const StationResult*> all;
    for (const StationResult& s : result.stations) {
        if (s.fit) {
            all.push_back(&s);
        }
    }
    if (all.empty()) {
        return {};
    }
    const auto own = offsets_of(all[all.size() / 2]->bowls->bowl());
    std::erase_if(all, [&](const StationResult* s) { return offsets_of(bowl_to_try(*s)) != own; });
    std::stable_sort(all.begin(), all.end(), [&](const StationResult* a, const StationResult* b) {
        return result.d0_at_common(*a) < result.d0_at_common(*b);
    });
    std::vector<const StationResult*> some;
    const std::size_t count = std::min(most, all.size());
    for (std::size_t i = 0; i < count; ++i) {
        some.push_back(all[(2 * i + 1) * all.size() / (2 * count)]);
    }
    return some;
}

std::optional<Trial> try_fit(const SurveyResult& result, const study::Study& study, const StationResult& station,
                             const data::DeflectionBowl& bowl, const std::vector<std::vector<double>>& starts) {
    const study::Study own = study::station_study(study, station.station, {&bowl}, result.repeatability);
    const problem::Problem problem = study::make_noise_problem(own, study::Scope::fitted);
    const auto workspace = problem.function->make_workspace();
    optimise::SearchSettings settings;
    settings.max_evaluations = 25;
    Trial best{.misfit = INFINITY, .rms_percent = INFINITY};
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
    for (const std::vector<double>& start : starts) {
        optimise::gauss_newton(start, objective, settings);
    }
    return std::isfinite(best.misfit) ? std::optional(best) : std::nullopt;
}

std::vector<SectionTrial> section_trials(const SurveyResult& result) {
    if (!result.study || !can_try(*result.study)) {
        return {};
    }
    constexpr std::size_t most_stations = 15;
    const auto stations = stations_to_try(result, most_stations);
    std::vector<double> rms;
    for (const StationResult* s : stations) {
        rms.push_back(s->fit->rms_percent);
    }
    if (stations.size() < least_stations || !(result.section_is_suspect || data::median(rms) > tried_percent)) {
        return {};
    }
    std::vector<SectionTrial> trials;
    std::optional<SectionTrial> best_parted;
    try {
        std::vector<std::optional<Trial>> as_it_is;
        for (const StationResult* s : stations) {
            as_it_is.push_back(try_fit(result, *result.study, *s, bowl_to_try(*s), {s->fit->best.unit}));
        }
        for (const Section& section : sections_to_try(*result.study)) {
            double log_ratios = 0.0;
            std::vector<double> before;
            std::vector<double> after;
            for (std::size_t i = 0; i < stations.size(); ++i) {
                // Parted in two alike a section fits as well as before; with a floor it may be far from that.
                std::vector<std::vector<double>> starts{stations[i]->fit->best.unit};
                if (section.repeated) {
                    starts[0].push_back(starts[0][*section.repeated]);
                } else {
                    starts.emplace_back(starts[0].size(), 0.5);
                }
                const auto there = as_it_is[i]
                                       ? try_fit(result, section.study, *stations[i], bowl_to_try(*stations[i]), starts)
                                       : std::nullopt;
                if (there) {
                    log_ratios += 2.0 * std::log(there->misfit / as_it_is[i]->misfit);
                    before.push_back(as_it_is[i]->rms_percent);
                    after.push_back(there->rms_percent);
                }
            }
            if (after.size() < least_stations) {
                continue;
            }
            SectionTrial trial{.words = section.words,
                               .stations = after.size(),
                               .rms_percent = data::median(after),
                               .rms_percent_of_study = data::median(before),
                               .misfit_ratio = std::exp(log_ratios / static_cast<double>(after.size()))};
            if (!section.repeated) {
                trials.push_back(std::move(trial));
            } else if (!best_parted || trial.misfit_ratio < best_parted->misfit_ratio) {
                best_parted = std::move(trial);
            }
        }
        if (best_parted) {
            trials.push_back(std::move(*best_parted));
        }
    } catch (const pave::Error&) { // a section of this kind cannot be made of the study
        return {};
    }
    std::stable_sort(trials.begin(), trials.end(),
                     [](const SectionTrial& a, const SectionTrial& b) { return a.misfit_ratio < b.misfit_ratio; });
    return trials;
}

std::string suspected_instead(const SurveyResult& result) {
    constexpr double settled_percent = 1.0; // RMS: what is left is of the size of the sensors' errors
    if (result.layout) {
        return "the places of the sensors, or the section";
    }
    if (!result.trials.empty() && result.trials[0].misfit_ratio > clearly_better) {
        return "the section (a thickness, or another than those tried below), or several sensors";
    }
    return !result.trials.empty() && result.trials[0].rms_percent < settled_percent
               ? "the section is wrong (another layer, a half-space or a floor, a thickness) before a sensor is"
               : "the section (another layer, a half-space or a floor, a thickness), or several sensors";
}

std::string trial_words(const SurveyResult& result) {
    std::vector<std::string> helps;
    std::vector<std::string> some;
    std::vector<std::string> little;
    std::vector<std::string> worse;
    constexpr double clearly_worse = 1.1;
    for (const SectionTrial& t : result.trials) {
        const bool is_nearer = t.rms_percent < t.rms_percent_of_study;
        if (t.misfit_ratio < worth_saying && is_nearer) {
            helps.push_back(fmt::format("{}: {:.1f} % instead of {:.1f} % (squared misfit {:.2g} times)", t.words,
                                        t.rms_percent, t.rms_percent_of_study, t.misfit_ratio));
        } else {
            auto& list = t.misfit_ratio < clearly_better ? some : t.misfit_ratio < clearly_worse ? little : worse;
            list.push_back(fmt::format("{} (squared misfit {:.2g} times)", t.words, t.misfit_ratio));
        }
    }
    if (result.trials.empty()) {
        return "";
    }
    const std::size_t stations = result.trials[0].stations;
    std::vector<std::string> parts;
    if (!helps.empty()) {
        parts.push_back("another section misses the bowls by less (median RMS): " + pave::join(helps, "; "));
    }
    const std::pair<const char*, const std::vector<std::string>&> tiers[] = {
        {"this helps a little: ", some}, {"this changes next to nothing: ", little}, {"this fits worse: ", worse}};
    for (const auto& [words, list] : tiers) {
        if (!list.empty()) {
            parts.push_back(words + pave::join(list, "; "));
        }
    }
    const std::string text = fmt::format("Tried at {} stations, {}.", stations, pave::join(parts, "; and "));
    return text;
}

} // namespace explore::analysis

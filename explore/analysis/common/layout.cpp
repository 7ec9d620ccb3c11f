#include "analysis/common/layout.h"

#include "base/text.h"
#include "pavement/forward.h"
#include "study/problems.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

Layout layout_of(const study::Study& study) {
    Layout layout;
    std::vector<diagnose::Fold> places;
    for (const auto& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        diagnose::ReadingGroup own{.name = group.name, .terms = {}};
        for (const std::size_t row : group.rows) {
            const std::size_t term = layout.rows.size();
            layout.rows.push_back(row);
            const data::Reading& m = study.readings[row];
            if (m.censored == data::Censored::no) { // what a limit leaves is no draw of the noise
                own.terms.push_back(term);
            }
            const auto add = [&](std::vector<diagnose::Fold>& folds, const std::string& name) {
                auto fold = std::find_if(folds.begin(), folds.end(), [&](const auto& f) { return f.name == name; });
                if (fold == folds.end()) {
                    fold = folds.insert(folds.end(), {.name = name, .terms = {}});
                }
                fold->terms.push_back(term);
            };
            add(places, m.place_words());
            add(layout.loads, m.load);
        }
        std::stable_sort(own.terms.begin(), own.terms.end(), [&](std::size_t a, std::size_t b) {
            const data::Reading& first = study.readings[layout.rows[a]];
            const data::Reading& second = study.readings[layout.rows[b]];
            return std::tie(first.x_mm, first.y_mm, first.depth_mm) <
                   std::tie(second.x_mm, second.y_mm, second.depth_mm);
        });
        layout.groups.push_back(std::move(own));
    }
    constexpr std::size_t most = 10; // folds
    for (std::size_t p = 0; p < places.size(); ++p) {
        if (p < most) {
            layout.places.push_back(places[p]);
        } else {
            auto& fold = layout.places[p % most];
            fold.name += " and " + places[p].name;
            fold.terms.insert(fold.terms.end(), places[p].terms.begin(), places[p].terms.end());
        }
    }
    return layout;
}

std::string weights_words(const study::Study& study) {
    const bool weighed = std::any_of(study.groups.begin(), study.groups.end(),
                                     [](const auto& group) { return !group.held_out && group.weight != 1.0; });
    return weighed && study.noise == study::NoiseSource::stated
               ? "The weights of the groups shape the fit alone: every statement of probability takes the noise as the "
                 "readings state it."
               : "";
}

std::string noise_key_words(const study::Study& study) {
    const auto measured = study.measured();
    const auto own = static_cast<std::size_t>(
        std::count_if(measured.begin(), measured.end(), [](const data::Reading& m) { return m.sigma.has_value(); }));
    const study::DataSettings& data = study.data;
    if (own == 0 || !data.states_noise()) {
        return "";
    }
    std::vector<std::string> idle;
    if (data.noise_relative) {
        idle.emplace_back("the relative part");
    }
    if (data.noise_floor) {
        idle.emplace_back("noise_floor");
    }
    if (data.noise_absolute != std::array<double, 4>{}) {
        idle.emplace_back("absolute");
    }
    std::vector<std::string> acting;
    if (data.noise_common_relative > 0.0) {
        acting.emplace_back("common_relative");
    }
    if (data.noise_correlation_length > 0.0) {
        acting.emplace_back("correlation_mm");
    }
    if (data.noise_correlation_time > 0.0) {
        acting.emplace_back("correlation_ms");
    }
    if (data.noise_drift > 0.0) {
        acting.emplace_back("drift_um_per_ms");
    }
    if (data.noise_degrees > 0.0) {
        acting.emplace_back("loss");
    }
    return fmt::format(
        "{} a sigma of {} own: of the noise that the study states, {} no effect on {}{}.",
        own == measured.size() ? "Every reading states" : fmt::format("{} of {} readings state", own, measured.size()),
        own == measured.size() || own == 1 ? "its" : "their",
        pave::join(idle, " and ") + (idle.size() == 1 ? " has" : " have"),
        own == measured.size() || own == 1 ? "it" : "them",
        acting.empty()
            ? ""
            : fmt::format("; {} {} on all", pave::join(acting, " and "), acting.size() == 1 ? "has" : "have"));
}

std::string misfit_words(const study::Study& study) {
    if (study.noise != study::NoiseSource::stated || study.data.misfit == problem::MisfitKind::weighted) {
        return "";
    }
    return fmt::format(
        "fit minimises the {} misfit that the study asks for, unique chi2 by the stated noise: their best "
        "sets may differ, and with them chi2, its degrees of freedom (a parameter on a bound costs none) "
        "and the number of minima. With misfit = \"weighted\" they are the same.",
        to_string(study.data.misfit));
}

std::optional<double> held_out_rms(const study::Study& study, const std::vector<double>& responses) {
    double squares = 0.0;
    std::size_t count = 0;
    for (const auto& group : study.groups) {
        if (!group.held_out || study.noise == study::NoiseSource::estimated) {
            continue;
        }
        for (const std::size_t i : group.rows) {
            const data::Reading& m = study.readings[i];
            squares += std::pow(m.noise.residual(responses[i], m.measured()), 2);
            ++count;
        }
    }
    return count > 0 ? std::optional(std::sqrt(squares / static_cast<double>(count))) : std::nullopt;
}

bool outputs_cost_more(const study::Study& study) {
    if (study.has_own_model || study.outputs().empty()) {
        return false;
    }
    const std::vector<int> unknowns = pave::pavement::ForwardModel(study.model).unknowns();
    const std::vector<bool> computed = study::computed_loads(study);
    int most = 0;
    int most_computed = 1;
    for (std::size_t load = 0; load < unknowns.size(); ++load) {
        (computed[load] ? most_computed : most) = std::max(computed[load] ? most_computed : most, unknowns[load]);
    }
    constexpr int far_more = 4;
    return most > far_more * most_computed;
}

landscape::UniquenessTask uniqueness_task(const study::Study& study, const problem::Problem& fitted,
                                          const problem::Problem& everything, run::Engine& fitted_engine,
                                          run::Engine& everything_engine, std::uint64_t seed) {
    landscape::UniquenessTask task{.fitted = fitted,
                                   .everything = everything,
                                   .fitted_engine = fitted_engine,
                                   .everything_engine = everything_engine,
                                   .outputs = study.outputs(),
                                   .groups = {},
                                   .seed = seed,
                                   .explorer = nullptr,
                                   .outputs_cost_more = outputs_cost_more(study)};
    std::size_t term = 0;
    for (const auto& group : study.groups) {
        if (!group.held_out) {
            task.groups.emplace_back();
            for (std::size_t i = 0; i < group.rows.size(); ++i) {
                task.groups.back().push_back(term++);
            }
        }
    }
    return task;
}

} // namespace explore::analysis

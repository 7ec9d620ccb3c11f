#include "analysis/layout.h"

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
            own.terms.push_back(term);
            const data::Reading& m = study.readings[row];
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

std::string misfit_words(const study::Study& study) {
    if (study.noise != study::NoiseSource::stated || study.data.misfit == problem::MisfitKind::weighted) {
        return "";
    }
    return fmt::format("fit minimises the {} misfit that the study asks for, unique chi2 by the stated noise: their best "
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

landscape::UniquenessTask uniqueness_task(const study::Study& study, const problem::Problem& fitted,
                                          const problem::Problem& everything, run::Engine& fitted_engine,
                                          run::Engine& everything_engine, std::uint64_t seed) {
    landscape::UniquenessTask task{.fitted = fitted,
                                   .everything = everything,
                                   .fitted_engine = fitted_engine,
                                   .everything_engine = everything_engine,
                                   .outputs = study.outputs(),
                                   .groups = {},
                                   .seed = seed};
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

#include "cli/groups.h"

#include "report/table.h"

#include <cmath>
#include <fmt/format.h>

namespace explore::cli {

using report::figure;

Predictor::Predictor(const study::Study& study) : problem_(study::make_problem(study)) {}

void Predictor::complete(problem::Evaluation& evaluation) const {
    const bool complete = std::none_of(evaluation.responses.begin(), evaluation.responses.end(),
                                       [](double value) { return std::isnan(value); });
    if (complete) {
        return;
    }
    const auto workspace = problem_.function->make_workspace();
    auto outcome = problem_.function->evaluate(evaluation.parameters, false, *workspace);
    if (outcome) {
        evaluation.responses = outcome->responses;
        evaluation.warnings = outcome->warnings;
    } else {
        evaluation.warnings.push_back("not all loads have an answer here: " + outcome.failure().reason);
    }
}

std::vector<double> group_rms(const study::Study& study, const problem::Evaluation& evaluation) {
    std::vector<double> rms;
    for (const auto& group : study.groups) {
        const auto residuals = study::misfit_of(study, group.rows).residuals(evaluation.responses);
        rms.push_back(residuals.norm() / std::sqrt(static_cast<double>(residuals.size())));
    }
    return rms;
}

std::optional<std::vector<GroupFit>> fit_alone(const study::Study& study, const Predictor& predictor,
                                               const search::Design& design, const landscape::MultistartResult& joint,
                                               run::Store& store, const std::string& settings_words,
                                               landscape::MultistartSettings settings, int threads) {
    std::vector<GroupFit> fits;
    const auto fitted = std::count_if(study.groups.begin(), study.groups.end(),
                                      [](const study::Group& group) { return !group.held_out; });
    if (fitted < 2) {
        return fits;
    }
    // The joint answer is one of the starts, and the points were explored for the joint fit: a third is enough.
    settings.starts = std::max(2, settings.starts / 3);
    for (const auto& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        const problem::Problem own = study::make_problem(study, group);
        std::vector<problem::Evaluation> explored = joint.explored;
        for (auto& evaluation : explored) {
            if (evaluation.converged()) {
                evaluation.misfit = own.misfit.residuals(evaluation.responses).norm();
            }
        }
        const int id = store.begin(run_header(study, "fit", settings_words + "; " + group.name + " alone"));
        run::Engine engine(own, &store, id, {.threads = threads, .show_progress = true});
        auto result = landscape::refine(engine, own, design, std::move(explored), {joint.minima[0].unit}, settings);
        if (!result) {
            return std::nullopt;
        }
        const report::Json minimum = report::minimum_json(own, result->minima[0]);
        auto& best = result->minima[0].evaluation;
        predictor.complete(best);
        fits.push_back({group.name, best, minimum, group_rms(study, best)});
    }
    return fits;
}

std::string group_text(const study::Study& study, const GroupFit& joint, const std::vector<GroupFit>& alone) {
    std::string text =
        "\nGroups of readings: root mean square residual of each, at the best fit of all and of each alone\n";
    std::vector<std::string> header{"group", "readings", "weight", "all"};
    for (const GroupFit& fit : alone) {
        header.push_back(fit.fitted + " alone");
    }
    report::Table table(header);
    for (std::size_t g = 0; g < study.groups.size(); ++g) {
        const auto& group = study.groups[g];
        std::vector<std::string> row{group.name, fmt::format("{}", group.rows.size()),
                                     group.held_out ? "held out" : figure(group.weight), figure(joint.rms[g])};
        for (const GroupFit& fit : alone) {
            row.push_back(figure(fit.rms[g]) + (fit.fitted == group.name ? " (fitted)" : ""));
        }
        table.add(std::move(row));
    }
    text += table.text();
    if (!alone.empty()) {
        report::Table parameters([&] {
            std::vector<std::string> names{"fitted"};
            for (const auto& axis : study.space.axes) {
                names.push_back(axis.name);
            }
            return names;
        }());
        const auto add = [&](const GroupFit& fit) {
            std::vector<std::string> row{fit.fitted};
            for (const double value : fit.best.parameters) {
                row.push_back(figure(value));
            }
            parameters.add(std::move(row));
        };
        add(joint);
        for (const GroupFit& fit : alone) {
            add(fit);
        }
        text += parameters.text();
    }
    return text;
}

report::Json group_json(const study::Study& study, const GroupFit& joint, const std::vector<GroupFit>& alone) {
    const auto fit_json = [&](const GroupFit& fit) {
        report::Json rms = report::Json::object();
        for (std::size_t g = 0; g < study.groups.size(); ++g) {
            rms[study.groups[g].name] = fit.rms[g];
        }
        report::Json json = {{"fitted", fit.fitted}};
        json.update(fit.minimum);
        json["rms"] = std::move(rms);
        return json;
    };
    report::Json groups = report::Json::array();
    for (std::size_t g = 0; g < study.groups.size(); ++g) {
        groups.push_back({{"name", study.groups[g].name},
                          {"readings", study.groups[g].rows.size()},
                          {"weight", study.groups[g].weight},
                          {"held_out", study.groups[g].held_out},
                          {"rms", joint.rms[g]}});
    }
    report::Json fits = report::Json::array();
    for (const GroupFit& fit : alone) {
        fits.push_back(fit_json(fit));
    }
    return {{"groups", std::move(groups)}, {"alone", std::move(fits)}};
}

} // namespace explore::cli

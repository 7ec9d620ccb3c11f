// pavescape compare: the same data, each law in the same layer, each fitted by the same search.
#include "cli/common.h"
#include "cli/groups.h"
#include "cli/layout.h"
#include "material/catalog.h"
#include "report/table.h"
#include "run/interrupt.h"
#include "run/message.h"
#include "run/progress.h"
#include "study/laws.h"

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

namespace explore::cli {
namespace {

using landscape::Uniqueness;
using pave::material::Law;
using report::counted;
using report::figure;
using report::Json;

struct CompareOptions {
    CommonOptions common;
    std::string layer;
    std::vector<std::string> laws;
    landscape::UniquenessSettings analysis;
};

// One law and what the data say of it.
struct Fitted {
    const Law* law = nullptr;
    study::Study study;
    std::string failed; // why there is nothing more
    Uniqueness answer;
    problem::Evaluation best; // of every response
    double chi2 = 0.0;        // sum of squared residuals, in units of the noise where it is stated
    int dof = 0;
    std::optional<double> p_value;
    double aicc = 0.0;
    double weight = 0.0;               // Akaike's, among the laws
    std::optional<double> by_place;    // rms of readings left out place by place
    std::optional<double> study_holds; // rms of what the study holds out
    std::vector<double> group_rms;
};

std::size_t layer_of(const study::Study& study, const std::string& name) {
    std::vector<std::string> names;
    for (const auto& layer : study.model.layers) {
        names.push_back(layer.name);
    }
    if (!name.empty()) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            throw pave::Error({.key = "--layer"}, "the study has no such layer", "\"" + name + "\"", pave::join(names));
        }
        return static_cast<std::size_t>(found - names.begin());
    }
    const auto layers = study::stress_dependent_layers(study);
    if (layers.size() != 1) {
        throw pave::Error(
            {.file = study.file, .key = "--layer"}, "which layer's law is in question?",
            counted(layers.size(), "layer whose law depends on stress", "layers whose law depends on stress"),
            pave::join(names));
    }
    return layers[0];
}

std::vector<const Law*> laws_of(const CompareOptions& options) {
    std::vector<std::string> names;
    for (const Law* law : pave::material::laws()) {
        names.emplace_back(law->name());
    }
    std::vector<const Law*> laws;
    for (const std::string& name : options.laws.empty() ? names : options.laws) {
        const Law* law = pave::material::find_law(name);
        if (law == nullptr) {
            const std::string near = pave::nearest_name(name, names);
            throw pave::Error({.key = "--laws"},
                              "unknown law" + (near.empty() ? "" : ", did you mean \"" + near + "\"?"),
                              "\"" + name + "\"", pave::join(names));
        }
        if (std::find(laws.begin(), laws.end(), law) == laws.end()) {
            laws.push_back(law);
        }
    }
    return laws;
}

// The readings of every place predicted by a fit without them, from the best of what was explored and from the best
// minimum. Nothing: interrupted, or no fold has an answer.
std::optional<double> left_out_rms(const problem::Problem& problem, run::Engine& engine, const Layout& layout,
                                   const Uniqueness& answer) {
    std::vector<double> squares(layout.places.size(), 0.0);
    std::vector<std::size_t> counts(layout.places.size(), 0);
    const bool done = engine.chains(
        "places left out", landscape::first_start_of_others, layout.places.size(),
        [&](std::size_t f, run::Chain& chain) {
            const auto& fold = layout.places[f];
            const diagnose::Target target = diagnose::leaving_out(fold.terms, problem.misfit.size());
            const problem::Evaluation* nearest = &answer.minima[0].evaluation;
            double lowest = std::numeric_limits<double>::infinity();
            for (const auto& e : answer.explored) {
                if (const double sum =
                        e.converged() ? diagnose::counted_sum(problem.misfit.residuals(e.responses), target) : lowest;
                    sum < lowest) {
                    lowest = sum;
                    nearest = &e;
                }
            }
            std::optional<diagnose::Model> best;
            for (const auto& start : {problem.space.unit(nearest->parameters), answer.minima[0].unit}) {
                auto model = diagnose::fit(chain, problem, {}, start, target, 0.0);
                if (model && (!best || model->sum < best->sum)) {
                    best = std::move(model);
                }
            }
            if (best) {
                for (const std::size_t i : fold.terms) {
                    squares[f] += std::pow(best->residuals[static_cast<Eigen::Index>(i)], 2);
                    ++counts[f];
                }
            }
        });
    std::size_t count = 0;
    double sum = 0.0;
    for (std::size_t f = 0; f < squares.size(); ++f) {
        count += counts[f];
        sum += squares[f];
    }
    return done && count > 0 ? std::optional(std::sqrt(sum / static_cast<double>(count))) : std::nullopt;
}

// False: interrupted.
bool fit_law(Fitted& f, const CompareOptions& options, run::Store& store, const std::string& settings) {
    const study::Study& study = f.study;
    const problem::Problem fitted = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem everything = study::make_noise_problem(study, study::Scope::everything);
    const run::EngineSettings engine_settings{.threads = options.common.threads, .show_progress = true};
    run::Engine everything_engine(everything, &store, store.begin(run_header(study, "compare-outputs", settings)),
                                  engine_settings);
    run::Engine engine(fitted, &store, store.begin(run_header(study, "compare", settings)), engine_settings);
    auto answer = landscape::uniqueness(
        uniqueness_task(study, fitted, everything, engine, everything_engine, options.common.seed), options.analysis);
    if (!answer) {
        return false;
    }
    f.answer = std::move(*answer);
    if (f.answer.minima.empty()) {
        f.failed = "not one explored point has an answer" +
                   (f.answer.explored.empty() ? "" : "; the first says: " + f.answer.explored.front().reason);
        return true;
    }
    f.best = f.answer.minima[0].evaluation;
    Predictor(study).complete(f.best);
    const bool stated = study.noise == study::NoiseSource::stated;
    const std::size_t readings = fitted.misfit.size();
    const std::size_t parameters = study.space.axes.size();
    f.chi2 = fitted.misfit.residuals(f.best.responses).squaredNorm();
    f.dof = static_cast<int>(readings) - static_cast<int>(parameters - f.answer.directions.flat.size());
    if (stated && f.dof > 0) {
        f.p_value = gsl_cdf_chisq_Q(f.chi2, f.dof);
    }
    f.aicc = diagnose::aicc(f.chi2, readings, parameters, stated);
    f.study_holds = held_out_rms(study, f.best.responses);
    f.group_rms = group_rms(study, f.best);
    f.by_place = left_out_rms(fitted, engine, layout_of(study), f.answer);
    return f.by_place.has_value() || !run::interrupted();
}

void weigh(std::vector<Fitted>& laws) {
    double least = std::numeric_limits<double>::infinity();
    for (const Fitted& f : laws) {
        least = f.failed.empty() ? std::min(least, f.aicc) : least;
    }
    double sum = 0.0;
    for (Fitted& f : laws) {
        f.weight = f.failed.empty() && std::isfinite(f.aicc) ? std::exp(-(f.aicc - least) / 2.0) : 0.0;
        sum += f.weight;
    }
    for (Fitted& f : laws) {
        f.weight = sum > 0.0 ? f.weight / sum : 0.0;
    }
    std::stable_sort(laws.begin(), laws.end(), [](const Fitted& a, const Fitted& b) {
        return a.failed.empty() != b.failed.empty() ? a.failed.empty()
               : a.aicc != b.aicc                   ? a.aicc < b.aicc
                                                    : a.chi2 < b.chi2;
    });
}

std::vector<std::string> findings(const std::vector<Fitted>& laws, const std::string& layer) {
    std::vector<std::string> text;
    const Fitted& first = laws[0];
    if (!first.failed.empty()) {
        return {"No law has an answer."};
    }
    if (!std::isfinite(first.aicc)) {
        text.emplace_back("There are too few readings for so many parameters: no criterion can weigh the laws. Hold "
                          "parameters, or add readings.");
    } else {
        std::vector<std::string> alive;
        std::vector<std::string> out;
        std::vector<std::string> unweighed;
        for (const Fitted& f : laws) {
            if (f.failed.empty()) {
                (!std::isfinite(f.aicc) ? unweighed : f.weight >= 0.05 ? alive : out).emplace_back(f.law->name());
            }
        }
        if (alive.size() == 1) {
            text.push_back(fmt::format(
                "In \"{}\" AICc prefers {}{}.", layer, alive[0],
                out.empty() ? ""
                            : fmt::format(": next best is {}, {} higher", out[0], figure(laws[1].aicc - first.aicc))));
        } else {
            text.push_back(fmt::format("The data cannot tell these laws in \"{}\" apart: {}.{}", layer,
                                       pave::join(alive),
                                       out.empty() ? "" : " They speak against " + pave::join(out) + "."));
        }
        if (!unweighed.empty()) {
            text.push_back(fmt::format("That is among the laws that AICc can weigh: for so few readings {} {} too many "
                                       "parameters.",
                                       pave::join(unweighed), unweighed.size() == 1 ? "has" : "have"));
        }
    }
    const auto fits = [](const Fitted& f) { return f.failed.empty() && f.p_value && *f.p_value >= 0.05; };
    if (std::any_of(laws.begin(), laws.end(), [](const Fitted& f) { return f.p_value.has_value(); })) {
        std::vector<std::string> names;
        for (const Fitted& f : laws) {
            if (fits(f)) {
                names.emplace_back(f.law->name());
            }
        }
        text.push_back(names.empty() ? "None fits within the stated noise: something else is missing (diagnose)."
                                     : "Within the stated noise fit: " + pave::join(names) + ".");
    }
    const auto best_predictor = std::min_element(laws.begin(), laws.end(), [](const Fitted& a, const Fitted& b) {
        return a.by_place.value_or(INFINITY) < b.by_place.value_or(INFINITY);
    });
    if (best_predictor->by_place) {
        text.push_back(fmt::format("Readings left out place by place are predicted best by {} ({}{}).",
                                   best_predictor->law->name(), figure(*best_predictor->by_place),
                                   best_predictor->p_value ? " standard deviations" : ""));
    }
    return text;
}

Json comparison_json(const std::vector<Fitted>& laws, const study::Study& study, const std::string& layer) {
    Json json = {{"layer", layer}, {"laws", Json::array()}};
    for (const Fitted& f : laws) {
        Json law = {{"law", std::string(f.law->name())}, {"summary", std::string(f.law->summary())}};
        if (!f.failed.empty()) {
            law["status"] = "failed";
            law["reason"] = f.failed;
            json["laws"].push_back(std::move(law));
            continue;
        }
        law["status"] = "converged";
        law["misfit"] = study::make_problem(f.study, study::Scope::fitted).misfit.residuals(f.best.responses).norm();
        law["chi2"] = f.chi2;
        law["dof"] = f.dof;
        law["p_value"] = report::optional_json(f.p_value);
        law["aicc"] = std::isfinite(f.aicc) ? Json(f.aicc) : Json(nullptr);
        law["weight"] = f.weight;
        law["held_out_rms"] = report::optional_json(f.by_place);
        law["study_held_out_rms"] = report::optional_json(f.study_holds);
        law["verdict"] = std::string(landscape::verdict_names[static_cast<int>(f.answer.verdict)]);
        law["minima"] = f.answer.minima.size();
        law["parameters"] = Json::object();
        for (std::size_t k = 0; k < f.study.space.axes.size(); ++k) {
            Json value = {{"value", f.best.parameters[k]}};
            if (k < f.answer.parameters.size()) {
                value["low"] = f.answer.parameters[k].low;
                value["high"] = f.answer.parameters[k].high;
            }
            law["parameters"][f.study.space.axes[k].name] = std::move(value);
        }
        law["outputs"] = Json::array();
        for (std::size_t o = 0; o < study.outputs.size(); ++o) {
            const std::size_t i = study.measurements.size() + o;
            const double si = study.response_to_si(i);
            Json output = {{"name", study.outputs[o].name},
                           {"best", f.best.responses[i] / si},
                           {"unit", std::string(study.response_unit(i))}};
            if (o < f.answer.outputs.size()) {
                output["low"] = f.answer.outputs[o].low / si;
                output["high"] = f.answer.outputs[o].high / si;
            }
            law["outputs"].push_back(std::move(output));
        }
        law["groups"] = Json::object();
        for (std::size_t g = 0; g < study.groups.size(); ++g) {
            law["groups"][study.groups[g].name] = f.group_rms[g];
        }
        law["responses"] = report::responses_json(study, f.best.responses);
        law["warnings"] = f.best.warnings;
        json["laws"].push_back(std::move(law));
    }
    return json;
}

std::string comparison_text(const std::vector<Fitted>& laws, const study::Study& study) {
    const auto optional = [](const std::optional<double>& v) { return v ? figure(*v) : std::string("-"); };
    report::Table table({"law", "varied", "chi2", "dof", "p", "AICc", "weight", "left out", "held out", "answer"});
    for (const Fitted& f : laws) {
        if (!f.failed.empty()) {
            table.add({std::string(f.law->name()), "", "", "", "", "", "", "", "", f.failed});
            continue;
        }
        table.add({std::string(f.law->name()), fmt::format("{}", f.study.space.axes.size()), figure(f.chi2),
                   fmt::format("{}", f.dof), f.p_value ? fmt::format("{:.2g}", *f.p_value) : "-",
                   std::isfinite(f.aicc) ? figure(f.aicc) : "-",
                   std::isfinite(f.aicc) ? fmt::format("{:.0f} %", 100.0 * f.weight) : "-", optional(f.by_place),
                   optional(f.study_holds), std::string(landscape::verdict_names[static_cast<int>(f.answer.verdict)])});
    }
    std::string text =
        table.text() +
        "  left out: error of readings predicted place by place by fits without them; held out: of those "
        "that the study\n  holds out; both root mean squares of residuals\n";
    if (!study.outputs.empty()) {
        text += fmt::format("  {}\n", sign_convention);
    }
    for (const Fitted& f : laws) {
        if (!f.failed.empty()) {
            continue;
        }
        text += fmt::format("\n{}: {}\n", f.law->name(), f.law->summary());
        report::Table values({"", "best", "low", "high", "unit"});
        const bool ranges = !f.answer.parameters.empty();
        for (std::size_t k = 0; k < f.study.space.axes.size(); ++k) {
            values.add({f.study.space.axes[k].name, figure(f.best.parameters[k]),
                        ranges ? figure(f.answer.parameters[k].low) : "-",
                        ranges ? figure(f.answer.parameters[k].high) : "-", ""});
        }
        for (std::size_t o = 0; o < study.outputs.size(); ++o) {
            const std::size_t i = study.measurements.size() + o;
            const double si = study.response_to_si(i);
            const bool range = o < f.answer.outputs.size();
            values.add({study.outputs[o].name, figure(f.best.responses[i] / si),
                        range ? figure(f.answer.outputs[o].low / si) : "-",
                        range ? figure(f.answer.outputs[o].high / si) : "-", std::string(study.response_unit(i))});
        }
        text += values.text();
        for (std::size_t g = 0; g < study.groups.size() && study.groups.size() > 1; ++g) {
            text += fmt::format("  {}{}: residual {}\n", study.groups[g].name,
                                study.groups[g].held_out ? " (held out)" : "", figure(f.group_rms[g]));
        }
    }
    return text;
}

int compare(const CompareOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    const study::Study study = study::load_study(options.common.study);
    study::make_problem(study, study::Scope::fitted); // complains of what is missing
    const std::size_t layer = layer_of(study, options.layer);
    const std::string& layer_name = study.model.layers[layer].name;
    std::vector<Fitted> laws;
    for (const Law* law : laws_of(options)) {
        Fitted f;
        f.law = law;
        f.study = study::with_law(study, layer, *law, {.file = study.file, .key = "--laws"});
        laws.push_back(std::move(f));
    }
    const std::string settings = fmt::format(
        "{} explored, {} to verify, at most {} searches of {} evaluations, seed {}", options.analysis.explore,
        options.analysis.verify, options.analysis.max_searches, options.analysis.max_evaluations, options.common.seed);
    const std::string folder = options.common.folder(study);
    run::Store store(folder, session(options.common));
    for (Fitted& f : laws) {
        if (!fit_law(f, options, store, settings)) {
            return report_interrupt(folder);
        }
    }
    weigh(laws);
    Json json = comparison_json(laws, study, layer_name);
    const auto words = findings(laws, layer_name);
    json["findings"] = words;
    json["noise"] = study.noise_name();
    json["study"] = {{"file", study.file}, {"title", study.title}, {"hash", study.hash}};
    json["version"] = PAVESCAPE_VERSION;
    json["seed"] = options.common.seed;
    json["run"] = folder;
    const bool failed = !laws[0].failed.empty();
    if (failed) {
        json["status"] = "failed";
        json["reason"] = laws[0].failed;
    }
    store.put_result(store.begin(run_header(laws[0].study, "compare", settings)), report::json_text(json, -1));
    write_file(folder, "compare.json", report::json_text(json) + "\n");
    if (options.common.json) {
        fmt::print("{}\n", report::json_text(json));
    } else {
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        fmt::print("{}\n  {} in \"{}\", {}\n\n", study_summary(study), counted(laws.size(), "law", "laws"), layer_name,
                   run::duration_words(seconds));
        for (const std::string& sentence : words) {
            fmt::print("  {}\n", sentence);
        }
        fmt::print("\n{}\n  results: {}/compare.json\n", comparison_text(laws, study), folder);
    }
    if (failed) {
        run::message("pavescape: no law has an answer; the first says: {}\n", laws[0].failed);
    }
    return failed ? computation_failed : done;
}

} // namespace

void add_compare(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("compare", "the same data, another law in the same layer: which do they prefer?");
    auto options = std::make_shared<CompareOptions>();
    add_common(*command, options->common);
    command->add_option("--layer", options->layer,
                        "the layer in question (default: the one whose law depends on stress)");
    command->add_option("--laws", options->laws, "laws to compare (default: all)")->delimiter(',');
    command->add_option("--explore", options->analysis.explore, "points of each law's Sobol sample, with derivatives")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
    command
        ->add_option("--verify", options->analysis.verify,
                     "independent searches of each law that must find no new minimum before the search ends")
        ->check(CLI::Range(1, 100'000))
        ->capture_default_str();
    command->footer("Example: pavescape compare grids/captif-p1-unique-fwd.toml --laws uzan,k-theta,linear");
    command->callback([=, &action] { action = [=] { return compare(*options); }; });
}

} // namespace explore::cli

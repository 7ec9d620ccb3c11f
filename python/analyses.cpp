// The analyses of the command line, as dictionaries equal to its JSON and with arrays beside them.
#include "analyses.h"

#include "call.h"
#include "report/compare.h"
#include "report/diagnose.h"
#include "report/fit.h"
#include "report/map.h"
#include "report/road_run.h"
#include "report/sample.h"
#include "report/sensitivity.h"
#include "report/survey.h"
#include "report/unique.h"

#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace python {
namespace {

namespace analysis = explore::analysis;
namespace report = explore::report;
using Eigen::Index;

py::object fit(const Study& study, const py::object& starts, const py::object& explore, const std::string& model,
               bool joint_only, const std::string& out, const py::object& threads, const py::object& seed,
               const std::string& method, const std::string& scheme, const py::object& model_error) {
    analysis::FitOptions options{.model = model_of(model, model_error),
                                 .explore = whole(explore, "explore", allowed::fit_explore),
                                 .joint_only = joint_only};
    options.scheme = static_cast<analysis::Scheme>(one_of(scheme, analysis::scheme_names, "scheme"));
    options.multistart.starts = whole(starts, "starts", allowed::fit_starts);
    std::vector<std::string> methods;
    for (const auto& known : explore::optimise::methods()) {
        methods.emplace_back(known.name);
    }
    one_of(method, methods, "method");
    options.multistart.method = method;
    return analysed(
        run_options(out, threads, seed), "fit",
        [&](auto& session) { return analysis::fit(session, study.study(), options); }, report::fit_json);
}

py::object map(const Study& study, const std::string& design, const py::object& points, const std::string& model,
               const std::string& out, const py::object& threads, const py::object& seed,
               const py::object& model_error) {
    static constexpr std::string_view designs[] = {"auto", "grid", "sobol", "adaptive"};
    const analysis::MapOptions options{
        .model = model_of(model, model_error),
        .design = static_cast<analysis::MapDesign>(one_of(design, designs, "design")),
        .points = whole_or_none(points, "points", allowed::map_points, "0 (as many as usual)")};
    if (options.design == analysis::MapDesign::adaptive && options.points > 0) {
        whole(points, "points", {explore::landscape::least_adaptive, allowed::map_points.high});
    }
    Eigen::MatrixXd parameters;
    Eigen::VectorXd misfit;
    py::object json = analysed(
        run_options(out, threads, seed), "map",
        [&](auto& session) {
            auto result = analysis::map(session, study.study(), options);
            if (result) {
                const auto n = static_cast<Index>(result->evaluations.size());
                parameters.resize(n, study.study().space.dimension());
                misfit.resize(n);
                for (Index i = 0; i < n; ++i) {
                    const auto& e = result->evaluations[static_cast<std::size_t>(i)];
                    parameters.row(i) = array(e.parameters);
                    misfit[i] = e.misfit;
                }
            }
            return result;
        },
        report::map_json);
    return py::make_tuple(json, parameters, misfit);
}

// The draws beside the JSON: parameters, outputs (file units; not a number: not computed), weights.
py::object sample(const Study& study, const py::object& samples, const py::object& confirm, const std::string& model,
                  const std::string& out, const py::object& threads, const py::object& seed,
                  const py::object& model_error) {
    analysis::SampleOptions options{.any_model = model.empty(),
                                    .samples = whole(samples, "samples", allowed::sample_draws),
                                    .confirm = whole(confirm, "confirm", allowed::sample_confirm)};
    options.model = model_of(model.empty() ? "full" : model, model_error);
    Eigen::MatrixXd parameters;
    Eigen::MatrixXd outputs;
    Eigen::VectorXd weights;
    py::object json = analysed(
        run_options(out, threads, seed), "sample",
        [&](auto& session) {
            auto result = analysis::sample(session, study.study(), options);
            if (result) {
                const auto n = static_cast<Index>(result->draws.size());
                const auto wanted = study.study().outputs();
                parameters.resize(n, study.study().space.dimension());
                outputs = Eigen::MatrixXd::Constant(n, static_cast<Index>(wanted.size()), NAN);
                weights = array(result->descent.weight);
                for (Index i = 0; i < n; ++i) {
                    const auto& draw = result->draws[static_cast<std::size_t>(i)];
                    parameters.row(i) = array(draw.parameters);
                    for (std::size_t o = 0; o < draw.outputs.size(); ++o) {
                        outputs(i, static_cast<Index>(o)) = study.study().readings[wanted[o]].in_unit(draw.outputs[o]);
                    }
                }
            }
            return result;
        },
        report::sample_json);
    return py::make_tuple(json, parameters, outputs, weights);
}

py::object unique(const Study& study, const py::object& explore, const py::object& verify, const py::object& searches,
                  const std::string& model, const std::string& out, const py::object& threads, const py::object& seed,
                  bool landscape, bool posterior, const py::object& model_error) {
    analysis::UniqueOptions options{
        .model = model_of(model, model_error), .settings = {}, .landscape = landscape, .posterior = posterior};
    options.settings.explore = whole(explore, "explore", allowed::unique_explore);
    options.settings.verify = whole(verify, "verify", allowed::unique_verify);
    options.settings.max_searches = whole(searches, "searches", allowed::unique_searches);
    return analysed(
        run_options(out, threads, seed), "unique",
        [&](auto& session) { return analysis::unique(session, study.study(), options); }, report::unique_json);
}

py::object diagnose(const Study& study, const py::object& explore, const py::object& starts,
                    const py::object& bootstrap, const std::vector<std::string>& without, const std::string& model,
                    const std::string& out, const py::object& threads, const py::object& seed,
                    const py::object& model_error) {
    one_of(model, std::vector<std::string>{"full", "auto"}, "model"); // effects change what a reduced one is made for
    analysis::DiagnoseOptions options{.model = model_of(model, model_error), .without = without, .settings = {}};
    options.settings.explore = whole(explore, "explore", allowed::diagnose_explore);
    options.settings.starts = whole(starts, "starts", allowed::diagnose_starts);
    options.settings.bootstrap = whole(bootstrap, "bootstrap", allowed::diagnose_bootstrap);
    return analysed(
        run_options(out, threads, seed), "diagnose",
        [&](auto& session) {
            auto result = analysis::diagnose(session, study.study(), options);
            if (result && result->is_extended() && !out.empty()) {
                report::write_extended(*result, session.options());
            }
            return result;
        },
        report::diagnose_json);
}

py::object compare(const Study& study, const std::string& layer, const std::vector<std::string>& laws,
                   const py::object& explore, const py::object& verify, const std::string& out,
                   const py::object& threads, const py::object& seed, bool evidence) {
    analysis::CompareOptions options{.layer = layer, .laws = laws};
    options.settings.explore = whole(explore, "explore", allowed::compare_explore);
    options.settings.verify = whole(verify, "verify", allowed::compare_verify);
    options.evidence = evidence;
    return analysed(
        run_options(out, threads, seed), "compare",
        [&](auto& session) { return analysis::compare(session, study.study(), options); }, report::compare_json);
}

py::object sensitivity(const Study& study, const std::vector<std::string>& parameters, const py::object& range,
                       const py::object& points, const py::object& samples, const std::string& out,
                       const py::object& threads, const py::object& seed) {
    const analysis::SensitivityOptions options{.parameters = parameters,
                                               .range = real(range, "range", allowed::sensitivity_range),
                                               .points = whole(points, "points", allowed::sensitivity_points),
                                               .samples = whole(samples, "samples", allowed::sensitivity_samples)};
    return analysed(
        run_options(out, threads, seed), "sensitivity",
        [&](auto& session) { return analysis::sensitivity(session, study.study(), options); },
        report::sensitivity_json);
}

// study: a file whose section and parameters are fitted; empty: no back-calculation.
py::object survey(const std::vector<std::string>& files, const std::string& study, const std::string& columns,
                  const std::string& out, const py::object& threads, const py::object& seed) {
    report::Json json;
    analysis::RunOptions run = run_options(out, threads, seed);
    call([&] {
        analysis::RoadFiles road = analysis::read_road(files, columns);
        if (!out.empty()) {
            analysis::refuse_other_road(out, "survey", road);
        }
        run.inputs = std::move(road.inputs);
        analysis::Session session(std::move(run));
        std::optional<explore::study::Study> of;
        if (!study.empty()) {
            of = explore::study::load_survey_study(study);
        }
        const auto result = analysis::survey(session, std::move(road.files), std::move(of), {});
        if (!result) {
            return false;
        }
        json = report::survey_json(*result);
        report::add_run(json, road, session.options());
        session.keep("survey", report::json_text(json));
        return true;
    });
    return dictionary(json);
}

std::string as_command(const std::string& name) {
    return "As the command " + name +
           ": its JSON as a dictionary. Raises NoAnswer where there is none, ValueError for an argument out of its "
           "range, KeyboardInterrupt where Ctrl-C ended it. out: the folder of the run, which continues; empty: "
           "nothing "
           "is kept. threads: 0 for all.";
}

} // namespace

void add_analyses(py::module_& m, py::class_<Study>& study) {
    using explore::landscape::UniquenessSettings;
    const double error = analysis::ModelOptions{}.limit_percent;
    study
        .def("fit", &fit, py::arg("starts") = explore::landscape::MultistartSettings{}.starts,
             py::arg("explore") = analysis::fit_points, py::arg("model") = "full", py::arg("joint_only") = false,
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1,
             py::arg("method") = explore::landscape::MultistartSettings{}.method, py::arg("scheme") = "multistart",
             py::arg("model_error") = error, as_command("fit").c_str())
        .def("map", &map, py::arg("design") = "auto", py::arg("points") = 0, py::arg("model") = "full",
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1, py::arg("model_error") = error,
             (as_command("map") + " With it, as a tuple, the parameters and the misfit of every point.").c_str())
        .def("unique", &unique, py::arg("explore") = UniquenessSettings{}.explore,
             py::arg("verify") = UniquenessSettings{}.verify, py::arg("searches") = UniquenessSettings{}.max_searches,
             py::arg("model") = "full", py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1,
             py::arg("landscape") = false, py::arg("posterior") = false, py::arg("model_error") = error,
             as_command("unique").c_str())
        .def("diagnose", &diagnose, py::arg("explore") = explore::diagnose::DiagnosisSettings{}.explore,
             py::arg("starts") = explore::diagnose::DiagnosisSettings{}.starts,
             py::arg("bootstrap") = explore::diagnose::DiagnosisSettings{}.bootstrap,
             py::arg("without") = std::vector<std::string>{}, py::arg("model") = "full", py::arg("out") = "",
             py::arg("threads") = 0, py::arg("seed") = 1, py::arg("model_error") = error,
             as_command("diagnose").c_str())
        .def("compare", &compare, py::arg("layer") = "", py::arg("laws") = std::vector<std::string>{},
             py::arg("explore") = UniquenessSettings{}.explore, py::arg("verify") = UniquenessSettings{}.verify,
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1, py::arg("evidence") = false,
             as_command("compare").c_str())
        .def("sample", &sample, py::arg("samples") = analysis::SampleOptions{}.samples,
             py::arg("confirm") = analysis::SampleOptions{}.confirm, py::arg("model") = "", py::arg("out") = "",
             py::arg("threads") = 0, py::arg("seed") = 1, py::arg("model_error") = error,
             (as_command("sample") + " With it, as a tuple, the draws: parameters, outputs and weights.").c_str())
        .def("sensitivity", &sensitivity, py::arg("parameters") = std::vector<std::string>{},
             py::arg("range") = analysis::SensitivityOptions{}.range,
             py::arg("points") = analysis::SensitivityOptions{}.points,
             py::arg("samples") = analysis::SensitivityOptions{}.samples, py::arg("out") = "", py::arg("threads") = 0,
             py::arg("seed") = 1, as_command("sensitivity").c_str());
    m.def("survey", &survey, py::arg("files"), py::arg("study") = "", py::arg("columns") = "", py::arg("out") = "",
          py::arg("threads") = 0, py::arg("seed") = 1,
          (as_command("survey") + " files: of FWD drops; study: of which the parameters are fitted at every station; "
                                  "columns: as --columns.")
              .c_str());
}

} // namespace python

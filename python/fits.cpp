// Fits of a study, and where they fit.
#include "analyses.h"

#include "analysis/common/starts.h"
#include "call.h"
#include "report/fit.h"
#include "report/map.h"
#include "report/sensitivity.h"
#include "report/unique.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace python {
namespace {

namespace analysis = explore::analysis;
namespace report = explore::report;
using Eigen::Index;

std::string fit(const Study& study, const py::object& starts, const py::object& explore, const std::string& model,
                bool joint_only, const std::string& out, const py::object& threads, const py::object& seed,
                const std::string& method, const std::string& scheme, const py::object& model_error,
                const std::vector<std::string>& start, const std::vector<std::string>& from,
                const py::object& evaluations, const py::object& time) {
    analysis::FitOptions options{.model = model_of(model, model_error),
                                 .explore = whole(explore, "explore", allowed::fit_explore),
                                 .joint_only = joint_only};
    options.scheme = static_cast<analysis::Scheme>(one_of(scheme, analysis::scheme_names, "scheme"));
    options.multistart.starts = whole(starts, "starts", allowed::fit_starts);
    options.multistart.search.max_evaluations = whole(evaluations, "evaluations", allowed::fit_evaluations);
    std::vector<std::string> methods;
    for (const auto& known : explore::optimise::methods()) {
        methods.emplace_back(known.name);
    }
    one_of(method, methods, "method");
    options.multistart.method = method;
    return analysed(run_options(out, threads, seed), "fit",
                    [&](auto& session) {
                        for (const std::string& values : start) {
                            options.starts.push_back(analysis::start_of(study.study(), values));
                        }
                        for (const std::string& place : from) {
                            auto found = analysis::starts_from(study.study(), place,
                                                               static_cast<std::size_t>(options.multistart.starts));
                            std::move(found.begin(), found.end(), std::back_inserter(options.starts));
                        }
                        return analysis::fit(session, study.study(), options);
                    },
                    report::fit_json, {time_of(time), &study.study()});
}

py::tuple map(const Study& study, const std::string& design, const py::object& points, const std::string& model,
              const std::string& out, const py::object& threads, const py::object& seed, const py::object& model_error,
              const py::object& time) {
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
    std::string json = analysed(run_options(out, threads, seed), "map",
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
                                report::map_json, {time_of(time), &study.study()});
    return py::make_tuple(json, parameters, misfit);
}

std::string unique(const Study& study, const py::object& explore, const py::object& verify, const py::object& searches,
                   const std::string& model, const std::string& out, const py::object& threads, const py::object& seed,
                   bool landscape, bool posterior, const py::object& model_error, const py::object& time) {
    analysis::UniqueOptions options{
        .model = model_of(model, model_error), .settings = {}, .landscape = landscape, .posterior = posterior};
    options.settings.explore = whole(explore, "explore", allowed::unique_explore);
    options.settings.verify = whole(verify, "verify", allowed::unique_verify);
    options.settings.max_searches = whole(searches, "searches", allowed::unique_searches);
    return analysed(run_options(out, threads, seed), "unique",
                    [&](auto& session) { return analysis::unique(session, study.study(), options); },
                    report::unique_json, {time_of(time), &study.study()});
}

std::string sensitivity(const Study& study, const std::vector<std::string>& parameters, const py::object& range,
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

} // namespace

void add_fits(py::class_<Study>& study) {
    study
        .def("fit", &fit, py::arg("starts"), py::arg("explore"), py::arg("model"), py::arg("joint_only"),
             py::arg("out"), py::arg("threads"), py::arg("seed"), py::arg("method"), py::arg("scheme"),
             py::arg("model_error"), py::arg("start"), py::arg("from_"), py::arg("evaluations"), py::arg("time"))
        .def("map", &map, py::arg("design"), py::arg("points"), py::arg("model"), py::arg("out"), py::arg("threads"),
             py::arg("seed"), py::arg("model_error"), py::arg("time"))
        .def("unique", &unique, py::arg("explore"), py::arg("verify"), py::arg("searches"), py::arg("model"),
             py::arg("out"), py::arg("threads"), py::arg("seed"), py::arg("landscape"), py::arg("posterior"),
             py::arg("model_error"), py::arg("time"))
        .def("sensitivity", &sensitivity, py::arg("parameters"), py::arg("range"), py::arg("points"),
             py::arg("samples"), py::arg("out"), py::arg("threads"), py::arg("seed"));
}

} // namespace python

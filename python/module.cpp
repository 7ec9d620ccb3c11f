// The compiled part of the Python module: everything checked, no argument has a default. What a user sees is in
// pavescape/.
#include "analyses.h"
#include "analysis/design/design.h"
#include "analysis/fit/fit.h"
#include "analysis/sample/sample.h"
#include "analysis/sample/sensitivity.h"
#include "base/error.h"
#include "base/passing_failure.h"
#include "call.h"
#include "diagnose/diagnosis.h"
#include "landscape/uniqueness.h"
#include "run/blas.h"

#include <gsl/gsl_errno.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace py = pybind11;
using python::Study;

namespace {

// Defaults of the command line.
py::dict defaults() {
    namespace analysis = explore::analysis;
    const explore::landscape::MultistartSettings multistart;
    const explore::landscape::UniquenessSettings unique;
    const explore::diagnose::DiagnosisSettings diagnose;
    const analysis::SampleOptions sample;
    const analysis::SensitivityOptions sensitivity;
    const analysis::DesignOptions design;
    py::dict all;
    all["fit_starts"] = multistart.starts;
    all["fit_explore"] = analysis::fit_points;
    all["fit_method"] = multistart.method;
    all["fit_evaluations"] = multistart.search.max_evaluations;
    all["unique_explore"] = unique.explore;
    all["unique_verify"] = unique.verify;
    all["unique_searches"] = unique.max_searches;
    all["diagnose_explore"] = diagnose.explore;
    all["diagnose_starts"] = diagnose.starts;
    all["diagnose_bootstrap"] = diagnose.bootstrap;
    all["sample_samples"] = sample.samples;
    all["sample_confirm"] = sample.confirm;
    all["sensitivity_range"] = sensitivity.range;
    all["sensitivity_points"] = sensitivity.points;
    all["sensitivity_samples"] = sensitivity.samples;
    all["design_reliability"] = design.reliability_percent;
    all["design_years"] = design.years;
    all["model_error"] = analysis::ModelOptions{}.limit_percent;
    return all;
}

} // namespace

PYBIND11_MODULE(_pavescape, m) {
    explore::run::prepare_blas();
    gsl_set_error_handler_off(); // a number that cannot be computed is none; GSL would end the process
    m.attr("__version__") = PAVESCAPE_VERSION;
    m.attr("defaults") = defaults();
    m.attr("passing_words") = std::string(pave::passing_words);
    py::register_exception<python::NoAnswer>(m, "NoAnswer", PyExc_RuntimeError).attr("__doc__") =
        "A computation without an answer: of a model at these values, or of an analysis. Its text says why.";
    py::register_exception_translator([](std::exception_ptr p) {
        try {
            std::rethrow_exception(std::move(p));
        } catch (const pave::Error& error) {
            PyErr_SetString(PyExc_ValueError, error.what());
        }
    });
    py::class_<Study> study(m, "Study");
    study.def(py::init(&Study::of_file), py::arg("file"))
        .def_static("from_text", &Study::of_text, py::arg("text"), py::arg("files"), py::arg("name"))
        .def_static(
            "of_function",
            [](const std::string& text, const std::map<std::string, std::string>& files, const std::string& name,
               py::object function, py::object jacobian, const std::string& identity, std::size_t parameters,
               std::size_t responses) {
                return Study::of_function(text, files, name,
                                          {std::move(function), std::move(jacobian), identity, parameters, responses});
            },
            py::arg("text"), py::arg("files"), py::arg("name"), py::arg("function"), py::arg("jacobian"),
            py::arg("identity"), py::arg("parameters"), py::arg("responses"))
        .def(py::pickle([](const Study& s) { return s.state(); }, &Study::of_state))
        .def("__repr__", &Study::words)
        .def_property_readonly("title", [](const Study& s) { return s.study().title; })
        .def_property_readonly("parameters", &Study::parameters)
        .def_property_readonly("low", &Study::low)
        .def_property_readonly("high", &Study::high)
        .def_property_readonly("start", &Study::start)
        .def_property_readonly("responses", &Study::responses)
        .def_property_readonly("measured", &Study::measured)
        .def("forward", &Study::forward, py::arg("values"))
        .def("jacobian", &Study::jacobian, py::arg("values"))
        .def("residuals", &Study::residuals, py::arg("values"))
        .def("residual_jacobian", &Study::residual_jacobian, py::arg("values"))
        .def("residuals_and_jacobian", &Study::residuals_and_jacobian, py::arg("values"));
    python::add_fits(study);
    python::add_judgements(study);
    python::add_roads(m);
    python::add_pages(m);
}

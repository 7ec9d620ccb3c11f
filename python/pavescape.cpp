// The Python module: studies, their forward model and their misfit as functions of NumPy arrays, and the analyses of
// the command line.
#include "analyses.h"
#include "base/error.h"
#include "call.h"
#include "run/blas.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace py = pybind11;
using python::Study;

PYBIND11_MODULE(pavescape, m) {
    explore::run::prepare_blas();
    m.doc() = "Stress-dependent pavement models: forward runs, exact derivatives and fits of the studies of pavescape.";
    m.attr("__version__") = PAVESCAPE_VERSION;
    py::register_exception<python::NoAnswer>(m, "NoAnswer", PyExc_RuntimeError);
    py::register_exception_translator([](std::exception_ptr p) {
        try {
            std::rethrow_exception(std::move(p));
        } catch (const pave::Error& error) {
            PyErr_SetString(PyExc_ValueError, error.what());
        }
    });
    const std::string of_values =
        "values: of the parameters in their order, in the units of the study; None: the study's own.";
    py::class_<Study> study(m, "Study",
                            "A study file with its measurements. Raises ValueError for what is wrong in it. Can be "
                            "copied and pickled: the copy holds the files as they were read.");
    study.def(py::init(&Study::of_file), py::arg("file"))
        .def_static("from_text", &Study::of_text, py::arg("text"),
                    py::arg("files") = std::map<std::string, std::string>{}, py::arg("name") = "study.toml",
                    "A study in memory: the text of the study, and the texts of its data files by the names it calls "
                    "them.")
        .def(py::pickle([](const Study& s) { return s.state(); }, &Study::of_state))
        .def("__repr__", &Study::words)
        .def_property_readonly("title", [](const Study& s) { return s.study().title; })
        .def_property_readonly("parameters", &Study::parameters, "names of what the study varies")
        .def_property_readonly("low", &Study::low)
        .def_property_readonly("high", &Study::high)
        .def_property_readonly("start", &Study::start, "the study's own values")
        .def_property_readonly("responses", &Study::responses,
                               "place and unit of every response: readings, then outputs")
        .def_property_readonly("measured", &Study::measured,
                               "in the units of the responses; fewer, where there are outputs")
        .def("forward", &Study::forward, py::arg("values") = py::none(),
             ("Responses, an array. Raises NoAnswer where the model has none. " + of_values).c_str())
        .def("jacobian", &Study::jacobian, py::arg("values") = py::none(),
             ("(responses, their derivatives: responses x parameters). " + of_values).c_str())
        .def("residuals", &Study::residuals, py::arg("values") = py::none(),
             ("Residuals of the study's misfit, an array; its norm is the misfit. Loads that only outputs need are not "
              "computed. " +
              of_values)
                 .c_str())
        .def("residual_jacobian", &Study::residual_jacobian, py::arg("values") = py::none(),
             ("Derivatives of the residuals: residuals x parameters. " + of_values).c_str())
        .def("residuals_and_jacobian", &Study::residuals_and_jacobian, py::arg("values") = py::none(),
             ("(residuals, their derivatives) by one run. " + of_values).c_str());
    python::add_analyses(m, study);
}

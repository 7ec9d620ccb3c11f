// Figures and pages of results.
#include "analyses.h"
#include "call.h"
#include "report/drawing.h"
#include "report/run_folder.h"
#include "report/run_page.h"

#include <pybind11/stl.h>

namespace python {
namespace {

namespace report = explore::report;

// Of a run's folder, or of results as text, {analysis: its JSON}.
report::FolderContents contents_of(const std::string& folder, const std::string& results,
                                   const std::vector<std::string>& analyses) {
    if (folder.empty()) {
        return {report::Json::parse(results), report::Json()};
    }
    report::RunFolder read = report::read_run_folder(folder, analyses);
    return {std::move(read.results), std::move(read.evaluations)};
}

std::vector<std::string> figures(const std::string& results) {
    return report::figures_of(contents_of("", results, {}));
}

std::vector<std::string> draw(const std::string& folder, const std::string& results,
                              const std::vector<std::string>& analyses, const std::vector<std::string>& names,
                              const std::string& format, const std::string& out) {
    report::DrawingOptions options{.of = folder.empty() ? "result" : folder, .figures = names, .out = out};
    options.format = static_cast<report::FigureFormat>(one_of(format, report::figure_format_names, "format"));
    const py::gil_scoped_release release;
    return report::draw_figures(contents_of(folder, results, analyses), options);
}

std::string write_page(const std::string& folder, const std::vector<std::string>& analyses, const std::string& out) {
    const py::gil_scoped_release release;
    return report::write_page_of(folder, analyses, out).file;
}

} // namespace

void add_pages(py::module_& m) {
    m.def("figures", &figures, py::arg("results"));
    m.def("draw", &draw, py::arg("folder"), py::arg("results"), py::arg("analyses"), py::arg("names"),
          py::arg("format"), py::arg("out"));
    m.def("write_page", &write_page, py::arg("folder"), py::arg("analyses"), py::arg("out"));
}

} // namespace python

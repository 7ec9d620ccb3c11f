// Roads of FWD drops.
#include "analyses.h"

#include "call.h"
#include "report/noise.h"
#include "report/road.h"
#include "report/road_run.h"
#include "report/survey.h"

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace python {
namespace {

namespace analysis = explore::analysis;
namespace report = explore::report;

// analyse(session, files): the JSON of the command `name` with this study, or nothing where it was interrupted.
template <class Analyse>
std::string analysed_road(const std::vector<std::string>& files, const std::string& columns, const std::string& layers,
                          const std::string& study, const char* name, analysis::RunOptions run,
                          const Analyse& analyse) {
    std::string text;
    call([&] {
        analysis::RoadFiles road = analysis::read_road(files, columns, layers);
        const std::string folder = run.folder;
        const std::string before = folder.empty() ? std::string() : analysis::earlier_study(folder, name, road);
        run.inputs = std::move(road.inputs);
        analysis::Session session(std::move(run));
        std::optional<report::Json> json = analyse(session, std::move(road.files));
        if (!json) {
            return false;
        }
        report::add_run(*json, road, session.options());
        text = report::json_text(*json);
        session.keep(name, text);
        analysis::say_what_was_replaced(folder, name, before, study);
        return true;
    });
    return text;
}

template <class Result>
std::optional<report::Json> json_of(const std::optional<Result>& result, report::Json (*render)(const Result&)) {
    return result ? std::optional(render(*result)) : std::nullopt;
}

// As "40kN"; empty: none.
std::optional<analysis::LoadLevel> load_of(const std::string& text, const char* name) {
    const auto level = analysis::load_level_of(text);
    if (!text.empty() && !level) {
        throw py::value_error(std::string(name) + " = \"" + text + "\"; allowed: a load as 40kN, 566kPa");
    }
    return level;
}

// study: a file whose section and parameters are fitted; empty: no back-calculation.
std::string survey(const std::vector<std::string>& files, const std::string& study, const std::string& columns,
                   const std::string& layers, const std::string& out, const py::object& threads,
                   const py::object& seed) {
    const analysis::SurveyOptions options{.layers = layers};
    const auto run = run_options(out, threads, seed);
    return analysed_road(files, columns, layers, study, "survey", run, [&](auto& session, auto read) {
        std::optional<explore::study::Study> of;
        if (!study.empty()) {
            of = explore::study::load_survey_study(study);
        }
        return json_of(analysis::survey(session, std::move(read), std::move(of), options), report::survey_json);
    });
}

std::string road(const std::vector<std::string>& files, const std::string& study, const std::string& columns,
                 const std::string& layers, const std::string& withhold, bool diagnose, const std::string& out,
                 const py::object& threads, const py::object& seed) {
    const analysis::RoadOptions options{
        .survey = {.layers = layers}, .withhold = load_of(withhold, "withhold"), .diagnose = diagnose};
    const auto run = run_options(out, threads, seed);
    return analysed_road(files, columns, layers, study, "road", run, [&](auto& session, auto read) {
        return json_of(analysis::road(session, std::move(read), explore::study::load_survey_study(study), options),
                       report::road_json);
    });
}

std::string noise(const std::vector<std::string>& files, const std::string& columns) {
    const py::gil_scoped_release release;
    return report::json_text(
        report::noise_json(analysis::noise_of_drops(explore::data::read_fwd_files(files, columns))));
}

} // namespace

void add_roads(py::module_& m) {
    m.def("survey", &survey, py::arg("files"), py::arg("study"), py::arg("columns"), py::arg("layers"), py::arg("out"),
          py::arg("threads"), py::arg("seed"));
    m.def("road", &road, py::arg("files"), py::arg("study"), py::arg("columns"), py::arg("layers"), py::arg("withhold"),
          py::arg("diagnose"), py::arg("out"), py::arg("threads"), py::arg("seed"));
    m.def("noise", &noise, py::arg("files"), py::arg("columns"));
}

} // namespace python

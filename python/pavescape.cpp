// The Python module: studies, their forward model and their misfit as functions of NumPy arrays, and the analyses of
// the command line as dictionaries equal to its JSON.
#include "pavement/forward.h"
#include "report/compare.h"
#include "report/diagnose.h"
#include "report/fit.h"
#include "report/map.h"
#include "report/road_run.h"
#include "report/sample.h"
#include "report/sensitivity.h"
#include "report/survey.h"
#include "report/unique.h"
#include "run/blas.h"

#include <mutex>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

namespace py = pybind11;

namespace {

// What a computation without an answer becomes in Python.
struct NoAnswer : std::runtime_error {
    using std::runtime_error::runtime_error;
};

Eigen::VectorXd array(const std::vector<double>& values) {
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Where and how an analysis runs.
explore::analysis::RunOptions run_options(const std::string& out, int threads, std::uint64_t seed) {
    return {.folder = out, .threads = threads, .seed = seed, .show_progress = false};
}

template <class Enum, std::size_t N>
Enum one_of(const std::string& word, const std::string_view (&words)[N], const char* what) {
    for (std::size_t i = 0; i < N; ++i) {
        if (words[i] == word) {
            return static_cast<Enum>(i);
        }
    }
    throw py::value_error(std::string("unknown ") + what + " \"" + word +
                          "\"; allowed: " + pave::join({std::begin(words), std::end(words)}));
}

explore::analysis::ModelOptions model_of(const std::string& name) {
    return {.use = one_of<explore::analysis::ModelUse>(name, explore::analysis::model_names, "model")};
}

py::object dictionary(const explore::report::Json& json) {
    return py::module_::import("json").attr("loads")(explore::report::json_text(json, -1));
}

// analyse(session): an optional result; json(result, run). The JSON of the command, kept where it keeps it.
template <class Analyse, class Render>
py::object analysed(const explore::analysis::RunOptions& run, const char* name, const Analyse& analyse,
                    const Render& render) {
    explore::report::Json json;
    {
        const py::gil_scoped_release release;
        explore::analysis::Session session(run);
        const auto result = analyse(session);
        if (!result) {
            throw std::runtime_error("interrupted");
        }
        json = render(*result, session.options());
        if (result->failed()) {
            throw NoAnswer(json.value("reason", "no answer"));
        }
        session.keep(name, explore::report::json_text(json));
    }
    return dictionary(json);
}

class Study {
public:
    explicit Study(explore::study::Study study) : study_(std::move(study)) {
        if (!study_.parameters.empty()) {
            if (study_.measured().empty()) {
                function_ = explore::study::make_prediction_problem(study_).function;
            } else {
                problem_ = explore::study::make_problem(study_);
                function_ = problem_->function;
            }
        }
        for (const auto& reading : study_.readings) {
            to_si_.push_back(reading.unit.to_si);
        }
    }

    const explore::study::Study& study() const { return study_; }

    std::vector<std::string> parameters() const { return each(&explore::problem::Axis::name); }
    Eigen::VectorXd low() const { return array(each(&explore::problem::Axis::low)); }
    Eigen::VectorXd high() const { return array(each(&explore::problem::Axis::high)); }
    Eigen::VectorXd start() const { return array(each(&explore::problem::Axis::start)); }

    std::vector<py::dict> responses() const {
        std::vector<py::dict> list;
        for (const auto& reading : study_.readings) {
            py::dict row;
            row["load"] = reading.load;
            row["quantity"] = reading.quantity;
            row["x_mm"] = reading.x_mm;
            row["y_mm"] = reading.y_mm;
            row["depth_mm"] = reading.depth_mm;
            row["gauge_mm"] = reading.gauge_mm;
            if (reading.time_ms) {
                row["time_ms"] = *reading.time_ms;
            }
            row["unit"] = std::string(reading.unit.name);
            if (!reading.is_measured()) {
                row["name"] = reading.output;
            }
            list.push_back(std::move(row));
        }
        return list;
    }

    Eigen::VectorXd measured() const {
        std::vector<double> values;
        for (const auto& reading : study_.measured()) {
            values.push_back(reading.value);
        }
        return array(values);
    }

    Eigen::VectorXd forward(const std::optional<Eigen::VectorXd>& values) const {
        return in_units(evaluate(values, false).responses);
    }

    std::pair<Eigen::VectorXd, Eigen::MatrixXd> jacobian(const std::optional<Eigen::VectorXd>& values) const {
        const auto e = evaluate(values, true);
        Eigen::MatrixXd j = e.jacobian;
        for (Eigen::Index i = 0; i < j.rows(); ++i) {
            j.row(i) /= to_si_[static_cast<std::size_t>(i)];
        }
        return {in_units(e.responses), j};
    }

    Eigen::VectorXd residuals(const std::optional<Eigen::VectorXd>& values) const {
        explore::problem::Evaluation e;
        e.responses = evaluate(values, false).responses;
        return problem().residuals(e);
    }

    Eigen::MatrixXd residual_jacobian(const std::optional<Eigen::VectorXd>& values) const {
        const auto& of = problem();
        const Computed computed = evaluate(values, true);
        explore::problem::Evaluation e;
        const std::vector<double> own = each(&explore::problem::Axis::start);
        e.parameters = values ? std::vector<double>(values->data(), values->data() + values->size()) : own;
        e.responses = computed.responses;
        e.jacobian = computed.jacobian;
        Eigen::MatrixXd j = of.residual_jacobian(e); // by unit coordinates
        for (std::size_t k = 0; k < of.space.axes.size(); ++k) {
            const auto& axis = of.space.axes[k];
            j.col(static_cast<Eigen::Index>(k)) /= axis.d_physical(axis.unit(e.parameters[k]));
        }
        return j;
    }

    py::object fit(int starts, int explore, const std::string& model, bool joint_only, const std::string& out,
                   int threads, std::uint64_t seed) const {
        explore::analysis::FitOptions options{.model = model_of(model), .explore = explore, .joint_only = joint_only};
        options.multistart.starts = starts;
        return analysed(
            run_options(out, threads, seed), "fit",
            [&](auto& session) { return explore::analysis::fit(session, study_, options); }, explore::report::fit_json);
    }

    // With the points as arrays beside the JSON.
    py::object map(const std::string& design, int points, const std::string& model, const std::string& out, int threads,
                   std::uint64_t seed) const {
        static constexpr std::string_view designs[] = {"auto", "grid", "sobol", "adaptive"};
        const explore::analysis::MapOptions options{.model = model_of(model),
                                                    .design =
                                                        one_of<explore::analysis::MapDesign>(design, designs, "design"),
                                                    .points = points};
        Eigen::MatrixXd parameters;
        Eigen::VectorXd misfit;
        py::object json = analysed(
            run_options(out, threads, seed), "map",
            [&](auto& session) {
                auto result = explore::analysis::map(session, study_, options);
                if (result) {
                    const auto n = static_cast<Eigen::Index>(result->evaluations.size());
                    parameters.resize(n, study_.space.dimension());
                    misfit.resize(n);
                    for (Eigen::Index i = 0; i < n; ++i) {
                        const auto& e = result->evaluations[static_cast<std::size_t>(i)];
                        parameters.row(i) = array(e.parameters);
                        misfit[i] = e.misfit;
                    }
                }
                return result;
            },
            explore::report::map_json);
        return py::make_tuple(json, parameters, misfit);
    }

    // With the draws as arrays beside the JSON: parameters, outputs (file units; not a number: not computed), weights.
    py::object sample(int samples, int confirm, const std::string& model, const std::string& out, int threads,
                      std::uint64_t seed) const {
        explore::analysis::SampleOptions options{.any_model = model.empty(), .samples = samples, .confirm = confirm};
        if (!model.empty()) {
            options.model = model_of(model);
        }
        Eigen::MatrixXd parameters;
        Eigen::MatrixXd outputs;
        Eigen::VectorXd weights;
        py::object json = analysed(
            run_options(out, threads, seed), "sample",
            [&](auto& session) {
                auto result = explore::analysis::sample(session, study_, options);
                if (result) {
                    const auto n = static_cast<Eigen::Index>(result->draws.size());
                    const auto wanted = study_.outputs();
                    parameters.resize(n, study_.space.dimension());
                    outputs = Eigen::MatrixXd::Constant(n, static_cast<Eigen::Index>(wanted.size()), NAN);
                    weights = array(result->descent.weight);
                    for (Eigen::Index i = 0; i < n; ++i) {
                        const auto& draw = result->draws[static_cast<std::size_t>(i)];
                        parameters.row(i) = array(draw.parameters);
                        for (std::size_t o = 0; o < draw.outputs.size(); ++o) {
                            outputs(i, static_cast<Eigen::Index>(o)) =
                                study_.readings[wanted[o]].in_unit(draw.outputs[o]);
                        }
                    }
                }
                return result;
            },
            explore::report::sample_json);
        return py::make_tuple(json, parameters, outputs, weights);
    }

    py::object unique(int explore, int verify, int searches, const std::string& model, const std::string& out,
                      int threads, std::uint64_t seed) const {
        explore::analysis::UniqueOptions options{.model = model_of(model)};
        options.settings.explore = explore;
        options.settings.verify = verify;
        options.settings.max_searches = searches;
        return analysed(
            run_options(out, threads, seed), "unique",
            [&](auto& session) { return explore::analysis::unique(session, study_, options); },
            explore::report::unique_json);
    }

    py::object diagnose(int explore, int starts, int bootstrap, const std::vector<std::string>& without,
                        const std::string& model, const std::string& out, int threads, std::uint64_t seed) const {
        const explore::analysis::DiagnoseOptions options{
            .model = model_of(model),
            .without = without,
            .settings = {.explore = explore, .starts = starts, .bootstrap = bootstrap}};
        return analysed(
            run_options(out, threads, seed), "diagnose",
            [&](auto& session) {
                auto result = explore::analysis::diagnose(session, study_, options);
                if (result && result->is_extended() && !out.empty()) {
                    explore::report::write_extended(*result, session.options());
                }
                return result;
            },
            explore::report::diagnose_json);
    }

    py::object compare(const std::string& layer, const std::vector<std::string>& laws, int explore, int verify,
                       const std::string& out, int threads, std::uint64_t seed) const {
        explore::analysis::CompareOptions options{.layer = layer, .laws = laws};
        options.settings.explore = explore;
        options.settings.verify = verify;
        return analysed(
            run_options(out, threads, seed), "compare",
            [&](auto& session) { return explore::analysis::compare(session, study_, options); },
            explore::report::compare_json);
    }

    py::object sensitivity(const std::vector<std::string>& parameters, double range, int points, int samples,
                           const std::string& out, int threads, std::uint64_t seed) const {
        const explore::analysis::SensitivityOptions options{
            .parameters = parameters, .range = range, .points = points, .samples = samples};
        return analysed(
            run_options(out, threads, seed), "sensitivity",
            [&](auto& session) { return explore::analysis::sensitivity(session, study_, options); },
            explore::report::sensitivity_json);
    }

private:
    const explore::problem::Problem& problem() const {
        if (!problem_) {
            explore::study::make_problem(study_); // says what is missing
            throw py::value_error("the study has no parameters");
        }
        return *problem_;
    }

    template <class T>
    std::vector<T> each(T explore::problem::Axis::*member) const {
        std::vector<T> list;
        for (const auto& axis : study_.space.axes) {
            list.push_back(axis.*member);
        }
        return list;
    }

    Eigen::VectorXd in_units(const std::vector<double>& responses) const {
        Eigen::VectorXd values = array(responses);
        for (Eigen::Index i = 0; i < values.size(); ++i) {
            values[i] /= to_si_[static_cast<std::size_t>(i)];
        }
        return values;
    }

    struct Computed {
        std::vector<double> responses; // SI
        Eigen::MatrixXd jacobian;      // responses x parameters, SI per file unit
    };
    // values: of the parameters, file units; none: the study's own, to the last bit.
    Computed evaluate(const std::optional<Eigen::VectorXd>& values, bool with_jacobian) const {
        if (values && values->size() != static_cast<Eigen::Index>(study_.parameters.size())) {
            throw py::value_error("the study has " + std::to_string(study_.parameters.size()) + " parameters, not " +
                                  std::to_string(values->size()));
        }
        if (!values || !function_) {
            const py::gil_scoped_release release;
            const pave::pavement::ForwardModel model(study_.model);
            const auto by = with_jacobian ? study_.parameters : std::vector<pave::pavement::Parameter>{};
            const auto outcome = model.run(study_.model, by, *model.make_workspace());
            if (!outcome) {
                throw NoAnswer(std::string(to_string(outcome.status())) + ": " + outcome.failure().reason);
            }
            return {outcome->values, outcome->jacobian};
        }
        const py::gil_scoped_release release;
        Borrowed workspace(*this);
        const auto outcome =
            function_->evaluate({values->data(), study_.parameters.size()}, with_jacobian, *workspace.own);
        if (!outcome) {
            throw NoAnswer(std::string(to_string(outcome.status())) + ": " + outcome.failure().reason);
        }
        return {outcome->responses, outcome->jacobian};
    }

    // A workspace for one call: calls may come from several threads.
    struct Borrowed {
        explicit Borrowed(const Study& of) : of(of) {
            const std::scoped_lock lock(of.mutex_);
            if (of.idle_.empty()) {
                own = of.function_->make_workspace();
            } else {
                own = std::move(of.idle_.back());
                of.idle_.pop_back();
            }
        }
        ~Borrowed() {
            const std::scoped_lock lock(of.mutex_);
            of.idle_.push_back(std::move(own));
        }
        Borrowed(const Borrowed&) = delete;
        Borrowed& operator=(const Borrowed&) = delete;
        const Study& of;
        std::unique_ptr<explore::problem::ForwardFunction::Workspace> own;
    };

    explore::study::Study study_;
    std::optional<explore::problem::Problem> problem_;                  // with readings and parameters
    std::shared_ptr<const explore::problem::ForwardFunction> function_; // of the parameters; none: it varies nothing
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<explore::problem::ForwardFunction::Workspace>> idle_;
    std::vector<double> to_si_;
};

// study: a file whose section and parameters are fitted; empty: no back-calculation.
py::object survey(const std::vector<std::string>& files, const std::string& study, const std::string& columns,
                  const std::string& out, int threads, std::uint64_t seed) {
    explore::report::Json json;
    {
        const py::gil_scoped_release release;
        explore::analysis::RoadFiles road = explore::analysis::read_road(files, columns);
        explore::analysis::RunOptions run = run_options(out, threads, seed);
        if (!out.empty()) {
            explore::analysis::refuse_other_road(out, "survey", road);
        }
        run.inputs = std::move(road.inputs);
        explore::analysis::Session session(std::move(run));
        std::optional<explore::study::Study> of;
        if (!study.empty()) {
            of = explore::study::load_survey_study(study);
        }
        const auto result = explore::analysis::survey(session, std::move(road.files), std::move(of), {});
        if (!result) {
            throw std::runtime_error("interrupted");
        }
        json = explore::report::survey_json(*result);
        explore::report::add_run(json, road, session.options());
        session.keep("survey", explore::report::json_text(json));
    }
    return dictionary(json);
}

} // namespace

PYBIND11_MODULE(pavescape, m) {
    explore::run::prepare_blas();
    m.doc() = "Stress-dependent pavement models: forward runs, exact derivatives and fits of the studies of pavescape.";
    m.attr("__version__") = PAVESCAPE_VERSION;
    py::register_exception<NoAnswer>(m, "NoAnswer", PyExc_RuntimeError);
    py::register_exception_translator([](std::exception_ptr p) {
        try {
            std::rethrow_exception(std::move(p));
        } catch (const pave::Error& error) {
            PyErr_SetString(PyExc_ValueError, error.what());
        }
    });
    const char* of_values =
        "values: of the parameters in their order, in the units of the study; None: the study's own.";
    const auto as_command = [](const std::string& name) {
        return "As the command " + name +
               ": its JSON as a dictionary. Raises NoAnswer where there is none. out: the folder of the run, which "
               "continues; empty: nothing is kept.";
    };
    py::class_<Study>(m, "Study", "A study file with its measurements. Raises ValueError for what is wrong in it.")
        .def(
            py::init([](const std::string& file) { return std::make_unique<Study>(explore::study::load_study(file)); }),
            py::arg("file"))
        .def_static(
            "from_text",
            [](const std::string& text, const std::map<std::string, std::string>& files, const std::string& name) {
                return std::make_unique<Study>(explore::study::study_of(text, name, files));
            },
            py::arg("text"), py::arg("files") = std::map<std::string, std::string>{}, py::arg("name") = "study.toml",
            "A study in memory: the text of the study, and the texts of its data files by the names it calls them.")
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
             (std::string("Responses, an array. Raises NoAnswer where the model has none. ") + of_values).c_str())
        .def("jacobian", &Study::jacobian, py::arg("values") = py::none(),
             (std::string("(responses, their derivatives: responses x parameters). ") + of_values).c_str())
        .def("residuals", &Study::residuals, py::arg("values") = py::none(),
             (std::string("Residuals of the study's misfit; its norm is the misfit. ") + of_values).c_str())
        .def("residual_jacobian", &Study::residual_jacobian, py::arg("values") = py::none(),
             (std::string("Derivatives of the residuals: residuals x parameters. ") + of_values).c_str())
        .def("fit", &Study::fit, py::arg("starts") = explore::landscape::MultistartSettings{}.starts,
             py::arg("explore") = explore::analysis::fit_points, py::arg("model") = "full",
             py::arg("joint_only") = false, py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1,
             as_command("fit").c_str())
        .def("map", &Study::map, py::arg("design") = "auto", py::arg("points") = 0, py::arg("model") = "full",
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1,
             (as_command("map") + " With it, as a tuple, the parameters and the misfit of every point.").c_str())
        .def("unique", &Study::unique, py::arg("explore") = explore::landscape::UniquenessSettings{}.explore,
             py::arg("verify") = explore::landscape::UniquenessSettings{}.verify,
             py::arg("searches") = explore::landscape::UniquenessSettings{}.max_searches, py::arg("model") = "full",
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1, as_command("unique").c_str())
        .def("diagnose", &Study::diagnose, py::arg("explore") = explore::diagnose::DiagnosisSettings{}.explore,
             py::arg("starts") = explore::diagnose::DiagnosisSettings{}.starts,
             py::arg("bootstrap") = explore::diagnose::DiagnosisSettings{}.bootstrap,
             py::arg("without") = std::vector<std::string>{}, py::arg("model") = "full", py::arg("out") = "",
             py::arg("threads") = 0, py::arg("seed") = 1, as_command("diagnose").c_str())
        .def("compare", &Study::compare, py::arg("layer") = "", py::arg("laws") = std::vector<std::string>{},
             py::arg("explore") = explore::landscape::UniquenessSettings{}.explore,
             py::arg("verify") = explore::landscape::UniquenessSettings{}.verify, py::arg("out") = "",
             py::arg("threads") = 0, py::arg("seed") = 1, as_command("compare").c_str())
        .def("sample", &Study::sample, py::arg("samples") = explore::analysis::SampleOptions{}.samples,
             py::arg("confirm") = explore::analysis::SampleOptions{}.confirm, py::arg("model") = "",
             py::arg("out") = "", py::arg("threads") = 0, py::arg("seed") = 1,
             (as_command("sample") + " With it, as a tuple, the draws: parameters, outputs and weights.").c_str())
        .def("sensitivity", &Study::sensitivity, py::arg("parameters") = std::vector<std::string>{},
             py::arg("range") = explore::analysis::SensitivityOptions{}.range,
             py::arg("points") = explore::analysis::SensitivityOptions{}.points,
             py::arg("samples") = explore::analysis::SensitivityOptions{}.samples, py::arg("out") = "",
             py::arg("threads") = 0, py::arg("seed") = 1, as_command("sensitivity").c_str());
    m.def("survey", &survey, py::arg("files"), py::arg("study") = "", py::arg("columns") = "", py::arg("out") = "",
          py::arg("threads") = 0, py::arg("seed") = 1,
          (as_command("survey") + " files: of FWD drops; study: of which the parameters are fitted at every station; "
                                  "columns: as --columns.")
              .c_str());
}

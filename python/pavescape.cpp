// The Python module: studies, their forward model and their misfit as functions of NumPy arrays.
#include "landscape/multistart.h"
#include "run/blas.h"
#include "study/study.h"

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

class Study {
public:
    explicit Study(const std::string& file) : study_(explore::study::load_study(file)) {
        if (!study_.parameters.empty()) {
            if (study_.measurements.empty()) {
                function_ = explore::study::make_prediction_problem(study_).function;
            } else {
                problem_ = explore::study::make_problem(study_);
                function_ = problem_->function;
            }
        }
        for (std::size_t i = 0; i < study_.responses(); ++i) {
            to_si_.push_back(study_.response_to_si(i));
        }
    }

    const explore::study::Study& study() const { return study_; }

    std::vector<std::string> parameters() const { return each(&explore::problem::Axis::name); }
    Eigen::VectorXd low() const { return array(each(&explore::problem::Axis::low)); }
    Eigen::VectorXd high() const { return array(each(&explore::problem::Axis::high)); }
    Eigen::VectorXd start() const { return array(each(&explore::problem::Axis::start)); }

    std::vector<py::dict> responses() const {
        std::vector<py::dict> list;
        for (std::size_t i = 0; i < study_.responses(); ++i) {
            const auto& s = study_.model.sensors[i];
            py::dict row;
            row["load"] = study_.model.loads[static_cast<std::size_t>(s.load)].name;
            row["quantity"] = std::string(info(s.quantity).name);
            row["x_mm"] = 1e3 * s.x;
            row["y_mm"] = 1e3 * s.y;
            row["depth_mm"] = 1e3 * s.depth;
            row["gauge_mm"] = 1e3 * s.gauge;
            row["unit"] = std::string(study_.response_unit(i));
            if (i >= study_.measurements.size()) {
                row["name"] = study_.outputs[i - study_.measurements.size()].name;
            }
            list.push_back(std::move(row));
        }
        return list;
    }

    Eigen::VectorXd measured() const {
        Eigen::VectorXd values(static_cast<Eigen::Index>(study_.measurements.size()));
        for (std::size_t i = 0; i < study_.measurements.size(); ++i) {
            const auto& m = study_.measurements[i];
            values[static_cast<Eigen::Index>(i)] = m.value * m.unit.to_si / to_si_[i];
        }
        return values;
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
        return problem().misfit.residuals(evaluate(values, false).responses);
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

    py::dict fit(int starts, int points, int threads, std::uint64_t seed) const {
        const auto problem = explore::study::make_problem(study_, explore::study::Scope::fitted);
        std::optional<explore::landscape::MultistartResult> result;
        {
            const py::gil_scoped_release release;
            explore::run::Engine engine(problem, nullptr, 0, {.threads = threads, .show_progress = false});
            explore::landscape::MultistartSettings settings;
            settings.starts = starts;
            result = explore::landscape::multistart(engine, problem,
                                                    explore::search::sobol(problem.space, points, seed), settings);
        }
        if (!result || result->minima.empty()) {
            throw NoAnswer("not one explored point has an answer");
        }
        py::list minima;
        for (const auto& m : result->minima) {
            py::dict minimum;
            minimum["parameters"] = array(m.evaluation.parameters);
            minimum["misfit"] = m.evaluation.misfit;
            minimum["starts"] = m.members.size();
            minimum["converged"] = m.converged;
            minimum["on_bound"] = m.on_bound;
            minima.append(std::move(minimum));
        }
        py::dict answer;
        answer["parameters"] = array(result->minima[0].evaluation.parameters);
        answer["misfit"] = result->minima[0].evaluation.misfit;
        answer["minima"] = std::move(minima);
        return answer;
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
    py::class_<Study>(m, "Study", "A study file with its measurements. Raises ValueError for what is wrong in it.")
        .def(py::init<const std::string&>(), py::arg("file"))
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
        .def("fit", &Study::fit, py::arg("starts") = 12, py::arg("explore") = 256, py::arg("threads") = 0,
             py::arg("seed") = 1,
             "As the command fit, nothing is kept: {parameters, misfit, minima: [{parameters, misfit, starts, "
             "converged, on_bound}]}, best first.");
}

#include "study.h"

#include "base/text.h"
#include "call.h"
#include "pavement/forward.h"
#include "study/function_study.h"
#include "study/problems.h"

#include <filesystem>
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace python {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd array(const std::vector<double>& values) {
    return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

Study::Study(explore::study::Study study) : study_(std::move(study)) {
    std::shared_ptr<const explore::problem::ForwardFunction> all;
    if (!study_.parameters.empty()) {
        all = explore::study::make_prediction_problem(study_).function;
        if (!study_.measured().empty()) {
            problem_ = explore::study::make_problem(study_, explore::study::Scope::fitted);
            fitted_ = std::make_unique<Callable>(problem_->function, explore::study::computed_loads(study_));
        }
    }
    everything_ = std::make_unique<Callable>(std::move(all), std::vector<bool>{});
    for (const auto& reading : study_.readings) {
        to_si_.push_back(reading.unit.to_si);
    }
}

std::unique_ptr<Study> Study::of_file(const std::string& file) {
    auto study = std::make_unique<Study>(explore::study::load_study(file));
    study->source_ = {.in_memory = false, .name = file, .files = *study->study_.inputs};
    return study;
}

std::unique_ptr<Study> Study::of_text(const std::string& text, const std::map<std::string, std::string>& files,
                                      const std::string& name) {
    auto study = std::make_unique<Study>(explore::study::study_of(text, name, files));
    study->source_ = {.in_memory = true, .name = name};
    study->source_.text = text;
    for (const auto& [file, content] : files) {
        study->source_.files.push_back({file, content});
    }
    return study;
}

std::unique_ptr<Study> Study::of_function(const std::string& text, const std::map<std::string, std::string>& files,
                                          const std::string& name, FunctionOf function) {
    auto study =
        std::make_unique<Study>(explore::study::study_with(make_simulator(std::move(function)), text, name, files));
    std::vector<explore::data::InputFile> inputs{{name, text}}; // that the folder of a run keeps
    for (const auto& [file, content] : files) {
        inputs.push_back({file, content});
    }
    study->study_.inputs = std::make_shared<const std::vector<explore::data::InputFile>>(std::move(inputs));
    study->source_ = {.in_memory = true, .is_function = true, .name = name};
    return study;
}

py::tuple Study::state() const {
    if (source_.is_function) {
        throw py::type_error("a study of a function is copied by whoever has the function");
    }
    py::list files;
    for (const auto& [path, bytes] : source_.files) {
        files.append(py::make_tuple(path, bytes));
    }
    return py::make_tuple(source_.in_memory, source_.name, source_.text, py::tuple(files));
}

std::unique_ptr<Study> Study::of_state(const py::tuple& state) {
    const auto name = state[1].cast<std::string>();
    std::vector<explore::data::InputFile> files;
    for (const auto& item : state[3]) {
        const auto pair = item.cast<std::pair<std::string, std::string>>();
        files.push_back({pair.first, pair.second});
    }
    if (state[0].cast<bool>()) {
        std::map<std::string, std::string> by_name;
        for (auto& [path, bytes] : files) {
            by_name.emplace(std::move(path), std::move(bytes));
        }
        return of_text(state[2].cast<std::string>(), by_name, name);
    }
    // The names that the study calls them by: without its own folder.
    const std::string folder = std::filesystem::path(name).parent_path().string();
    const std::string before = folder.empty() || folder.ends_with('/') ? folder : folder + "/";
    std::map<std::string, std::string> by_name;
    for (std::size_t i = 1; i < files.size(); ++i) {
        const std::string& path = files[i].path;
        by_name.emplace(path.starts_with(before) ? path.substr(before.size()) : path, files[i].bytes);
    }
    explore::study::Study same = explore::study::study_of(files.at(0).bytes, name, by_name);
    same.inputs = std::make_shared<const std::vector<explore::data::InputFile>>(files);
    auto study = std::make_unique<Study>(std::move(same));
    study->source_ = {.in_memory = false, .name = name, .files = std::move(files)};
    return study;
}

std::string Study::words() const {
    const std::size_t readings = study_.measured().size();
    return fmt::format("<pavescape.{} {}: \"{}\", {}, {}, {}>", source_.is_function ? "Problem" : "Study", study_.file,
                       study_.title, pave::counted(study_.parameters.size(), "parameter", "parameters"),
                       pave::counted(readings, "reading", "readings"),
                       pave::counted(study_.readings.size() - readings, "output", "outputs"));
}

std::vector<py::dict> Study::responses() const {
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

VectorXd Study::measured() const {
    std::vector<double> values;
    for (const auto& reading : study_.measured()) {
        values.push_back(reading.value);
    }
    return array(values);
}

VectorXd Study::forward(const Values& values) const {
    return in_units(everything_->at(*this, values, false).responses);
}

std::pair<VectorXd, MatrixXd> Study::jacobian(const Values& values) const {
    const auto found = everything_->at(*this, values, true);
    MatrixXd j = found.jacobian;
    for (Index i = 0; i < j.rows(); ++i) {
        j.row(i) /= to_si_[static_cast<std::size_t>(i)];
    }
    return {in_units(found.responses), j};
}

explore::problem::Evaluation Study::fitted_at(const Values& values, bool with_jacobian) const {
    problem(); // says what is missing
    auto found = fitted_->at(*this, values, with_jacobian);
    explore::problem::Evaluation e;
    e.parameters = values ? std::vector<double>(values->data(), values->data() + values->size())
                          : each(&explore::problem::Axis::start);
    e.responses = std::move(found.responses);
    e.jacobian = std::move(found.jacobian);
    return e;
}

// The derivatives of the residuals by the parameters, not by their unit coordinates.
MatrixXd Study::by_parameters(const explore::problem::Evaluation& e) const {
    MatrixXd j = problem().residual_jacobian(e);
    for (std::size_t k = 0; k < study_.space.axes.size(); ++k) {
        const auto& axis = study_.space.axes[k];
        j.col(static_cast<Index>(k)) /= axis.d_physical(axis.unit(e.parameters[k]));
    }
    return j;
}

VectorXd Study::residuals(const Values& values) const {
    return problem().residuals(fitted_at(values, false));
}

MatrixXd Study::residual_jacobian(const Values& values) const {
    return by_parameters(fitted_at(values, true));
}

std::pair<VectorXd, MatrixXd> Study::residuals_and_jacobian(const Values& values) const {
    const auto e = fitted_at(values, true);
    return {problem().residuals(e), by_parameters(e)};
}

const explore::problem::Problem& Study::problem() const {
    if (!problem_) {
        explore::study::make_problem(study_); // says what is missing
        throw py::value_error("the study has no parameters");
    }
    return *problem_;
}

VectorXd Study::in_units(const std::vector<double>& responses) const {
    VectorXd values = array(responses);
    for (Index i = 0; i < values.size(); ++i) {
        values[i] /= to_si_[static_cast<std::size_t>(i)];
    }
    return values;
}

explore::problem::Prediction Study::Callable::at(const Study& of, const Values& values, bool with_jacobian) const {
    const explore::study::Study& study = of.study_;
    if (values && values->size() != static_cast<Index>(study.parameters.size())) {
        throw py::value_error(fmt::format("values: {} numbers; allowed: one of each of the {} parameters",
                                          values->size(), study.parameters.size()));
    }
    const auto refuse = [](const auto& outcome) {
        throw NoAnswer(std::string(to_string(outcome.status())) + ": " + outcome.failure().reason);
    };
    if (!values && study.has_own_model) {
        return at(of, array(of.each(&explore::problem::Axis::start)), with_jacobian);
    }
    const py::gil_scoped_release release;
    if (!values || !function_) {
        const pave::pavement::ForwardModel model(study.model, loads_);
        const auto by = with_jacobian ? study.parameters : std::vector<pave::pavement::Parameter>{};
        const auto outcome = model.run(study.model, by, *model.make_workspace());
        if (!outcome) {
            refuse(outcome);
        }
        return {outcome->values, outcome->jacobian, outcome->warnings};
    }
    std::unique_ptr<explore::problem::ForwardFunction::Workspace> workspace;
    {
        const std::scoped_lock lock(mutex_);
        if (!idle_.empty()) {
            workspace = std::move(idle_.back());
            idle_.pop_back();
        }
    }
    if (!workspace) {
        workspace = function_->make_workspace();
    }
    auto outcome = function_->evaluate({values->data(), study.parameters.size()}, with_jacobian, *workspace);
    {
        const std::scoped_lock lock(mutex_);
        idle_.push_back(std::move(workspace));
    }
    if (!outcome) {
        refuse(outcome);
    }
    return std::move(outcome).value();
}

} // namespace python

// A study as Python sees it: its forward model and its misfit as functions of arrays.
#pragma once

#include "function.h"
#include "problem/problem.h"
#include "study/study.h"

#include <Eigen/Core>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/pybind11.h>

namespace python {

Eigen::VectorXd array(const std::vector<double>& values);

class Study {
public:
    explicit Study(explore::study::Study study);

    // State that makes the same study again, also where its files are not.
    struct Source {
        bool in_memory = false;
        bool is_function = false;
        std::string name; // of the study: its file, or what messages call it
        std::vector<explore::data::InputFile> files =
            {};                // as it was read, itself first; in memory its data files by name
        std::string text = {}; // in memory
    };
    static std::unique_ptr<Study> of_file(const std::string& file);
    static std::unique_ptr<Study> of_text(const std::string& text, const std::map<std::string, std::string>& files,
                                          const std::string& name);
    // The same with a Python function for its model. It has no state to pickle.
    static std::unique_ptr<Study> of_function(const std::string& text, const std::map<std::string, std::string>& files,
                                              const std::string& name, FunctionOf function);
    pybind11::tuple state() const;
    static std::unique_ptr<Study> of_state(const pybind11::tuple& state);
    std::string words() const; // for repr()

    const explore::study::Study& study() const { return study_; }
    std::vector<std::string> parameters() const { return each(&explore::problem::Axis::name); }
    Eigen::VectorXd low() const { return array(each(&explore::problem::Axis::low)); }
    Eigen::VectorXd high() const { return array(each(&explore::problem::Axis::high)); }
    Eigen::VectorXd start() const { return array(each(&explore::problem::Axis::start)); }
    std::vector<pybind11::dict> responses() const;
    Eigen::VectorXd measured() const;

    using Values =
        std::optional<Eigen::VectorXd>; // of the parameters, file units; none: the study's own, to the last bit
    Eigen::VectorXd forward(const Values& values) const;
    std::pair<Eigen::VectorXd, Eigen::MatrixXd> jacobian(const Values& values) const;
    // Of the study's misfit; they compute the loads that it needs alone.
    Eigen::VectorXd residuals(const Values& values) const;
    Eigen::MatrixXd residual_jacobian(const Values& values) const;
    std::pair<Eigen::VectorXd, Eigen::MatrixXd> residuals_and_jacobian(const Values& values) const;

private:
    template <class T>
    std::vector<T> each(T explore::problem::Axis::*member) const {
        std::vector<T> list;
        for (const auto& axis : study_.space.axes) {
            list.push_back(axis.*member);
        }
        return list;
    }
    const explore::problem::Problem& problem() const;
    Eigen::VectorXd in_units(const std::vector<double>& responses) const;

    // A function of the parameters with workspaces for one call each: calls may come from several threads.
    class Callable {
    public:
        Callable(std::shared_ptr<const explore::problem::ForwardFunction> function, std::vector<bool> loads)
            : function_(std::move(function)),
              loads_(std::move(loads)) {}
        // Without the interpreter's lock. Throws NoAnswer.
        explore::problem::Prediction at(const Study& study, const Values& values, bool with_jacobian) const;

    private:
        std::shared_ptr<const explore::problem::ForwardFunction> function_; // none: the study varies nothing
        std::vector<bool> loads_;                                           // that it computes; empty: all
        mutable std::mutex mutex_;
        mutable std::vector<std::unique_ptr<explore::problem::ForwardFunction::Workspace>> idle_;
    };
    explore::problem::Evaluation fitted_at(const Values& values, bool with_jacobian) const;
    Eigen::MatrixXd by_parameters(const explore::problem::Evaluation& e) const;

    explore::study::Study study_;
    Source source_;
    std::optional<explore::problem::Problem> problem_; // of what is fitted, with readings and parameters
    std::unique_ptr<Callable> everything_, fitted_;    // fitted_: with a problem
    std::vector<double> to_si_;
};

} // namespace python

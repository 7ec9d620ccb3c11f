// A calibration problem: where to look, what to compute, what to compare it with.
#pragma once

#include "problem/forward_function.h"
#include "problem/misfit.h"
#include "problem/parameter_space.h"

#include <limits>

namespace explore::problem {

// One evaluated point. Only `converged` has responses; the misfit of the others, and where there is nothing to compare
// with, is not a number on purpose.
struct Evaluation {
    std::vector<double> parameters; // physical
    pave::Status status = pave::Status::failed;
    std::string reason; // when not converged
    std::vector<double> responses;
    Eigen::MatrixXd jacobian; // responses x parameters, physical; empty unless asked for
    std::vector<std::string> warnings;
    double misfit = std::numeric_limits<double>::quiet_NaN();
    bool in_place_of_reduced = false; // by the full model, where a reduced one could not answer

    bool converged() const { return status == pave::Status::converged; }
};

// The likelihood is the problem's own: whoever wants residuals, their derivatives, degrees of freedom or the noise that
// is assumed asks here. Everything but `function` is cheap.
class Problem {
public:
    Problem(ParameterSpace own_space, std::shared_ptr<const ForwardFunction> own_function, Misfit misfit)
        : space(std::move(own_space)),
          function(std::move(own_function)),
          misfit_(std::move(misfit)) {}

    ParameterSpace space;
    std::shared_ptr<const ForwardFunction> function;

    // unit: a point of the unit cube.
    Evaluation evaluate(std::span<const double> unit, bool with_jacobian, ForwardFunction::Workspace& workspace) const;

    // Readings that are compared: one residual each.
    std::size_t readings() const { return misfit_.size(); }
    // Which response residual i compares.
    std::size_t response_of(std::size_t i) const { return misfit_.terms()[i].response; }
    double measured(std::size_t i) const { return misfit_.terms()[i].measured; } // SI

    // Of a converged evaluation, whoever made it.
    Eigen::VectorXd residuals(const Evaluation& evaluation) const { return misfit_.residuals(evaluation.responses); }
    double misfit(const Evaluation& evaluation) const { return residuals(evaluation).norm(); }
    // Of a problem in units of noise that every reading states: the logarithm of the density of the measured values
    // [SI]; minus infinity without an answer.
    double log_density(const Evaluation& evaluation) const;
    // d(residuals)/d(unit coordinates) of an evaluation with a jacobian.
    Eigen::MatrixXd residual_jacobian(const Evaluation& evaluation) const;

    // Where the stated noise of readings is correlated, residuals are combinations of them that are independent
    // (problem/misfit.h). Of each reading by itself, in the same unit: what to show, and to say of a single reading.
    Eigen::VectorXd single_residuals(const Evaluation& evaluation) const {
        return misfit_.single_residuals(evaluation.responses);
    }
    bool noise_is_correlated() const { return misfit_.is_correlated(); }
    // d(residuals)/d(single residual i), the noise of the others fixed: how an error of that reading alone shows.
    Eigen::VectorXd change_by(std::size_t i) const;
    // The same question where these readings (1 each) have noise of their own, correlated with none: then the residuals
    // of the others say nothing of them.
    Problem setting_apart(const std::vector<char>& readings) const;

    // Readings less the parameters that are free.
    int degrees_of_freedom(std::size_t free) const { return static_cast<int>(readings()) - static_cast<int>(free); }
    // Whether every reading states its noise.
    bool noise_is_stated() const;
    // Standard deviation of every residual by the stated noise, at the value of the model; 0: not stated.
    Eigen::VectorXd noise(const Evaluation& evaluation) const;

    // The same question with these residuals alone.
    Problem with_readings(const std::vector<std::size_t>& residuals) const;
    // The same with every residual in units of its noise and all of one weight, where all state one; else as it is.
    Problem in_units_of_noise() const;

private:
    Misfit misfit_;
};

} // namespace explore::problem

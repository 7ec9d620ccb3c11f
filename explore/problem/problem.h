// A calibration problem: where to look, what to compute, what to compare it with.
#pragma once

#include "problem/forward_function.h"
#include "problem/limit.h"
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
    Eigen::MatrixXd jacobian; // responses x parameters, physical; empty unless requested
    std::vector<std::string> warnings;
    double misfit = std::numeric_limits<double>::quiet_NaN();
    bool in_place_of_reduced = false; // by the full model, where a reduced one could not answer
    bool over_time = false; // a limit of time or the surroundings ended it: another attempt may have an answer

    bool converged() const { return status == pave::Status::converged; }
};

// The likelihood and the priors are the problem's own: whoever wants residuals, their derivatives, degrees of freedom
// or the noise that is assumed asks here. Everything but `function` is cheap.
//
// Rows are what the sum of squares is of: a residual each reading, then the pull of every prior in standard deviations,
// in the order of the axes, then how far each limit is not met (problem/limit.h). With the readings in units of their
// noise the sum is -2 ln(posterior density) but for a constant. Where priors are correlated, their correlation matrix
// R = L L', their rows are L^-1 times the pulls.
class Problem {
public:
    Problem(ParameterSpace own_space, std::shared_ptr<const ForwardFunction> own_function, Misfit misfit)
        : space(std::move(own_space)),
          function(std::move(own_function)),
          misfit_(std::move(misfit)) {}

    ParameterSpace space;
    std::shared_ptr<const ForwardFunction> function;
    std::vector<std::shared_ptr<const Limit>> limits;

    // unit: a point of the unit cube.
    Evaluation evaluate(std::span<const double> unit, bool with_jacobian, ForwardFunction::Workspace& workspace) const;

    // The same at several points, by what computes many at once (ForwardFunction::evaluate_many).
    std::vector<Evaluation> evaluate_many(std::span<const std::vector<double>> units, bool with_jacobian,
                                          ForwardFunction::Workspace& workspace) const;

    // Readings that are compared: one residual each.
    std::size_t readings() const { return misfit_.size(); }
    std::size_t rows() const { return readings() + priors().size() + limits.size(); }
    // Axes with a prior that counts.
    std::vector<std::size_t> priors() const;
    // Which response residual i compares.
    std::size_t response_of(std::size_t i) const { return misfit_.terms()[i].response; }
    double measured(std::size_t i) const { return misfit_.terms()[i].measured; } // SI

    // One a row, of a converged evaluation, whoever made it.
    Eigen::VectorXd residuals(const Evaluation& evaluation) const;
    double misfit(const Evaluation& evaluation) const { return residuals(evaluation).norm(); }
    // Of a problem in units of noise that every reading states: the logarithm of the density of the measured values
    // [SI] times that of the priors over what is uniform in the box; minus infinity without an answer. A size of the
    // noise that is fitted is integrated out. Priors are cut
    // off at the box, each by itself: of correlated ones that reach beyond it the constant is an approximation.
    double log_density(const Evaluation& evaluation) const;
    // d(residuals)/d(unit coordinates) of an evaluation with a jacobian; rows x parameters.
    Eigen::MatrixXd residual_jacobian(const Evaluation& evaluation) const;
    // The same of what a reading tells on average: its product with its transpose is Fisher's information, in units of
    // noise. Differs from the above for Student's noise alone, where the derivatives of single rows depend on their
    // residuals. For errors of parameters, ranks and shares; not for steps.
    Eigen::MatrixXd information_jacobian(const Evaluation& evaluation) const;

    // Where the stated noise of readings is correlated, residuals are combinations of them that are independent
    // (problem/misfit.h). Of each reading by itself, in the same unit: what to show, and to say of a single reading.
    Eigen::VectorXd single_residuals(const Evaluation& evaluation) const {
        return misfit_.single_residuals(evaluation.responses);
    }
    // Of what each sensor has drifted by (problem/misfit.h).
    std::vector<Misfit::Drift> drifts(const Evaluation& evaluation) const {
        return misfit_.drifts(evaluation.responses);
    }
    bool noise_is_correlated() const { return misfit_.is_correlated(); }
    // Whether their noise is of Student's t distribution; then with how many degrees of freedom, else 0.
    bool noise_is_student() const { return misfit_.is_student(); }
    double noise_degrees() const { return noise_is_student() ? misfit_.terms()[0].noise.degrees : 0.0; }
    // One each reading: independent, in standard deviations (Student's: scales) of the noise, whatever the weights.
    Eigen::VectorXd standard_residuals(const Evaluation& evaluation) const {
        return misfit_.standard_residuals(evaluation.responses);
    }
    // d(residuals)/d(single residual i), a value each row, the noise of the others fixed: how an error of that reading
    // alone shows.
    Eigen::VectorXd change_by(std::size_t i) const;
    // d(residuals)/d(ln of the model's value of reading i): how a gain of that sensor shows.
    Eigen::VectorXd change_by_gain(std::size_t i, const Evaluation& evaluation) const;
    // The same question where these rows (1 each; a prior's means nothing) have noise of their own, correlated with
    // none: then the residuals of the others say nothing of them.
    Problem setting_apart(const std::vector<char>& readings) const;

    // Of them, how many are limits (data::Censored).
    std::size_t censored() const { return misfit_.censored(); }
    // Readings and priors less the parameters that are free. A limit is no degree of freedom: a model that keeps it
    // adds next to nothing to the sum of squares, and one on it 1.4, so the test of that sum finds a wrong model a
    // little too soon rather than too late.
    int degrees_of_freedom(std::size_t free) const {
        return static_cast<int>(readings() - censored() + priors().size()) - static_cast<int>(free);
    }
    // Whether every reading states its noise, and its size is not sought.
    bool noise_is_stated() const;
    // Whether it is known but for its size (problem/noise_scale.h).
    bool noise_scale_is_sought() const;
    // That size where the likelihood has the slope of normal noise here; 1 where it is not sought.
    double noise_scale(const Evaluation& evaluation) const;
    // Which limits hold back here: equalities, and those within ten tolerances of it.
    std::vector<std::size_t> active_limits(const Evaluation& evaluation) const;
    // Which limits are not met here, by more than a penalty gives way to readings: a hundred tolerances.
    std::vector<std::size_t> broken_limits(const Evaluation& evaluation) const;
    // How far beyond each limit that is no equality, below 0 within it, and d(that)/d(unit coordinates).
    Eigen::VectorXd beyond_limits(const Evaluation& evaluation) const;
    Eigen::MatrixXd limit_jacobian(const Evaluation& evaluation) const;
    std::vector<Eigen::Index> limit_rows() const; // of those

    // Standard deviation of every row by the stated noise, at the value of the model; 0: not stated.
    Eigen::VectorXd noise(const Evaluation& evaluation) const;

    // The rows that standard normal deviates, one a row, make where the model is right here and every reading errs by
    // that many of its standard deviations: what noise is like as it is stated. A residual is on the scale on which
    // that has one variance everywhere, so of a large relative part it is skew. Correlated or Student's noise, and the
    // rows of priors: the deviates themselves.
    Eigen::VectorXd noise_rows(const Evaluation& evaluation, Eigen::VectorXd deviates) const;
    // The same question without what is known beforehand.
    Problem without_priors() const;
    // The same question without priors and limits.
    Problem of_readings() const;
    // The same question with these readings alone, and without priors.
    Problem with_readings(const std::vector<std::size_t>& residuals) const;
    // The same with every residual in units of its noise and all of one weight, where all state one; else as it is.
    Problem in_units_of_noise() const;

private:
    Evaluation evaluation_of(std::vector<double> parameters, pave::Outcome<Prediction> outcome) const;
    Problem with_misfit(Misfit misfit) const;
    // loss: of each reading, what its whitened derivative is multiplied by.
    Eigen::MatrixXd rows_by_unit(const Evaluation& evaluation, const Eigen::VectorXd& loss) const;
    Eigen::RowVectorXd limit_gradient(const Limit& limit, const Evaluation& evaluation) const;

    Misfit misfit_;
    bool with_priors_ = true;
};

} // namespace explore::problem

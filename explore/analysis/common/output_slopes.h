// The outputs to first order around points of a model, and their ranges if the model is right.
#pragma once

#include "diagnose/model_average.h"
#include "landscape/minima.h"
#include "study/problems.h"

#include <optional>

namespace explore::analysis {

// Slopes of the outputs at a point. e: the evaluation there, with jacobian; outputs: which responses they are; noise:
// standard deviation of a residual. None where the point has no answer.
std::optional<diagnose::Slopes> slopes_of(const problem::Problem& problem, const Eigen::VectorXd& at,
                                          const problem::Evaluation& e, const std::vector<std::size_t>& outputs,
                                          double noise);

// The model as it is gives way no further beyond a bound.
void hold_bounds(diagnose::Slopes& slopes, const std::vector<double>& unit);

// By how much the mesh is off in ln|output|, by Richardson's extrapolation from a finer one (second order), with what
// parameters would move by, fitted on it (to first order); 0 where there is none. best: what `right` is of.
Eigen::VectorXd mesh_errors(const study::Study& study, const problem::Problem& plain, const diagnose::Slopes& right,
                            const problem::Evaluation& best, const std::vector<std::size_t>& outputs, double noise);

// The outputs if the model is right, at its best point and at other minima of the fit that are as good.
struct Right {
    std::vector<diagnose::Said> said;
    std::vector<Eigen::VectorXd> values; // of the outputs there
};
Right right_at(const problem::Problem& plain, const diagnose::Said& here, const problem::Evaluation& best,
               const std::vector<std::vector<double>>& others, const std::vector<std::size_t>& outputs, double noise);

// On a bound the model gives way to one side, which Said leaves out: 95 % of an output with that. unbounded: slopes at
// the point without hold_bounds().
class RangeAtBound {
public:
    RangeAtBound(const problem::Problem& plain, const diagnose::Slopes& unbounded, const problem::Evaluation& best,
                 double noise);
    // value: of the output; mesh: error of ln|output|. Nothing: no bound changes it.
    std::optional<std::pair<double, double>> of(Eigen::Index output, double value, double mesh) const;

private:
    const problem::Problem& plain_;
    const diagnose::Slopes& slopes_;
    landscape::Minimum there_;
    std::optional<landscape::LocalAnalysis> local_; // nothing: no bound is met
};

// 95 % of an output over all minima, by how probable each is; mesh: error of ln|output|. Where its sign is another at a
// minimum, that minimum's own range is added.
std::pair<double, double> range_if_right(const Right& right, Eigen::Index output, double mesh, double tail);

} // namespace explore::analysis

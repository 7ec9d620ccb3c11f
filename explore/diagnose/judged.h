// A fitted model and what the data say of it.
#pragma once

#include "diagnose/residual_tests.h"
#include "hypotheses/evidence.h"

namespace explore::diagnose {

struct Interval {
    double value = 0.0, low = 0.0, high = 0.0; // physical
};
// 95 % interval of a parameter within its range. unit, variance: its unit coordinate and the variance of that.
Interval interval_within(const problem::Axis& axis, double unit, double variance);
struct Judged {
    Model model;
    double chi2 = 0.0;
    int dof = 0;          // readings - directions that the parameters can follow
    double p_value = 1.0; // of chi2; 1 without stated noise
    double aicc = 0.0;
    PatternTest pattern;
    hypotheses::Evidence evidence;
    std::vector<Interval> sizes; // of the members that are effects
    bool at_end = false;         // the interval of one reaches the end of its range

    // Whether the size of this member, or of any, is where its range ends.
    bool ends_range(std::size_t member) const;
    bool ends_range() const;
};

// Akaike's criterion, up to a constant of the data. sum: of the squared residuals. In units of their noise where it is
// stated: chi2 + 2 k, for the optimism of chi2 is then 2 k exactly (Akaike 1973). Else the noise counts as one more
// parameter, with the correction for few data (Hurvich and Tsai 1989), infinite where the parameters are too many for
// it.
double aicc(double sum, std::size_t readings, std::size_t parameters, bool noise_is_stated);

// Of the unit coordinates of a fitted model, to first order. variance: of a residual.
Eigen::MatrixXd covariance_of(const problem::Problem& problem, const Model& model, double variance);
// The interval of one of them.
Interval interval_of(const problem::Problem& problem, const Model& model, std::size_t axis, double variance);

// The likelihood of a model with effects. variance: of a residual; noise_is_stated: residuals are in units of it.
class Judge {
public:
    Judge(Workbench& bench, const std::vector<Candidate>& candidates, const std::vector<ReadingGroup>& groups)
        : bench_(bench),
          candidates_(candidates),
          groups_(groups),
          noise_is_stated_(bench.problem({})->noise_is_stated()),
          limits_(bench.problem({})->censored()) {}

    Judged judge(Model model, double variance) const;
    inference::Nuisance nuisance_of(const Model& model, double variance) const;
    bool noise_is_stated() const { return noise_is_stated_; }
    // Residuals that are draws of the noise.
    std::size_t drawn(const Model& model) const { return static_cast<std::size_t>(model.residuals.size()) - limits_; }
    hypotheses::NoisePrior noise_prior() const {
        return noise_is_stated_ ? hypotheses::NoisePrior{} : hypotheses::any_noise();
    }

private:
    Workbench& bench_;
    const std::vector<Candidate>& candidates_;
    const std::vector<ReadingGroup>& groups_;
    bool noise_is_stated_;
    std::size_t limits_; // readings that are no draws of the noise
};

} // namespace explore::diagnose

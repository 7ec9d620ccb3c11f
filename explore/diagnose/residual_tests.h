// Tests of the residuals of a fit that know nothing of causes.
#pragma once

#include "diagnose/screening.h"

namespace explore::diagnose {

// Readings of one quantity under one load.
struct ReadingGroup {
    std::string name;
    std::vector<std::size_t> terms; // of the misfit, by position: offset, then depth
};

struct GroupTest {
    double chi2 = 0.0; // sum of squares in units of the noise
    double mean = 0.0; // of the residuals, in standard deviations of one
    // Two-sided; 1 where there are too few readings to tell.
    double p_sign = 1.0; // as many above as below: binomial
    double p_runs = 1.0; // signs in random order along the position: Wald and Wolfowitz (1940), exact
};
GroupTest test_group(const Eigen::VectorXd& residuals, const ReadingGroup& group);

// Smooth patterns: the mean and the trend along the position of every group, as far as no parameter follows them.
struct PatternTest {
    double chi2 = 0.0;
    int dof = 0;
    double p_value = 1.0;
};
PatternTest test_pattern(const Eigen::VectorXd& residuals, const inference::Nuisance& nuisance,
                         const std::vector<ReadingGroup>& groups);

// Does one group of readings want another value of a parameter than the others? To first order at the fit.
struct Constancy {
    std::size_t axis = 0, group = 0;
    double shift = 0.0; // wanted in that group, unit coordinates
    double score = 0.0; // in its standard errors
};
// Every parameter and group, the largest |score| first. With one group there is nothing to compare.
std::vector<Constancy> test_constancy(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals,
                                      const inference::Nuisance& nuisance, const std::vector<ReadingGroup>& groups);

} // namespace explore::diagnose

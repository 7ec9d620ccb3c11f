#include "diagnose/residual_tests.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_sf_gamma.h>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

double choose(int n, int k) {
    return k < 0 || k > n ? 0.0 : gsl_sf_choose(static_cast<unsigned>(n), static_cast<unsigned>(k));
}

// Probability of exactly `runs` runs in a random order of a and b signs.
double runs_probability(int runs, int a, int b) {
    const int half = runs / 2;
    const double ways =
        runs % 2 == 0 ? 2.0 * choose(a - 1, half - 1) * choose(b - 1, half - 1)
                      : choose(a - 1, half) * choose(b - 1, half - 1) + choose(a - 1, half - 1) * choose(b - 1, half);
    return ways / choose(a + b, a);
}

} // namespace

GroupTest test_group(const VectorXd& residuals, const ReadingGroup& group) {
    GroupTest test;
    int above = 0;
    int runs = 0;
    bool last = false;
    for (std::size_t i = 0; i < group.terms.size(); ++i) {
        const double r = residuals[static_cast<Index>(group.terms[i])];
        test.chi2 += r * r;
        test.mean += r / static_cast<double>(group.terms.size());
        above += r > 0.0 ? 1 : 0;
        runs += i == 0 || (r > 0.0) != last ? 1 : 0;
        last = r > 0.0;
    }
    const int n = static_cast<int>(group.terms.size());
    const int below = n - above;
    constexpr int few = 4;
    if (n < few) {
        return test;
    }
    const auto fewer = static_cast<unsigned>(std::min(above, below));
    test.p_sign = std::min(1.0, 2.0 * gsl_cdf_binomial_P(fewer, 0.5, static_cast<unsigned>(n)));
    if (above > 0 && below > 0) {
        double at_most = 0.0;
        double at_least = 0.0;
        for (int r = 2; r <= n; ++r) {
            const double p = runs_probability(r, above, below);
            at_most += r <= runs ? p : 0.0;
            at_least += r >= runs ? p : 0.0;
        }
        test.p_runs = std::min(1.0, 2.0 * std::min(at_most, at_least));
    }
    return test;
}

PatternTest test_pattern(const VectorXd& residuals, const inference::Nuisance& nuisance,
                         const std::vector<ReadingGroup>& groups) {
    std::vector<VectorXd> patterns;
    for (const ReadingGroup& group : groups) {
        const auto n = static_cast<double>(group.terms.size());
        constexpr int degrees = 3; // mean, trend, bend
        for (int degree = 0; degree < degrees && degree + 2 < static_cast<int>(group.terms.size()); ++degree) {
            VectorXd pattern = VectorXd::Zero(residuals.size());
            for (std::size_t i = 0; i < group.terms.size(); ++i) {
                const double x = (2.0 * static_cast<double>(i) + 1.0) / n - 1.0;
                pattern[static_cast<Index>(group.terms[i])] = std::pow(x, degree);
            }
            patterns.push_back(nuisance.beyond(pattern / pattern.norm()));
        }
    }
    PatternTest test;
    if (patterns.empty()) {
        return test;
    }
    MatrixXd all(residuals.size(), static_cast<Index>(patterns.size()));
    for (std::size_t j = 0; j < patterns.size(); ++j) {
        all.col(static_cast<Index>(j)) = patterns[j];
    }
    constexpr double left = 0.1; // of a pattern's length: the parameters do not follow it
    const Eigen::JacobiSVD<MatrixXd> svd(all, Eigen::ComputeThinU);
    test.dof = static_cast<int>((svd.singularValues().array() > left).count());
    test.chi2 = (svd.matrixU().leftCols(test.dof).transpose() * residuals).squaredNorm();
    test.p_value = test.dof > 0 ? gsl_cdf_chisq_Q(test.chi2, test.dof) : 1.0;
    return test;
}

std::vector<Constancy> test_constancy(const MatrixXd& jacobian, const VectorXd& residuals,
                                      const inference::Nuisance& nuisance, const std::vector<ReadingGroup>& groups) {
    std::vector<Constancy> tests;
    for (std::size_t g = 0; groups.size() > 1 && g < groups.size(); ++g) {
        for (Index k = 0; k < jacobian.cols(); ++k) {
            VectorXd own = VectorXd::Zero(residuals.size());
            for (const std::size_t i : groups[g].terms) {
                own[static_cast<Index>(i)] = jacobian(static_cast<Index>(i), k);
            }
            const VectorXd change = nuisance.beyond(own);
            constexpr double seen = 1.0; // standard deviations, crossing the box
            if (change.norm() > seen) {
                const double score = -change.dot(residuals) / change.norm();
                tests.push_back({static_cast<std::size_t>(k), g, score / change.norm(), score});
            }
        }
    }
    std::stable_sort(tests.begin(), tests.end(),
                     [](const auto& a, const auto& b) { return std::abs(a.score) > std::abs(b.score); });
    return tests;
}

} // namespace explore::diagnose

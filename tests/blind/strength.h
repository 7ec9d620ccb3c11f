// How strongly what is hidden shows in the data: in standard deviations of their errors, beyond what the parameters
// that will be fitted can follow.
#pragma once

#include "blind/hidden.h"

#include <optional>

namespace blind {

struct Fitted {
    std::string path;
    double low, high;
    bool is_log;
};
inline const Fitted fitted[] = {{"asphalt.modulus_MPa", 500, 15000, true},
                                {"base.k1", 300, 8000, true},
                                {"base.k2", 0.05, 1.0, false},
                                {"base.n", 0.1, 1.0, false},
                                {"subgrade.modulus_MPa", 10, 250, true}};

// Errors of readings: their covariance is root root', root a lower triangle.
struct Errors {
    Eigen::MatrixXd root;

    Eigen::Index size() const { return root.rows(); }
    // Independent combinations, in standard deviations.
    VectorXd in_units(const VectorXd& change) const { return root.triangularView<Eigen::Lower>().solve(change); }
};

// Of repeated drops (docs/evidence/ranges.md): own errors are correlated over this distance between readings of one
// load and quantity, and all readings of a load have one in common, this share of the relative one.
inline constexpr double correlated_mm = 600.0;
inline constexpr double in_common = 0.6;

// own: standard deviations; common: of the error in common, a reading each; zero where errors are independent.
Errors errors_of(const Case& c, const VectorXd& own, const VectorXd& common);
// Of the responses, in standard deviations, by the logarithms of the fitted parameters: central differences. Empty:
// none.
Eigen::MatrixXd derivatives(const Case& c, const Errors& errors);
// Orthonormal base of what these columns span: what the fitted parameters can follow.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns);
VectorXd beyond(const Eigen::MatrixXd& base, const VectorXd& change);
// How far what is hidden remains from what the fitted parameters can follow, at their best: standard deviations.
// Gauss and Newton's steps in the logarithms, differences for derivatives. plain: without what is hidden.
double remaining(const Case& c, const VectorXd& plain, const VectorXd& change, const Errors& errors);
// The best possible rate of telling what is hidden, of strength d, from every other effect, and the one that is
// hardest.
void add_ceiling(Json& truth, const Case& c, const Hidden& hidden, const VectorXd& change, double d,
                 const Eigen::MatrixXd& base, const Errors& errors);

struct Strength {
    double least = 8.0, most = 20.0; // standard deviations
};

// A size whose change, beyond what the parameters and `others` can follow, has the strength wanted; nothing: there is
// none within the effect's range.
std::optional<Hidden> sized(Draw& draw, const Case& c, Hidden hidden, const VectorXd& plain,
                            const Eigen::MatrixXd& base, const Errors& errors, double wanted);

} // namespace blind

// Where local searches ended, grouped into distinct minima.
#pragma once

#include "run/engine.h"

#include <optional>

namespace explore::landscape {

// A parameter of the best point that lies on a bound of its range.
struct BoundMet {
    std::size_t axis = 0;
    bool upper = false;
    bool operator==(const BoundMet&) const = default;
};
std::vector<BoundMet> bounds_met(const std::vector<double>& unit);
bool is_at_bound(double unit);
// Derivatives by unit coordinates, a column each, with 0 for parameters on a bound, which give way no further.
Eigen::MatrixXd off_bounds(Eigen::MatrixXd derivatives, const std::vector<BoundMet>& bounds);
// Which directions (columns) the rows see: those along which some row changes by more than the accuracy of its own
// derivatives, however large other rows are.
std::vector<char> seen(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& directions);
// Orthonormal columns: what of the residuals parameters off their bounds follow.
Eigen::MatrixXd followed_by(const Eigen::MatrixXd& jacobian, const std::vector<BoundMet>& bounds);
// "base.n at its upper bound"
std::string bound_words(const problem::ParameterSpace& space, const BoundMet& bound);
std::vector<std::string> bound_words(const problem::ParameterSpace& space, const std::vector<BoundMet>& bounds);

// A second method's result at a minimum (landscape/confirmation.h).
struct Confirmation {
    std::string_view method;
    bool agrees = false;        // it found nothing lower that the noise tells apart, or hardly moved
    bool has_ended = false;     // by a criterion of its own: only then does it confirm anything
    double misfit_before = 0.0; // where the first method ended
    int evaluations = 0;
    std::string ended; // in words
};

struct Minimum {
    problem::Evaluation evaluation; // of the best member, with jacobian
    std::vector<double> unit;       // its unit coordinates
    std::vector<int> members{};     // numbers of the starts that ended here, best first
    std::vector<BoundMet> on_bound{};
    std::vector<double> lowest{}, highest{}; // of each parameter over the members, physical
    bool converged = false;                  // the search of the best member met a tolerance
    std::optional<Confirmation> second{};    // nothing: no second method was used
    // Where the readings lead from here by themselves, with jacobian (landscape/readings_alone.h); nothing: neither a
    // prior nor a constraint holds the answer.
    std::optional<problem::Evaluation> alone{};
};

// A point as a minimum, with where it lies on bounds; evaluation: there, with jacobian.
Minimum minimum_at(problem::Evaluation evaluation, std::vector<double> unit);

// Whether two ends are one minimum by themselves: they lie within 1 % of the box of each other, or the misfit tells
// them apart by less than its own noise: they fit alike (the misfit differs by less than a tenth of one noise level,
// the residuals by less than one), and so do the linearised residuals between them. The noise is the stated one;
// without, s with s2 = f^2 / (data - parameters) of the lower of the two, but no less than a change of every reading by
// 1e-5 of it: below that no misfit tells anything, and where parameters remain all such ends are one. by_noise:
// residuals in units of it, where it is stated; lower: the end with the lower misfit.
bool fit_alike(const run::Endpoint& lower, const run::Endpoint& other, const problem::Problem& by_noise);
bool are_one_minimum(const run::Endpoint& lower, const run::Endpoint& other, const problem::Problem& by_noise);

// Ends that are one minimum with the next, one after the other, are one: a flat valley is one minimum whose members
// spread. Sorted by misfit. Ends that break a constraint are none. An end whose search was ended early is no minimum:
// it belongs to one that it is one with; the lowest of all is listed whether it converged or not. The lowest end stands
// for a minimum; of those that are lower by nothing that counts (1e-4 of chi2) one with fewest parameters on bounds.
std::vector<Minimum> distinct_minima(const std::vector<run::Endpoint>& ends, const problem::Problem& problem);

// Stated noise whose chi2 is less probable than this does not explain the misfit: it is then taken larger.
inline constexpr double contradicted = 0.01;

// Residuals around a minimum, to first order.
struct LocalAnalysis {
    int degrees_of_freedom = 0; // data - parameters that are off their bounds
    // Standard deviation of a residual: the root mean square of what the readings state; else estimated from the
    // residuals, 0 without degrees of freedom.
    double noise = 0.0;
    bool noise_is_stated = false;
    double chi2 = 0.0;          // by the stated noise; of Student's the sum of its rows (problem/student.h)
    double expected_chi2 = 0.0; // by the noise: the degrees of freedom, of Student's by simulation (goodness.h)
    double p_value = 1.0;       // of it
    // The stated noise is contradicted: all of it is taken larger, so that it explains the misfit.
    bool widened = false;
    double widening = 1.0; // factor of the noise, and of the ranges
    // Of each parameter in unit coordinates; infinity: not determined. J^+ W J^+^T for the inverse J^+ of the jacobian
    // and the variances W of the residuals (the least squares estimator's, whatever its weights). Parameters on a bound
    // count as unknown like the others; inequalities tell nothing here (held_ranges.h).
    std::vector<double> standard_error;
    // A 95 % range of half of what the study allows leaves the parameter about as unknown as it was.
    static constexpr double undetermined = 0.5;
    // A bound that the readings contradict is no knowledge.
    bool bounds_count() const { return p_value >= contradicted; }
    bool determines(std::size_t parameter) const { return 2.0 * quantile() * standard_error[parameter] < undetermined; }
    // |root d + rest|^2 is, but for a constant, how far a move d of the unit coordinates lies from what the readings
    // say, in units of their noise: root' root is the inverse of that covariance. Empty: no noise is known.
    Eigen::MatrixXd root{};
    Eigen::VectorXd rest{};
    // Half of a 95 % range over a standard error: of Student's t where the noise is that of the residuals.
    double quantile() const;
    // Direction of the unit cube in which the misfit grows least, and how much the residual norm grows when moving
    // by a tenth of the box along it.
    std::vector<double> weakest;
    double weakest_growth = 0.0;
    double strongest_growth = 0.0;
    Eigen::VectorXd leverage{}; // of each residual: the share of it that parameters off their bounds follow (diagonal
                                // of the hat matrix)
};
// noise_factor: how many times larger than stated the noise is at least, by what else is known of it.
LocalAnalysis analyse(const Minimum& minimum, const problem::Problem& problem, double noise_factor = 1.0);

} // namespace explore::landscape

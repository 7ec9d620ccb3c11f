// Local searches in the unit cube, by NLopt and our own, behind one interface.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace explore::optimise {

// A method that a user may name.
struct Method {
    std::string_view name;
    bool uses_gradient;
    std::string_view summary;
};
std::span<const Method> methods();
const Method* find_method(std::string_view name);

// The search's request at a point: the residuals (the search minimises half the sum of their squares) and, for a
// method with gradients, their derivatives by the unit coordinates.
struct Sample {
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
    // Of residuals that are max(0, limit), and among those above: the limit itself and its derivatives, so that a
    // search sees one that it is not beyond, and which residual it is. May be empty.
    Eigen::VectorXd limits{};
    Eigen::MatrixXd limit_jacobian{};
    std::vector<Eigen::Index> limit_rows{};
    bool wants_derivatives = true; // requested of the objective; where not, the jacobian may stay empty
};
enum class Answer { computed, no_answer, stop };
// Fills the sample. no_answer: the point cannot be computed; the search is led away from it and never sees NaN.
// stop: end the search now. Must not throw.
using Objective = std::function<Answer(std::span<const double> unit, Sample& sample)>;

// A first step as long as it likes.
inline constexpr double whole_cube = std::numeric_limits<double>::infinity();

struct SearchSettings {
    int max_evaluations = 80;
    double step_tolerance = 1e-5;   // of every unit coordinate
    double misfit_tolerance = 1e-7; // relative change of the sum of squares
    // Gauss-Newton alone: change of half the sum of squares that does not matter, and the length of the first step at
    // most (the whole cube for a start that is close).
    double enough = 0.0;
    double first_step = 0.3;
    // Of searches over blocks alone (arrow_gauss_newton.h): the first damping as a share of the largest diagonal term
    // of the normal matrix.
    double damping = 1e-3;
    // Gauss-Newton alone: where half the sum of squares is predicted to fall by less, no derivatives are requested;
    // those of the point before then serve, with Broyden's correction (1965) along the step.
    double secant_below = 0.0;
    // Gauss-Newton alone: half of a sum of squares; the search ends where at two points after each other linear theory
    // promises less than half of the fall that is needed to get there.
    double worth = std::numeric_limits<double>::infinity();
    // SLSQP alone: it moves in coordinates z with unit = start + metric z; empty: in those of the cube. Columns: moves
    // that change the residuals by about as much as is of interest.
    Eigen::MatrixXd metric{};
};

struct SearchResult {
    std::vector<double> unit; // the best point computed
    double misfit = 0.0;      // its root of the sum of squares
    int evaluations = 0;
    bool converged = false; // by one of the tolerances; not where it got no further though derivatives promise it
    bool stopped = false;   // by the objective
    std::string ended;      // in words
};

// start must be a point with an answer, else the result has an empty point.
SearchResult local_search(const Method& method, const std::vector<double>& start, const Objective& objective,
                          const SearchSettings& settings);

} // namespace explore::optimise

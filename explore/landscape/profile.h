// Walks over the landscape that keep one quantity where they want it and let everything else give way: profiles of
// parameters and predictions, the floor of a valley, the pass between two minima.
#pragma once

#include "landscape/acceptance.h"

namespace explore::landscape {

// A scalar of the parameters. Gradients are by the unit coordinates.
struct Quantity {
    std::function<double(const std::vector<double>& unit, const problem::Evaluation&)> value;
    std::function<Eigen::VectorXd(const std::vector<double>& unit, const problem::Evaluation&)> gradient;
};
Quantity coordinate(std::size_t axis);                                      // the unit coordinate itself
Quantity response(const problem::ParameterSpace& space, std::size_t index); // SI
Quantity along(const Eigen::VectorXd& direction);                           // direction . unit

struct ProfilePoint {
    double value = 0.0; // of the quantity
    double rise = 0.0;  // of chi2 above the minimum
    double slope = 0.0; // of the lowest rise by the quantity there; 0 where it is not known
    std::vector<double> unit;
    problem::Evaluation evaluation; // with jacobian
};

enum class WalkEnd {
    threshold, // chi2 has risen by it, or would rise by more at once
    bound,     // of the box: the quantity itself, or every parameter that could move it, lies on one
    hole,      // no point beyond has an answer
    better,    // a lower misfit than that of the minimum was found
    limit      // of steps
};

// One side of a profile: for each value of the quantity the lowest misfit it allows.
struct Branch {
    std::vector<ProfilePoint> points; // outwards; the minimum is not among them
    WalkEnd end = WalkEnd::limit;
    double limit = 0.0;                // value of the quantity where the walk ended, of the last point accepted
    std::vector<double> limit_unit;    // that point: computed; at `threshold` chi2 has risen by it, to a thousandth
    std::vector<BoundMet> on_bound;    // parameters on a bound there
    std::vector<std::size_t> on_limit; // limits of the problem that hold back there
};

// Walks from the minimum, up (sign = 1) or down (-1), in steps that raise sqrt(chi2) by about half of the threshold's.
// Every point minimises |r|^2 + (w (q - target))^2: whatever value q it ends with, no other point of the box near it
// with that value fits better, so w need not be large.
// Rises of chi2 are above best_misfit, that of `from` or of a lower minimum.
Branch walk(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance, const Minimum& from,
            double best_misfit, const Quantity& quantity, int sign);

// Along the direction in which the misfit grows least, turning with it: predictor steps, then the lowest point across
// the step. A parameter that meets a bound stays there while the others go on. Ends where chi2 has risen by the
// threshold or where nothing is left that could go on. A point's value is its distance along the way (unit cube).
Branch trace_valley(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance,
                    const Minimum& from, const Eigen::VectorXd& direction);

// The lowest way found from one minimum towards another: the lowest misfit on planes across the line that joins them,
// each reached from the one before. Values run from 0 at `from` to 1 at `to`.
std::vector<ProfilePoint> approach(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance,
                                   const Minimum& from, const Minimum& to, double best_misfit);

// A way over from one minimum to the other by the planes of two approaches, changing from one to the other where that
// is lowest, and the largest rise of chi2 on it: the pass is no higher than that. infinity: there is a hole on every
// way.
struct Pass {
    double rise = 0.0;
    std::vector<ProfilePoint> way;
};
Pass pass_between(run::Chain& chain, const Acceptance& acceptance, const std::vector<ProfilePoint>& forth,
                  const std::vector<ProfilePoint>& back, double best_misfit);

} // namespace explore::landscape

// The steps that walks are made of. Private to landscape/.
#pragma once

#include "landscape/profile.h"
#include "optimise/linear_reach.h"

#include <cmath>
#include <optional>

namespace explore::landscape {

// Rise of chi2 that no verdict depends on, and a gain that means that a better minimum was found.
inline constexpr double negligible_rise = 0.01;
inline constexpr double better_by = 0.1;

// A point of the unit cube moved, and held in it.
std::vector<double> clamped(const std::vector<double>& unit, const Eigen::VectorXd& move);
Eigen::VectorXd vector_of(const std::vector<double>& unit);

inline double root(double rise) {
    return std::sqrt(std::max(0.0, rise));
}

// J'J in units of the noise, and one more on the diagonal: a direction that the data do not see costs something, so
// that a move along it stays finite.
Eigen::MatrixXd information(const problem::Problem& problem, const Acceptance& acceptance, const ProfilePoint& at);

// Moves of the unit cube that change the quantity by `change` and raise the misfit least, to first order. Parameters on
// a bound that they would leave the box by stay there.
Eigen::VectorXd cheapest_move(const Eigen::MatrixXd& h, const Eigen::VectorXd& gradient,
                              const std::vector<double>& unit, double change);

// The problem about a point as linear functions of moves, in units of the noise: no more than `longest` in any unit
// coordinate, within the cube and the limits. A direction that the data do not see costs something, as above.
class Surroundings {
public:
    Surroundings(const problem::Problem& problem, const Acceptance& acceptance, const ProfilePoint& at,
                 const Eigen::VectorXd& gradient, double longest);

    // The move that changes the quantity by that and raises chi2 least; by less, if there is no more room.
    optimise::LinearReach::Move to(double change) const { return reach_.to(change, here_); }
    // The farthest that raises chi2 by no more than `rise`.
    optimise::LinearReach::Move until(int sign, double rise) const { return reach_.until(sign, rise, here_); }

private:
    optimise::Sample rows_;
    Eigen::VectorXd low_, high_;
    double here_; // chi2
    optimise::LinearReach reach_;
};

class Walker {
public:
    Walker(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance, double best_misfit)
        : chain_(chain),
          problem_(problem),
          acceptance_(acceptance),
          best_misfit_(best_misfit) {}

    ProfilePoint point(std::vector<double> unit, problem::Evaluation evaluation, const Quantity& quantity) const;
    // Of chi2 along a unit vector, by unit coordinates.
    double slope(const problem::Evaluation& at, const Eigen::VectorXd& along) const;

    // slope: of the lowest rise by the quantity, as it is expected there. The penalty leaves the target by as much as
    // it holds against that slope: one that is known beforehand is taken off, so that the target itself is met.
    struct Aim {
        double target = 0.0;
        double slope = 0.0;
        double negligible = negligible_rise;
        // A value to get away from: a search that stays short of half of the way to the target is repeated with the
        // slope that it met.
        std::optional<double> away_from{};
    };

    // The lowest point near `start` whose quantity is about the target. Nothing: the start has no answer.
    std::optional<ProfilePoint> lowest(const std::vector<double>& start, const Quantity& quantity, const Aim& aim);

    // Whether chi2 has risen by the threshold there, near enough.
    bool is_end(const ProfilePoint& p) const;
    // Where chi2 has risen by the threshold, between a point that the data accept and one that they reject: computed
    // points until one is near enough. The branch gets what was computed, the end, and why it is the end.
    void cross(ProfilePoint inside, ProfilePoint outside, const Quantity& quantity, Branch& branch);

private:
    run::Chain& chain_;
    const problem::Problem& problem_;
    const Acceptance& acceptance_;
    double best_misfit_;
};

} // namespace explore::landscape

#include "landscape/profile.h"

#include "landscape/walker.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double longest_step = 0.25; // in any unit coordinate
constexpr int most_steps = 40;

} // namespace

Quantity coordinate(std::size_t axis) {
    return {[axis](const std::vector<double>& unit, const problem::Evaluation&) { return unit[axis]; },
            [axis](const std::vector<double>& unit, const problem::Evaluation&) -> VectorXd {
                return VectorXd::Unit(static_cast<Index>(unit.size()), static_cast<Index>(axis));
            }};
}

Quantity response(const problem::ParameterSpace& space, std::size_t index) {
    return {[index](const std::vector<double>&, const problem::Evaluation& e) { return e.responses[index]; },
            [&space, index](const std::vector<double>& unit, const problem::Evaluation& e) -> VectorXd {
                VectorXd gradient = e.jacobian.row(static_cast<Index>(index));
                for (std::size_t k = 0; k < unit.size(); ++k) {
                    gradient[static_cast<Index>(k)] *= space.axes[k].d_physical(unit[k]);
                }
                return gradient;
            }};
}

Quantity along(const VectorXd& direction) {
    return {[direction](const std::vector<double>& unit, const problem::Evaluation&) {
                return direction.dot(vector_of(unit));
            },
            [direction](const std::vector<double>&, const problem::Evaluation&) -> VectorXd { return direction; }};
}

Branch walk(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance, const Minimum& from,
            double best_misfit, const Quantity& quantity, int sign) {
    Walker walker(chain, problem, acceptance, best_misfit);
    Branch branch;
    ProfilePoint here = walker.point(from.unit, from.evaluation, quantity);
    branch.limit = here.value;
    const double wall = std::sqrt(acceptance.threshold);
    double stretch = 1.0; // how far steps lead beyond what linear theory has
    for (int step = 0; step < most_steps; ++step) {
        const Surroundings around(problem, acceptance, here, quantity.gradient(here.unit, here.evaluation),
                                  longest_step);
        const double risen = root(here.rise);
        const double left = wall - risen;
        const double wanted =
            left < 0.75 * wall ? left + 0.1 * wall : 0.5 * wall; // just beyond the end, where it is near
        optimise::LinearReach::Move move =
            around.until(sign, std::pow(risen + stretch * wanted, 2) - std::max(0.0, here.rise));
        if (!(move.change * sign > 0.0)) {
            branch.end = WalkEnd::bound;
            break;
        }
        if (step == 0) { // 0 but where a bound or a limit holds the minimum
            constexpr double near = 1e-3;
            here.slope = around.to(near * move.change).slope;
        }
        std::optional<ProfilePoint> found;
        for (int halved = 0; halved < 5 && !found; ++halved) {
            found = walker.lowest(clamped(here.unit, move.d), quantity,
                                  {.target = here.value + move.change, .slope = move.slope, .away_from = here.value});
            if (!found) {
                move = around.to(0.5 * move.change);
            }
        }
        if (!found) {
            branch.end = WalkEnd::hole;
            break;
        }
        const double gained = (found->value - here.value) * sign;
        if (found->rise < -better_by) {
            branch.points.push_back(std::move(*found));
            branch.end = WalkEnd::better;
            break;
        }
        if (found->rise > acceptance.threshold || walker.is_end(*found)) {
            walker.cross(std::move(here), std::move(*found), quantity, branch);
            return branch;
        }
        if (gained < 0.02 * std::abs(move.change)) { // nothing in the box moves it further, or only up to the bound
            if (gained > 0.0) {
                here = *found;
                branch.limit = here.value;
                branch.points.push_back(std::move(*found));
            }
            branch.end = WalkEnd::bound;
            break;
        }
        const double expected = root(here.rise + move.rise) - risen;
        constexpr double tells = 0.05; // of the wall
        if (expected > tells * wall) {
            const double rose = root(found->rise) - risen;
            stretch = std::clamp(expected / std::max(rose, 1e-12), 0.5 * stretch, 3.0 * stretch);
        }
        here = *found;
        branch.limit = here.value;
        branch.points.push_back(std::move(*found));
    }
    branch.on_bound = bounds_met(here.unit);
    branch.on_limit = problem.active_limits(here.evaluation);
    branch.limit_unit = here.unit;
    return branch;
}

Branch trace_valley(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance,
                    const Minimum& from, const VectorXd& direction) {
    Walker walker(chain, problem, acceptance, from.evaluation.misfit);
    Branch branch;
    ProfilePoint here = walker.point(from.unit, from.evaluation, along(direction));
    double travelled = 0.0;
    VectorXd heading = direction.normalized();
    double length = 0.1;
    for (int step = 0; step < most_steps; ++step) {
        // As far as the box allows, so that the bound itself is met.
        double room = std::numeric_limits<double>::infinity();
        for (Index k = 0; k < heading.size(); ++k) {
            const double u = here.unit[static_cast<std::size_t>(k)];
            if (std::abs(heading[k]) > 1e-9) {
                room = std::min(room, (heading[k] > 0.0 ? 1.0 - u : u) / std::abs(heading[k]));
            }
        }
        if (room < 1e-6) {
            branch.end = WalkEnd::bound;
            break;
        }
        const double s = std::min(length, room);
        const Quantity across = along(heading);
        const double before = across.value(here.unit, here.evaluation);
        auto found = walker.lowest(clamped(here.unit, s * heading), across, {.target = before + s});
        const bool rejected = found && found->rise > acceptance.threshold;
        if (!found || (rejected && s > 1e-3 && root(found->rise) > 1.3 * std::sqrt(acceptance.threshold))) {
            length = 0.5 * s;
            if (length >= 1e-3) {
                continue;
            }
            if (!found) {
                branch.end = WalkEnd::hole;
                break;
            }
        }
        if (rejected) {
            ProfilePoint inside = here;
            inside.value = before;
            inside.slope = walker.slope(here.evaluation, heading);
            const std::size_t known = branch.points.size();
            walker.cross(std::move(inside), std::move(*found), across, branch);
            const std::vector<double> last = here.unit;
            const auto distance = [&](const std::vector<double>& unit) {
                return travelled + (vector_of(unit) - vector_of(last)).norm();
            };
            for (std::size_t i = known; i < branch.points.size(); ++i) {
                branch.points[i].value = distance(branch.points[i].unit);
            }
            branch.limit = distance(branch.limit_unit);
            return branch;
        }
        const VectorXd moved = vector_of(found->unit) - vector_of(here.unit);
        const double sideways = (moved - heading * heading.dot(moved)).norm();
        if (moved.dot(heading) < 0.05 * s) {
            branch.end = WalkEnd::bound;
            break;
        }
        const std::size_t bounds_before = bounds_met(here.unit).size();
        travelled += moved.norm();
        found->value = travelled;
        here = std::move(*found);
        branch.points.push_back(here);
        if (here.rise < -better_by) {
            branch.end = WalkEnd::better;
            break;
        }
        length = sideways > 0.5 * s ? 0.5 * s : std::min(longest_step, 1.5 * length);
        // The flattest direction here, on the way we came.
        std::vector<Index> open;
        for (std::size_t k = 0; k < here.unit.size(); ++k) {
            if (!is_at_bound(here.unit[k])) {
                open.push_back(static_cast<Index>(k));
            }
        }
        if (open.empty()) {
            branch.end = WalkEnd::bound;
            break;
        }
        const MatrixXd j = problem.residual_jacobian(here.evaluation)(Eigen::all, open);
        const MatrixXd h = j.transpose() * j;
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(h);
        // Where one more parameter has met its bound: is the valley flat without it?
        const double half_the_box = 4.0 * acceptance.variance * acceptance.threshold;
        if (bounds_met(here.unit).size() > bounds_before && eigen.eigenvalues()[0] > half_the_box) {
            branch.end = WalkEnd::bound;
            break;
        }
        // With several flat directions: the part of the way we came that lies among them.
        VectorXd next = VectorXd::Zero(static_cast<Index>(open.size()));
        const VectorXd way = heading(open);
        const double flat = std::max(eigen.eigenvalues()[0], acceptance.variance * acceptance.threshold / 4.0);
        for (Index i = 0; i < eigen.eigenvalues().size(); ++i) {
            if (i == 0 || eigen.eigenvalues()[i] <= flat) {
                next += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).dot(way);
            }
        }
        if (next.norm() < 1e-3) { // what was moving has met its bound
            branch.end = WalkEnd::bound;
            break;
        }
        heading.setZero();
        heading(open) = next.normalized();
    }
    branch.limit = travelled;
    branch.on_bound = bounds_met(here.unit);
    branch.on_limit = problem.active_limits(here.evaluation);
    branch.limit_unit = here.unit;
    return branch;
}

} // namespace explore::landscape

#include "landscape/profile.h"

#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rise of chi2 that no verdict depends on, and a gain that means that a better minimum was found.
constexpr double negligible_rise = 0.01;
constexpr double better_by = 0.1;
constexpr double longest_step = 0.25; // in any unit coordinate
constexpr int most_steps = 40;

std::vector<double> clamped(const std::vector<double>& unit, const VectorXd& move) {
    std::vector<double> moved = unit;
    for (std::size_t k = 0; k < moved.size(); ++k) {
        moved[k] = std::clamp(moved[k] + move[static_cast<Index>(k)], 0.0, 1.0);
    }
    return moved;
}

VectorXd vector_of(const std::vector<double>& unit) {
    return VectorXd::Map(unit.data(), static_cast<Index>(unit.size()));
}

// J'J in units of the noise, and one more on the diagonal: a direction that the data do not see costs something, so
// that a move along it stays finite.
MatrixXd information(const problem::Problem& problem, const Acceptance& acceptance, const ProfilePoint& at) {
    const MatrixXd j = problem.residual_jacobian(at.evaluation);
    MatrixXd h = j.transpose() * j / acceptance.variance;
    h.diagonal().array() += 1.0;
    return h;
}

class Walker {
public:
    Walker(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance, double best_misfit)
        : chain_(chain),
          problem_(problem),
          acceptance_(acceptance),
          best_misfit_(best_misfit) {}

    ProfilePoint point(std::vector<double> unit, problem::Evaluation evaluation, const Quantity& quantity) const {
        ProfilePoint p;
        p.value = quantity.value(unit, evaluation);
        p.rise = acceptance_.rise(evaluation.misfit, best_misfit_);
        p.unit = std::move(unit);
        p.evaluation = std::move(evaluation);
        return p;
    }

    // The lowest point near `start` whose quantity is about `target`. Nothing: the start has no answer.
    std::optional<ProfilePoint> lowest(const std::vector<double>& start, const Quantity& quantity, double target) {
        double weight = 0.0; // set at the first point: stiffer than the data by a factor
        problem::Evaluation best;
        double lowest = std::numeric_limits<double>::infinity();
        const optimise::Objective objective = [&](std::span<const double> at, optimise::Sample& sample) {
            problem::Evaluation e = chain_.at(at);
            if (!e.converged()) {
                return optimise::Answer::no_answer;
            }
            const std::vector<double> unit(at.begin(), at.end());
            sample = run::sample_of(problem_, e);
            const VectorXd residuals = sample.residuals;
            const MatrixXd jacobian = sample.jacobian;
            const VectorXd gradient = quantity.gradient(unit, e);
            if (weight == 0.0) {
                constexpr double stiffer = 3.0;
                weight = stiffer * std::max(jacobian.norm(), acceptance_.noise()) /
                         std::max(gradient.norm(), std::numeric_limits<double>::min());
            }
            sample.residuals.resize(residuals.size() + 1);
            sample.residuals << residuals, weight * (quantity.value(unit, e) - target);
            sample.jacobian.resize(jacobian.rows() + 1, jacobian.cols());
            sample.jacobian << jacobian, weight * gradient.transpose();
            if (sample.residuals.squaredNorm() < lowest) {
                lowest = sample.residuals.squaredNorm();
                best = std::move(e);
            }
            return optimise::Answer::computed;
        };
        optimise::SearchSettings settings;
        settings.max_evaluations = 20;
        settings.enough = 0.5 * negligible_rise * acceptance_.variance;
        settings.first_step = optimise::whole_cube;
        const auto found = optimise::gauss_newton(start, objective, settings);
        if (found.unit.empty()) {
            return std::nullopt;
        }
        return point(found.unit, std::move(best), quantity);
    }

private:
    run::Chain& chain_;
    const problem::Problem& problem_;
    const Acceptance& acceptance_;
    double best_misfit_;
};

// Moves of the unit cube that change the quantity by `change` and raise the misfit least, to first order. Parameters on
// a bound that they would leave the box by stay there.
VectorXd cheapest_move(const MatrixXd& h, const VectorXd& gradient, const std::vector<double>& unit, double change) {
    const auto n = static_cast<Index>(unit.size());
    std::vector<bool> held(unit.size(), false);
    for (int pass = 0; pass <= n; ++pass) {
        std::vector<Index> open;
        for (Index k = 0; k < n; ++k) {
            if (!held[static_cast<std::size_t>(k)]) {
                open.push_back(k);
            }
        }
        VectorXd move = VectorXd::Zero(n);
        if (open.empty()) {
            return move;
        }
        const MatrixXd part = h(open, open);
        const VectorXd slope = gradient(open);
        const VectorXd c = part.llt().solve(slope);
        const double size = slope.dot(c);
        if (!(size > 0.0)) {
            return move;
        }
        const VectorXd found = c * (change / size);
        move(open) = found;
        bool again = false;
        for (const Index k : open) {
            const double u = unit[static_cast<std::size_t>(k)];
            if ((u <= 0.0 && move[k] < 0.0) || (u >= 1.0 && move[k] > 0.0)) {
                held[static_cast<std::size_t>(k)] = true;
                again = true;
            }
        }
        if (!again) {
            return move;
        }
    }
    return VectorXd::Zero(n);
}

double root(double rise) {
    return std::sqrt(std::max(0.0, rise));
}

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
    double rise_a_step = 0.5 * wall; // of sqrt(chi2)
    for (int step = 0; step < most_steps; ++step) {
        const VectorXd gradient = quantity.gradient(here.unit, here.evaluation);
        const MatrixXd h = information(problem, acceptance, here);
        // A move of unit cost: it raises chi2 by one to second order.
        VectorXd move = cheapest_move(h, gradient, here.unit, sign);
        const double cost = std::sqrt(move.dot(h * move));
        if (!(cost > 0.0)) {
            branch.end = WalkEnd::bound;
            break;
        }
        move *= rise_a_step / cost;
        move *= std::min(1.0, longest_step / move.cwiseAbs().maxCoeff());
        double asked = gradient.dot(move);
        std::optional<ProfilePoint> found;
        for (int halved = 0; halved < 5 && !found; ++halved) {
            found = walker.lowest(clamped(here.unit, move), quantity, here.value + asked);
            move *= 0.5;
            asked *= found ? 1.0 : 0.5;
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
        if (found->rise >= acceptance.threshold) {
            // Between the last two points sqrt(chi2) is close to linear in the quantity.
            for (int refined = 0; refined < 4 && root(found->rise) > 1.3 * wall && root(here.rise) < 0.9 * wall;
                 ++refined) {
                const double share = (wall - root(here.rise)) / (root(found->rise) - root(here.rise));
                const double target = here.value + share * (found->value - here.value);
                const VectorXd part = share * (vector_of(found->unit) - vector_of(here.unit));
                auto nearer = walker.lowest(clamped(here.unit, part), quantity, target);
                if (!nearer || (nearer->value - here.value) * sign <= 0.0) {
                    break;
                }
                if (nearer->rise < acceptance.threshold) {
                    here = *nearer;
                    branch.points.push_back(std::move(*nearer));
                } else {
                    found = std::move(nearer);
                }
            }
            const double share = (wall - root(here.rise)) / std::max(root(found->rise) - root(here.rise), 1e-12);
            branch.limit = here.value + std::clamp(share, 0.0, 1.0) * (found->value - here.value);
            branch.limit_unit =
                clamped(here.unit, std::clamp(share, 0.0, 1.0) * (vector_of(found->unit) - vector_of(here.unit)));
            branch.on_bound = bounds_met(found->unit);
            branch.on_limit = problem.active_limits(found->evaluation);
            branch.points.push_back(std::move(*found));
            branch.end = WalkEnd::threshold;
            return branch;
        }
        if (gained < 0.02 * std::abs(asked)) { // nothing in the box moves it further, or only up to the bound
            if (gained > 0.0) {
                here = *found;
                branch.limit = here.value;
                branch.points.push_back(std::move(*found));
            }
            branch.end = WalkEnd::bound;
            break;
        }
        const double rose = root(found->rise) - root(here.rise);
        rise_a_step *= std::clamp(0.5 * wall / std::max(rose, 1e-12), 0.5, 3.0);
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
        auto found =
            walker.lowest(clamped(here.unit, s * heading), across, across.value(here.unit, here.evaluation) + s);
        if (!found || (found->rise > acceptance.threshold && s > 1e-3 &&
                       root(found->rise) > 1.3 * std::sqrt(acceptance.threshold))) {
            length = 0.5 * s;
            if (length < 1e-3) {
                branch.end = found ? WalkEnd::threshold : WalkEnd::hole;
                break;
            }
            continue;
        }
        const VectorXd moved = vector_of(found->unit) - vector_of(here.unit);
        const double sideways = (moved - heading * heading.dot(moved)).norm();
        if (moved.dot(heading) < 0.05 * s) {
            branch.end = WalkEnd::bound;
            break;
        }
        travelled += moved.norm();
        found->value = travelled;
        here = std::move(*found);
        branch.points.push_back(here);
        if (here.rise < -better_by) {
            branch.end = WalkEnd::better;
            break;
        }
        if (here.rise >= acceptance.threshold) {
            branch.end = WalkEnd::threshold;
            break;
        }
        const auto met = bounds_met(here.unit);
        if (!met.empty() && met != bounds_met(from.unit)) {
            branch.end = WalkEnd::bound;
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
        const MatrixXd j = problem.residual_jacobian(here.evaluation)(Eigen::all, open);
        const MatrixXd h = j.transpose() * j;
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(h);
        // With several flat directions: the part of the way we came that lies among them.
        VectorXd next = VectorXd::Zero(static_cast<Index>(open.size()));
        const VectorXd way = heading(open);
        const double flat = std::max(eigen.eigenvalues()[0], acceptance.variance * acceptance.threshold / 4.0);
        for (Index i = 0; i < eigen.eigenvalues().size(); ++i) {
            if (i == 0 || eigen.eigenvalues()[i] <= flat) {
                next += eigen.eigenvectors().col(i) * eigen.eigenvectors().col(i).dot(way);
            }
        }
        if (next.norm() < 1e-6) {
            branch.end = WalkEnd::limit;
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

namespace {
constexpr int planes = 8;
} // namespace

std::vector<ProfilePoint> approach(run::Chain& chain, const problem::Problem& problem, const Acceptance& acceptance,
                                   const Minimum& from, const Minimum& to, double best_misfit) {
    Walker walker(chain, problem, acceptance, best_misfit);
    const VectorXd line = vector_of(to.unit) - vector_of(from.unit);
    const Quantity share{
        [&](const std::vector<double>& unit, const problem::Evaluation&) {
            return line.dot(vector_of(unit) - vector_of(from.unit)) / line.squaredNorm();
        },
        [&](const std::vector<double>&, const problem::Evaluation&) -> VectorXd { return line / line.squaredNorm(); }};
    std::vector<ProfilePoint> way{walker.point(from.unit, from.evaluation, share)};
    for (int plane = 1; plane < planes; ++plane) {
        const double target = static_cast<double>(plane) / planes;
        // Straight for the other minimum from where we are.
        const VectorXd left = vector_of(to.unit) - vector_of(way.back().unit);
        const double part = (target - way.back().value) / std::max(1.0 - way.back().value, 1e-9);
        auto found = walker.lowest(clamped(way.back().unit, std::clamp(part, 0.0, 1.0) * left), share, target);
        if (!found) {
            break;
        }
        way.push_back(std::move(*found));
    }
    return way;
}

Pass pass_between(run::Chain& chain, const Acceptance& acceptance, const std::vector<ProfilePoint>& forth,
                  const std::vector<ProfilePoint>& back, double best_misfit) {
    // forth[i] lies near i / planes of the way, back[j] near 1 - j / planes. The change from forth[i] to
    // back[planes - 1 - i] is straight, with points between.
    Pass best{std::numeric_limits<double>::infinity(), {}};
    struct Change {
        std::size_t i, j;
        double rise;
    };
    std::vector<Change> changes;
    const auto highest = [](const std::vector<ProfilePoint>& way, std::size_t last) {
        double rise = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i <= last; ++i) {
            rise = std::max(rise, way[i].rise);
        }
        return rise;
    };
    for (std::size_t i = 0; i < forth.size(); ++i) {
        const std::size_t j = static_cast<std::size_t>(planes) - 1 - i;
        if (j < back.size()) {
            changes.push_back({i, j, std::max(highest(forth, i), highest(back, j))});
        }
    }
    std::stable_sort(changes.begin(), changes.end(), [](const auto& a, const auto& b) { return a.rise < b.rise; });
    constexpr std::size_t tried = 3;
    for (std::size_t c = 0; c < std::min(tried, changes.size()) && changes[c].rise < best.rise; ++c) {
        const auto& [i, j, low] = changes[c];
        Pass pass{low, {}};
        pass.way.assign(forth.begin(), forth.begin() + static_cast<std::ptrdiff_t>(i) + 1);
        const VectorXd a = vector_of(forth[i].unit);
        const VectorXd b = vector_of(back[j].unit);
        constexpr int between = 4;
        for (int k = 1; k < between && pass.rise < best.rise; ++k) {
            const VectorXd x = a + (b - a) * k / between;
            const std::vector<double> unit(x.begin(), x.end());
            problem::Evaluation e = chain.at(unit);
            const double rise =
                e.converged() ? acceptance.rise(e.misfit, best_misfit) : std::numeric_limits<double>::infinity();
            pass.rise = std::max(pass.rise, rise);
            pass.way.push_back({forth[i].value, rise, unit, std::move(e)});
        }
        pass.way.insert(pass.way.end(), back.rend() - static_cast<std::ptrdiff_t>(j) - 1, back.rend());
        if (pass.rise < best.rise) {
            best = std::move(pass);
        }
    }
    // The top of the way may lie between two of its points: halve around the highest.
    constexpr int halvings = 4;
    for (int n = 0; n < halvings && std::isfinite(best.rise); ++n) {
        const auto top = std::max_element(best.way.begin(), best.way.end(),
                                          [](const auto& x, const auto& y) { return x.rise < y.rise; }) -
                         best.way.begin();
        for (const std::ptrdiff_t left : {top, top - 1}) { // the later interval first: the earlier keeps its place
            if (left < 0 || left + 1 >= static_cast<std::ptrdiff_t>(best.way.size())) {
                continue;
            }
            const auto& a = best.way[static_cast<std::size_t>(left)];
            const auto& b = best.way[static_cast<std::size_t>(left) + 1];
            const VectorXd x = 0.5 * (vector_of(a.unit) + vector_of(b.unit));
            const std::vector<double> unit(x.begin(), x.end());
            problem::Evaluation e = chain.at(unit);
            const double rise =
                e.converged() ? acceptance.rise(e.misfit, best_misfit) : std::numeric_limits<double>::infinity();
            best.rise = std::max(best.rise, rise);
            best.way.insert(best.way.begin() + left + 1,
                            ProfilePoint{0.5 * (a.value + b.value), rise, unit, std::move(e)});
        }
    }
    return best;
}

} // namespace explore::landscape

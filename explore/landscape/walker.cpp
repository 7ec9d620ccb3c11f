#include "landscape/walker.h"

#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// The end of a walk: how near the rise of chi2 must be to the threshold, as a share of it.
constexpr double near_end = 2.5e-4;

// The cubic through two points of a curve, with its slopes there: at a share of the way from one to the other.
struct Cubic {
    double a, slope_a, b, slope_b; // slopes by the share

    // Whether a curve that only rises, and bends one way, may have these slopes.
    bool is_plain() const {
        constexpr double steepest = 3.0;
        const double most = steepest * (b - a);
        return slope_a >= 0.0 && slope_a <= most && slope_b >= 0.0 && slope_b <= most;
    }
    double value(double s) const {
        const double t = 1.0 - s;
        return t * t * ((1.0 + 2.0 * s) * a + s * slope_a) + s * s * ((1.0 + 2.0 * t) * b - t * slope_b);
    }
    double slope(double s) const {
        return 6.0 * s * (1.0 - s) * (b - a) + (1.0 - s) * (1.0 - 3.0 * s) * slope_a + s * (3.0 * s - 2.0) * slope_b;
    }
    // a < level < b
    double share_at(double level) const {
        double low = 0.0;
        double high = 1.0;
        constexpr int halvings = 40;
        for (int i = 0; i < halvings; ++i) {
            const double middle = 0.5 * (low + high);
            (value(middle) < level ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }
};

// The way by unit coordinates between two points of a profile, from how the parameters move with the quantity there.
std::vector<double> points_between(const problem::Problem& problem, const Acceptance& acceptance,
                                   const Quantity& quantity, const ProfilePoint& from, const ProfilePoint& to,
                                   double share) {
    const auto leaving = [&](const ProfilePoint& p) {
        return cheapest_move(information(problem, acceptance, p), quantity.gradient(p.unit, p.evaluation), p.unit,
                             to.value - from.value);
    };
    const VectorXd way = vector_of(to.unit) - vector_of(from.unit);
    const VectorXd first = leaving(from);
    const VectorXd last = leaving(to);
    VectorXd moved = share * way;
    const double longest = way.cwiseAbs().maxCoeff();
    if (std::max((first - way).cwiseAbs().maxCoeff(), (last - way).cwiseAbs().maxCoeff()) < longest) {
        for (Index k = 0; k < way.size(); ++k) {
            moved[k] = Cubic{0.0, first[k], way[k], last[k]}.value(share);
        }
    }
    return clamped(from.unit, moved);
}

} // namespace

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

MatrixXd information(const problem::Problem& problem, const Acceptance& acceptance, const ProfilePoint& at) {
    const MatrixXd j = problem.residual_jacobian(at.evaluation);
    MatrixXd h = j.transpose() * j / acceptance.variance;
    h.diagonal().array() += 1.0;
    return h;
}

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

namespace {

optimise::Sample in_units_of_noise(optimise::Sample rows, double noise) {
    rows.residuals /= noise;
    rows.jacobian /= noise;
    rows.limits /= noise;
    rows.limit_jacobian /= noise;
    return rows;
}

} // namespace

Surroundings::Surroundings(const problem::Problem& problem, const Acceptance& acceptance, const ProfilePoint& at,
                           const VectorXd& gradient, double longest)
    : rows_(in_units_of_noise(run::sample_of(problem, at.evaluation), acceptance.noise())),
      low_((-vector_of(at.unit)).cwiseMax(-longest)),
      high_((1.0 - vector_of(at.unit).array()).cwiseMin(longest)),
      here_(2.0 * optimise::LinearRows(rows_, {}).half(VectorXd::Zero(gradient.size()))),
      reach_(rows_, low_, high_, gradient, 1.0) {}

ProfilePoint Walker::point(std::vector<double> unit, problem::Evaluation evaluation, const Quantity& quantity) const {
    ProfilePoint p;
    p.value = quantity.value(unit, evaluation);
    p.rise = acceptance_.rise(evaluation.misfit, best_misfit_);
    p.unit = std::move(unit);
    p.evaluation = std::move(evaluation);
    return p;
}

double Walker::slope(const problem::Evaluation& at, const VectorXd& along) const {
    return 2.0 / acceptance_.variance * along.dot(problem_.residual_jacobian(at).transpose() * problem_.residuals(at));
}

std::optional<ProfilePoint> Walker::lowest(const std::vector<double>& start, const Quantity& quantity, const Aim& aim) {
    double weight = 0.0; // set at the first point: stiffer than the data by a factor
    double expected = aim.slope;
    const auto held = [&](double value) {
        return weight * (value - aim.target) - 0.5 * expected * acceptance_.variance / weight;
    };
    // By which the quantity is pulled, as a slope of chi2.
    const auto pull = [&](double value) { return -2.0 * weight * held(value) / acceptance_.variance; };
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
        sample.residuals << residuals, held(quantity.value(unit, e));
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
    settings.enough = 0.5 * aim.negligible * acceptance_.variance;
    settings.first_step = optimise::whole_cube;
    optimise::SearchResult found = optimise::gauss_newton(start, objective, settings);
    if (found.unit.empty()) {
        return std::nullopt;
    }
    ProfilePoint lowest_point = point(found.unit, std::move(best), quantity);
    constexpr int repeats = 3;
    for (int i = 0; i < repeats && aim.away_from && lowest_point.rise < acceptance_.threshold &&
                    std::abs(lowest_point.value - aim.target) > 0.5 * std::abs(*aim.away_from - aim.target);
         ++i) {
        expected = pull(lowest_point.value);
        lowest = std::numeric_limits<double>::infinity();
        found = optimise::gauss_newton(lowest_point.unit, objective, settings);
        if (found.unit.empty()) {
            break;
        }
        lowest_point = point(found.unit, std::move(best), quantity);
    }
    const VectorXd gradient = quantity.gradient(lowest_point.unit, lowest_point.evaluation);
    double free = 0.0; // of the squared gradient: what no bound holds
    for (std::size_t k = 0; k < lowest_point.unit.size(); ++k) {
        free += is_at_bound(lowest_point.unit[k]) ? 0.0 : std::pow(gradient[static_cast<Index>(k)], 2);
    }
    constexpr double something = 1e-6;
    // Stationary in what is free; by the envelope theorem that is the slope of the profile, whatever bounds hold.
    if (free > something * gradient.squaredNorm()) {
        lowest_point.slope = pull(lowest_point.value);
    } else { // a bound bears a part of the pull
        lowest_point.slope = slope(lowest_point.evaluation, gradient.normalized()) / gradient.norm();
    }
    return lowest_point;
}

bool Walker::is_end(const ProfilePoint& p) const {
    return std::abs(p.rise - acceptance_.threshold) <= near_end * acceptance_.threshold;
}

void Walker::cross(ProfilePoint inside, ProfilePoint outside, const Quantity& quantity, Branch& branch) {
    const double threshold = acceptance_.threshold;
    std::vector<ProfilePoint> beyond{std::move(outside)}; // the nearest last
    const double begin = inside.value;
    const double whole = beyond[0].value - begin;
    std::optional<double> hole; // the nearest share of the whole way that has no answer
    branch.end = WalkEnd::threshold;
    if (is_end(beyond[0])) {
        inside = beyond[0];
    }
    double width = 1.0;  // of the bracket, a few points ago
    bool strays = false; // the last point does not lie between
    constexpr int most_points = 16;
    for (int tried = 0; tried < most_points && !is_end(inside); ++tried) {
        const ProfilePoint& out = beyond.back();
        const double between = out.value - inside.value;
        const Cubic rise{inside.rise, inside.slope * between, out.rise, out.slope * between};
        double share = rise.share_at(threshold);
        double slope_there = rise.slope(share) / between;
        std::vector<double> start;
        if (!rise.is_plain()) { // a limit or a bound begins to bear the pull: by what linear theory has
            const Surroundings around(problem_, acceptance_, inside, quantity.gradient(inside.unit, inside.evaluation),
                                      1.0);
            const auto move = around.until(between > 0.0 ? 1 : -1, threshold - inside.rise);
            const double linear = move.change / between;
            if (linear > 0.0 && linear < 1.0) {
                share = linear;
                slope_there = move.slope;
                start = clamped(inside.unit, move.d);
            }
        }
        constexpr int patience = 2;
        if (strays || tried % patience == patience - 1) { // a curve that is none of a cubic: halve
            if (strays || between / whole > 0.5 * width) {
                share = 0.5;
                slope_there = rise.slope(share) / between;
                start.clear();
            }
            width = between / whole;
        }
        if (const double least_hole = hole ? 0.5 * (*hole * whole + begin - inside.value) / between : 1.0;
            least_hole < share) {
            share = least_hole;
            start.clear();
        }
        constexpr double least = 1e-7;
        if (!(std::abs(share * between / whole) > least && std::abs((1.0 - share) * between / whole) > least)) {
            break; // chi2 jumps, or nothing beyond has an answer
        }
        if (start.empty()) {
            start = points_between(problem_, acceptance_, quantity, inside, out, share);
        }
        auto next = lowest(
            start, quantity,
            {.target = inside.value + share * between, .slope = slope_there, .negligible = 0.5 * near_end * threshold});
        if (!next) {
            hole = (inside.value + share * between - begin) / whole;
            continue;
        }
        if (next->rise < -better_by) {
            branch.end = WalkEnd::better;
            beyond = {std::move(*next)}; // what is beyond it matters no more
            break;
        }
        const double reached = (next->value - inside.value) / between;
        if (!(reached > 0.0 && reached < 1.0)) {
            if (strays) {
                break; // the quantity does not follow any more
            }
            strays = true;
            continue;
        }
        strays = false;
        if (next->rise < threshold || is_end(*next)) {
            inside = std::move(*next);
            branch.points.push_back(inside);
        } else {
            beyond.push_back(std::move(*next));
        }
    }
    if (branch.end == WalkEnd::threshold && hole && !is_end(inside)) {
        branch.end = WalkEnd::hole;
    }
    branch.limit = inside.value;
    branch.limit_unit = inside.unit;
    branch.on_bound = bounds_met(inside.unit);
    branch.on_limit = problem_.active_limits(inside.evaluation);
    constexpr double far = 4.0; // times the threshold: of no use but for the end
    for (auto p = beyond.rbegin(); p != beyond.rend() && (p == beyond.rbegin() || p->rise < far * threshold); ++p) {
        branch.points.push_back(std::move(*p));
    }
}

} // namespace explore::landscape

#include "landscape/adaptive_map.h"

#include "base/random.h"
#include "run/parallel.h"
#include "search/neighbours.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <limits>
#include <numeric>

namespace explore::landscape {
namespace {

using search::Neighbours;

constexpr double no_answer = std::numeric_limits<double>::quiet_NaN();

double level_of(const problem::Evaluation& e) {
    return e.converged() ? std::log(std::max(e.misfit, std::numeric_limits<double>::min())) : no_answer;
}

std::size_t neighbours_of(std::size_t dimension) {
    return 2 * (dimension + 1);
}

// The logarithm of the misfit at a point from its neighbours: the plane of least squares through them, near ones
// counting more, kept within their range. Not a number: the nearest has no answer.
double level_at(std::span<const double> at, std::span<const Neighbours::Neighbour> near,
                std::span<const std::vector<double>> points, std::span<const double> level) {
    if (near.empty() || std::isnan(level[near[0].point])) {
        return no_answer;
    }
    const auto d = static_cast<Eigen::Index>(at.size());
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    Eigen::MatrixXd a(static_cast<Eigen::Index>(near.size()), d + 1);
    Eigen::VectorXd b(a.rows());
    Eigen::Index rows = 0;
    const double scale = std::max(near.back().distance, std::numeric_limits<double>::min());
    for (const auto& n : near) {
        if (std::isnan(level[n.point])) {
            continue;
        }
        const double weight = scale / (n.distance + 0.1 * scale);
        a(rows, 0) = weight;
        for (Eigen::Index k = 0; k < d; ++k) {
            const auto axis = static_cast<std::size_t>(k);
            a(rows, k + 1) = weight * (points[n.point][axis] - at[axis]) / scale;
        }
        b[rows++] = weight * level[n.point];
        low = std::min(low, level[n.point]);
        high = std::max(high, level[n.point]);
    }
    if (rows <= d) { // no plane
        return level[near[0].point];
    }
    const Eigen::VectorXd plane =
        Eigen::MatrixXd(a.topRows(rows)).colPivHouseholderQr().solve(Eigen::VectorXd(b.head(rows)));
    return std::clamp(plane[0], low, high);
}

class Builder {
public:
    Builder(run::Engine& engine, const problem::Problem& problem, int points, std::uint64_t seed, int threads)
        : engine_(engine),
          dimension_(static_cast<std::size_t>(problem.space.dimension())),
          neighbours_(neighbours_of(dimension_)),
          seed_(seed),
          threads_(threads),
          arena_(run::usable_threads(threads)) {
        const auto n = static_cast<std::size_t>(points);
        checks_ = std::max<std::size_t>(1, n / 10);
        wanted_ = n - checks_;
        map_.design = search::sobol(problem.space, static_cast<int>(std::max<std::size_t>(1, n / 4)), seed);
        map_.design.name = adaptive_name(points, seed);
    }

    std::optional<AdaptiveMap> run() {
        auto& points = map_.design.points;
        if (!compute()) {
            return std::nullopt;
        }
        while (points.size() < wanted_) {
            constexpr std::size_t rounds_to_grow = 4; // a round adds a quarter
            add(std::min(wanted_ - points.size(), std::max<std::size_t>(1, points.size() / rounds_to_grow)));
            if (!compute()) {
                return std::nullopt;
            }
        }
        std::vector<std::vector<double>> drawn(checks_, std::vector<double>(dimension_));
        const pave::RandomStream random(seed_, 0xc4ec5ULL);
        std::uint64_t number = 0;
        for (auto& unit : drawn) {
            for (double& u : unit) {
                u = random.uniform(number++);
            }
        }
        const auto predicted = predict(drawn, points, map_.evaluations, threads_);
        points.insert(points.end(), drawn.begin(), drawn.end());
        if (!compute()) {
            return std::nullopt;
        }
        judge(predicted);
        return std::move(map_);
    }

private:
    bool compute() {
        auto evaluations = engine_.evaluate(map_.design, false, map_.evaluations.size());
        if (!evaluations) {
            return false;
        }
        for (auto& e : *evaluations) {
            level_.push_back(level_of(e));
            map_.evaluations.push_back(std::move(e));
        }
        sorted_.clear();
        std::copy_if(level_.begin(), level_.end(), std::back_inserter(sorted_),
                     [](double v) { return !std::isnan(v); });
        std::sort(sorted_.begin(), sorted_.end());
        return true;
    }

    // The next points: of many candidates near the points that promise most and of some anywhere, those that promise
    // most.
    void add(std::size_t count) {
        auto& points = map_.design.points;
        const std::size_t n = points.size();
        const Neighbours tree(points);
        std::vector<double> error(n, no_answer); // of the misfit when it is predicted from the other points
        std::vector<double> reach(n, 0.0);
        run::for_each_index(arena_, n, [&](std::size_t i) {
            auto near = tree.nearest(points[i], neighbours_ + 1);
            std::erase_if(near, [&](const auto& j) { return j.point == i; });
            near.resize(std::min(near.size(), neighbours_));
            for (const auto& j : near) {
                reach[i] += j.distance / static_cast<double>(near.size());
            }
            if (!std::isnan(level_[i])) {
                error[i] = std::abs(level_at(points[i], near, points, level_) - level_[i]);
            }
        });
        const Landscape landscape{tree, error, reach};
        std::vector<double> promise(n);
        run::for_each_index(arena_, n, [&](std::size_t i) { promise[i] = promise_of(points[i], landscape, reach[i]); });
        const auto parents = largest(promise, count);

        constexpr std::size_t children = 8;
        constexpr std::size_t others = 2; // a parent
        const std::size_t family = children + others;
        std::vector<std::vector<double>> candidates(parents.size() * family, std::vector<double>(dimension_));
        std::vector<double> score(candidates.size());
        std::vector<std::size_t> home(candidates.size());
        run::for_each_index(arena_, candidates.size(), [&](std::size_t c) {
            const std::size_t parent = parents[c / family];
            const pave::RandomStream random(seed_, (n << 24U) + c);
            for (std::size_t k = 0; k < dimension_; ++k) {
                const double u = random.uniform(k);
                candidates[c][k] = c % family < children
                                       ? std::clamp(points[parent][k] + reach[parent] * (2.0 * u - 1.0), 0.0, 1.0)
                                       : u;
            }
            const auto nearest = tree.nearest(candidates[c], 1)[0];
            home[c] = nearest.point;
            score[c] = promise_of(candidates[c], landscape, nearest.distance);
        });
        constexpr int most_beside = 2; // of one point in one round: those that come next would know more
        std::vector<int> beside(n, 0);
        std::size_t added = 0;
        for (const std::size_t c : largest(score, candidates.size())) {
            if (added < count && beside[home[c]]++ < most_beside) {
                points.push_back(candidates[c]);
                ++added;
            }
        }
    }

    struct Landscape {
        const Neighbours& tree;
        const std::vector<double>& error;
        const std::vector<double>& reach;
    };

    // How much a point is worth that is `distance` from the next: the error around it, the room it has, and how low the
    // misfit is predicted to be, compared with all of the map.
    double promise_of(const std::vector<double>& at, const Landscape& landscape, double distance) const {
        const auto near = landscape.tree.nearest(at, neighbours_);
        double error = 0.0;
        int known = 0;
        for (const auto& j : near) {
            if (!std::isnan(landscape.error[j.point])) {
                error += landscape.error[j.point];
                ++known;
            }
        }
        const double level = level_at(at, near, map_.design.points, level_);
        const auto below = std::lower_bound(sorted_.begin(), sorted_.end(), level) - sorted_.begin();
        const double rank = std::isnan(level) ? 1.0
                                              : static_cast<double>(below) /
                                                    static_cast<double>(std::max<std::size_t>(1, sorted_.size()));
        constexpr double lowest = 0.02; // the lowest fiftieth counts fifty times more than the highest
        return error / std::max(1, known) * std::pow(distance, 0.5 * static_cast<double>(dimension_)) / (lowest + rank);
    }

    // Indices of the `count` largest, largest first.
    static std::vector<std::size_t> largest(const std::vector<double>& values, std::size_t count) {
        std::vector<std::size_t> order(values.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return values[a] > values[b]; });
        order.resize(std::min(order.size(), count));
        return order;
    }

    void judge(const std::vector<double>& predicted) {
        Explored& e = map_.explored;
        e.checks = checks_;
        std::vector<double> errors;
        for (std::size_t i = 0; i < checks_; ++i) {
            const auto& truth = map_.evaluations[map_.evaluations.size() - checks_ + i];
            e.predicted += is_predicted(predicted[i], truth) ? 1 : 0;
            if (truth.converged() && !std::isnan(predicted[i])) {
                errors.push_back(std::abs(predicted[i] / truth.misfit - 1.0));
            }
        }
        const auto hits = static_cast<double>(e.predicted);
        const auto misses = static_cast<double>(e.checks - e.predicted);
        constexpr double tail = 0.025;
        e.low = hits > 0.0 ? gsl_cdf_beta_Pinv(tail, hits, misses + 1.0) : 0.0;
        e.high = misses > 0.0 ? gsl_cdf_beta_Qinv(tail, hits + 1.0, misses) : 1.0;
        const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
        std::nth_element(errors.begin(), middle, errors.end());
        e.median_error = errors.empty() ? no_answer : *middle;
    }

    run::Engine& engine_;
    std::size_t dimension_;
    std::size_t neighbours_;
    std::uint64_t seed_;
    int threads_;
    tbb::task_arena arena_;
    std::size_t checks_ = 0, wanted_ = 0;
    AdaptiveMap map_;
    std::vector<double> level_;  // of every point
    std::vector<double> sorted_; // of those that have an answer
};

} // namespace

std::vector<double> predict(const std::vector<std::vector<double>>& at, const std::vector<std::vector<double>>& points,
                            const std::vector<problem::Evaluation>& evaluations, int threads) {
    std::vector<double> level;
    level.reserve(evaluations.size());
    for (const auto& e : evaluations) {
        level.push_back(level_of(e));
    }
    const Neighbours tree(points);
    tbb::task_arena arena(run::usable_threads(threads));
    std::vector<double> misfit(at.size());
    run::for_each_index(arena, at.size(), [&](std::size_t i) {
        misfit[i] = std::exp(level_at(at[i], tree.nearest(at[i], neighbours_of(at[i].size())), points, level));
    });
    return misfit;
}

bool is_predicted(double predicted, const problem::Evaluation& evaluation) {
    if (!evaluation.converged() || std::isnan(predicted)) {
        return !evaluation.converged() && std::isnan(predicted);
    }
    return std::abs(predicted / evaluation.misfit - 1.0) <= Explored::tolerance;
}

std::string adaptive_name(int points, std::uint64_t seed) {
    return fmt::format("adaptive {} (seed {})", points, seed);
}

std::optional<AdaptiveMap> adaptive_map(run::Engine& engine, const problem::Problem& problem, int points,
                                        std::uint64_t seed, int threads) {
    return Builder(engine, problem, points, seed, threads).run();
}

} // namespace explore::landscape

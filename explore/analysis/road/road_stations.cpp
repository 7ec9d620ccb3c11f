#include "analysis/road/road_stations.h"

#include "optimise/gauss_newton.h"
#include "run/least_squares.h"
#include "run/parallel.h"

#include <algorithm>

namespace explore::analysis {
namespace {

using Eigen::Index;
using optimise::Answer;

const optimise::SearchSettings search_settings{};

} // namespace

std::vector<std::size_t> RoadLayout::own_axes(std::size_t i) const {
    std::vector<std::size_t> axes;
    for (std::size_t k = 0; k < blocks[i].common.size(); ++k) {
        if (blocks[i].common[k] == optimise::own_unknown) {
            axes.push_back(k);
        }
    }
    return axes;
}

RoadStations::RoadStations(Session& session, const std::vector<StationTask>& tasks, const std::vector<int>& runs,
                           const RoadLayout& layout)
    : session_(session),
      tasks_(tasks),
      runs_(runs),
      layout_(layout) {}

bool RoadStations::for_each(std::size_t count, const std::function<void(std::size_t)>& body) {
    const int at_once = run::concurrency(session_.options().threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, at_once);
    tbb::task_arena arena(at_once);
    run::for_each_index(arena, count, body);
    return !run::interrupted();
}

std::optional<problem::Evaluation> RoadStations::evaluate(std::size_t i, std::span<const double> unit, int number) {
    auto point = search(i, {unit.begin(), unit.end()}, {}, number);
    return point ? std::optional(std::move(point->evaluation)) : std::nullopt;
}

std::optional<RoadPoint> RoadStations::search(std::size_t i, const std::vector<double>& from,
                                              const std::vector<std::size_t>& axes, int number) {
    const problem::Problem& problem = tasks_[i].problem;
    run::EngineSettings settings = session_.engine_settings();
    settings.show_progress = false;
    run::Engine engine(problem, session_.store(), runs_[i], settings);
    RoadPoint end{from, {}};
    const bool finished = engine.chain("road", number, [&](run::Chain& chain) {
        end.evaluation = chain.at(from);
        if (axes.empty() || !end.evaluation.converged()) {
            return;
        }
        std::exception_ptr failure; // no exception crosses the optimiser
        const optimise::Objective objective = [&](std::span<const double> part, optimise::Sample& sample) {
            try {
                std::vector<double> unit = from;
                for (std::size_t k = 0; k < axes.size(); ++k) {
                    unit[axes[k]] = part[k];
                }
                problem::Evaluation e = chain.at(unit);
                if (!e.converged()) {
                    return Answer::no_answer;
                }
                const optimise::Sample whole = run::sample_of(problem, e);
                sample.residuals = whole.residuals;
                sample.jacobian.resize(whole.jacobian.rows(), static_cast<Index>(axes.size()));
                for (std::size_t k = 0; k < axes.size(); ++k) {
                    sample.jacobian.col(static_cast<Index>(k)) = whole.jacobian.col(static_cast<Index>(axes[k]));
                }
                if (e.misfit <= end.evaluation.misfit) {
                    end = {std::move(unit), std::move(e)};
                }
                return Answer::computed;
            } catch (...) {
                failure = std::current_exception();
                return Answer::stop;
            }
        };
        std::vector<double> start;
        start.reserve(axes.size());
        for (const std::size_t k : axes) {
            start.push_back(from[k]);
        }
        optimise::gauss_newton(start, objective, search_settings);
        if (failure) {
            std::rethrow_exception(failure);
        }
    });
    computed_ += engine.tally().computed;
    return finished ? std::optional(std::move(end)) : std::nullopt;
}

std::optional<RoadEnd> RoadStations::search_together(const std::vector<std::size_t>& which,
                                                     std::vector<RoadPoint>& points, int number) {
    RoadEnd end;
    std::vector<std::vector<double>> start;
    for (const std::size_t i : which) {
        end.blocks.push_back(layout_.blocks[i]);
        start.push_back(points[i].unit);
    }
    // Priors of common unknowns count once.
    const auto& axes = tasks_[which[0]].study.space.axes;
    optimise::ArrowBlock known;
    std::vector<const problem::Axis*> known_axes;
    std::vector<double> known_start;
    for (std::size_t c = 0; c < layout_.common.size(); ++c) {
        const std::size_t axis = layout_.common[c].axis;
        const auto user = std::find_if(which.begin(), which.end(), [&](std::size_t i) {
            return layout_.blocks[i].common[axis] == static_cast<int>(c);
        });
        if (axes[axis].prior && user != which.end()) {
            known.common.push_back(static_cast<int>(c));
            known_axes.push_back(&axes[axis]);
            known_start.push_back(points[*user].unit[axis]);
        }
    }
    if (!known_axes.empty()) {
        end.blocks.push_back(known);
        start.push_back(known_start);
    }
    std::vector<int> round(which.size(), 0);
    std::vector<RoadPoint> latest(which.size());
    const optimise::ArrowObjective objective = [&](std::size_t b, std::span<const double> unit,
                                                   optimise::Sample& sample) {
        if (b == which.size()) {
            const auto n = static_cast<Index>(known_axes.size());
            sample.residuals.resize(n);
            sample.jacobian = Eigen::MatrixXd::Zero(n, n);
            for (Index k = 0; k < n; ++k) {
                const auto at = static_cast<std::size_t>(k);
                sample.residuals[k] = known_axes[at]->pull(known_axes[at]->physical(unit[at]));
                sample.jacobian(k, k) = known_axes[at]->d_pull();
            }
            return Answer::computed;
        }
        auto e = evaluate(which[b], unit, number + round[b]++);
        if (!e) {
            return Answer::stop;
        }
        if (!e->converged()) {
            return Answer::no_answer;
        }
        sample = run::sample_of(tasks_[which[b]].problem, *e);
        latest[b] = {{unit.begin(), unit.end()}, std::move(*e)};
        return Answer::computed;
    };
    end.search = optimise::arrow_gauss_newton(
        end.blocks, std::move(start), objective,
        [&](std::size_t count, const std::function<void(std::size_t)>& body) { for_each(count, body); },
        search_settings);
    if (end.search.stopped || run::interrupted()) {
        return std::nullopt;
    }
    if (end.search.unit.empty()) {
        return end;
    }
    // The last round is not always the best.
    const bool finished = for_each(which.size(), [&](std::size_t b) {
        RoadPoint& point = points[which[b]];
        point.unit = end.search.unit[b];
        if (latest[b].unit == point.unit) {
            point.evaluation = std::move(latest[b].evaluation);
        } else if (auto e = evaluate(which[b], point.unit, number + round[b])) {
            point.evaluation = std::move(*e);
        }
    });
    return finished ? std::optional(std::move(end)) : std::nullopt;
}

Eigen::MatrixXd RoadStations::normal(std::size_t i, const RoadPoint& point) const {
    const Eigen::MatrixXd jacobian = tasks_[i].problem.residual_jacobian(point.evaluation);
    return jacobian.transpose() * jacobian;
}

Eigen::VectorXd RoadStations::gradient(std::size_t i, const RoadPoint& point) const {
    return tasks_[i].problem.residual_jacobian(point.evaluation).transpose() *
           tasks_[i].problem.residuals(point.evaluation);
}

} // namespace explore::analysis

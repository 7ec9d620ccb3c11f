#include "landscape/pair_profile.h"

#include "optimise/gauss_newton.h"
#include "run/least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double negligible = 0.01;          // rise of chi2 that no figure shows
constexpr double negligible_relative = 1e-3; // and as a share of it, far from the minimum
constexpr int most_waves_again = 60;

struct Node {
    bool found = false;
    double chi2 = std::numeric_limits<double>::infinity();
    std::vector<double> unit;
    problem::Evaluation evaluation; // with jacobian
    std::vector<std::size_t> tried; // neighbours that it was started from
    bool look = true;               // it or a neighbour has changed since its neighbours were compared with it
};

// A slice while it is made.
struct Work {
    std::vector<std::size_t> axes;
    std::vector<std::vector<double>> lines;
    std::vector<Node> nodes;
    int first_start = 0;

    std::size_t width() const { return lines[0].size(); }
    std::size_t height() const { return lines.size() > 1 ? lines[1].size() : 1; }
    std::vector<double> held(std::size_t node) const {
        std::vector<double> values{lines[0][node % width()]};
        if (axes.size() > 1) {
            values.push_back(lines[1][node / width()]);
        }
        return values;
    }
    std::size_t nearest(const std::vector<double>& unit) const {
        std::size_t node = 0;
        double best = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto at = held(i);
            double distance = 0.0;
            for (std::size_t a = 0; a < axes.size(); ++a) {
                distance += std::pow(at[a] - unit[axes[a]], 2);
            }
            if (distance < best) {
                best = distance;
                node = i;
            }
        }
        return node;
    }
    std::vector<std::size_t> neighbours(std::size_t node) const {
        const auto i = static_cast<int>(node % width());
        const auto j = static_cast<int>(node / width());
        std::vector<std::size_t> found;
        for (int dj = -1; dj <= 1; ++dj) {
            for (int di = -1; di <= 1; ++di) {
                const int x = i + di;
                const int y = j + dj;
                if ((di != 0 || dj != 0) && x >= 0 && y >= 0 && x < static_cast<int>(width()) &&
                    y < static_cast<int>(height())) {
                    found.push_back(static_cast<std::size_t>(y) * width() + static_cast<std::size_t>(x));
                }
            }
        }
        return found;
    }
};

// The work of a wave: a node, and the points it may start from, the most promising first.
struct Task {
    std::size_t slice = 0, node = 0;
    std::vector<std::vector<double>> starts;
    int chain = 0;
    Node result{};
};

class Landscape {
public:
    Landscape(run::Engine& engine, const problem::Problem& problem, const Acceptance& acceptance)
        : engine_(engine),
          problem_(problem),
          acceptance_(acceptance) {}

    void add(std::vector<std::size_t> axes, std::vector<std::vector<double>> lines) {
        Work work{std::move(axes), std::move(lines), {}, 0};
        work.nodes.resize(work.width() * work.height());
        slices_.push_back(std::move(work));
    }

    bool compute(const std::vector<std::vector<double>>& minima, int first_start) {
        next_chain_ = first_start;
        std::vector<Task> wave;
        for (std::size_t s = 0; s < slices_.size(); ++s) {
            for (const auto& unit : minima) {
                const std::size_t node = slices_[s].nearest(unit);
                const auto same = std::find_if(wave.begin(), wave.end(),
                                               [&](const Task& t) { return t.slice == s && t.node == node; });
                if (same == wave.end()) {
                    wave.push_back({s, node, {with_held(slices_[s], node, unit)}, next_chain_++});
                } else {
                    same->starts.push_back(with_held(slices_[s], node, unit));
                }
            }
        }
        bool all_starts = true; // of a minimum each: they may lead to different fits
        while (!wave.empty()) {
            if (!run(wave, all_starts)) {
                return false;
            }
            all_starts = false;
            wave = outwards();
        }
        for (int again = 0; again < most_waves_again; ++again) {
            wave = across_branches();
            if (wave.empty()) {
                break;
            }
            if (!run(wave, false)) {
                return false;
            }
        }
        return true;
    }

    std::vector<Work>& slices() { return slices_; }

private:
    static std::vector<double> with_held(const Work& work, std::size_t node, std::vector<double> unit) {
        const auto held = work.held(node);
        for (std::size_t a = 0; a < work.axes.size(); ++a) {
            unit[work.axes[a]] = held[a];
        }
        return unit;
    }

    std::vector<Index> others(const Work& work) const {
        std::vector<Index> open;
        for (std::size_t k = 0; k < problem_.space.axes.size(); ++k) {
            if (std::find(work.axes.begin(), work.axes.end(), k) == work.axes.end()) {
                open.push_back(static_cast<Index>(k));
            }
        }
        return open;
    }

    // The point of `node` that the linear model of a neighbour predicts as the lowest there, and its chi2 by that
    // model, times the variance.
    struct Predicted {
        std::vector<double> unit;
        double squares = 0.0;
    };
    Predicted predict(const Work& work, std::size_t node, const Node& from) const {
        std::vector<double> unit = with_held(work, node, from.unit);
        const VectorXd residuals = problem_.residuals(from.evaluation);
        const MatrixXd jacobian = problem_.residual_jacobian(from.evaluation);
        VectorXd move = VectorXd::Zero(static_cast<Index>(unit.size()));
        for (const std::size_t a : work.axes) {
            move[static_cast<Index>(a)] = unit[a] - from.unit[a];
        }
        const VectorXd held_moved = residuals + jacobian * move;
        std::vector<Index> open = others(work);
        // Parameters that would leave the box stay at its wall, one after the other.
        while (!open.empty()) {
            const MatrixXd j = jacobian(Eigen::all, open);
            MatrixXd h = j.transpose() * j;
            h.diagonal().array() += acceptance_.variance + 1e-6 * h.diagonal().maxCoeff();
            const VectorXd step = -h.llt().solve(j.transpose() * (residuals + jacobian * move));
            Index out = -1;
            for (std::size_t i = 0; i < open.size(); ++i) {
                const auto k = static_cast<std::size_t>(open[i]);
                const double to = from.unit[k] + step[static_cast<Index>(i)];
                if (to < 0.0 || to > 1.0) {
                    move[open[i]] = std::clamp(to, 0.0, 1.0) - from.unit[k];
                    out = static_cast<Index>(i);
                    break;
                }
            }
            if (out < 0) {
                move(open) = step;
                break;
            }
            open.erase(open.begin() + out);
        }
        for (const Index k : others(work)) {
            const auto i = static_cast<std::size_t>(k);
            unit[i] = std::clamp(from.unit[i] + move[k], 0.0, 1.0);
        }
        return {std::move(unit), (residuals + jacobian * move).squaredNorm()};
    }

    // Nodes beside those that were found. Each starts from its lowest neighbours.
    std::vector<Task> outwards() {
        std::vector<Task> wave;
        for (std::size_t s = 0; s < slices_.size(); ++s) {
            Work& work = slices_[s];
            for (std::size_t n = 0; n < work.nodes.size(); ++n) {
                if (work.nodes[n].found) {
                    continue;
                }
                std::vector<std::size_t> from;
                for (const std::size_t other : work.neighbours(n)) {
                    const auto& tried = work.nodes[n].tried;
                    if (work.nodes[other].found && std::find(tried.begin(), tried.end(), other) == tried.end()) {
                        from.push_back(other);
                    }
                }
                if (from.empty()) {
                    continue;
                }
                std::stable_sort(from.begin(), from.end(),
                                 [&](std::size_t a, std::size_t b) { return work.nodes[a].chi2 < work.nodes[b].chi2; });
                constexpr std::size_t most = 2;
                from.resize(std::min(from.size(), most));
                Task task{s, n, {}, next_chain_++};
                for (const std::size_t other : from) {
                    task.starts.push_back(predict(work, n, work.nodes[other]).unit);
                    task.starts.push_back(with_held(work, n, work.nodes[other].unit));
                    work.nodes[n].tried.push_back(other);
                }
                wave.push_back(std::move(task));
            }
        }
        return wave;
    }

    // Nodes that a neighbour predicts a fit for which is lower and differs from their own by more than the noise.
    std::vector<Task> across_branches() {
        std::vector<Task> wave;
        for (std::size_t s = 0; s < slices_.size(); ++s) {
            Work& work = slices_[s];
            const std::vector<Index> open = others(work);
            if (open.empty()) {
                continue;
            }
            for (std::size_t n = 0; n < work.nodes.size(); ++n) {
                Node& node = work.nodes[n];
                if (!node.found || !node.look) {
                    continue;
                }
                const MatrixXd jacobian = problem_.residual_jacobian(node.evaluation);
                std::size_t best = work.nodes.size();
                Predicted lowest;
                for (const std::size_t other : work.neighbours(n)) {
                    const bool again = std::find(node.tried.begin(), node.tried.end(), other) != node.tried.end();
                    if (!work.nodes[other].found || again) {
                        continue;
                    }
                    Predicted predicted = predict(work, n, work.nodes[other]);
                    VectorXd apart = VectorXd::Zero(jacobian.cols());
                    for (const Index k : open) {
                        const auto i = static_cast<std::size_t>(k);
                        apart[k] = predicted.unit[i] - node.unit[i];
                    }
                    const double chi2 = predicted.squares / acceptance_.variance;
                    const double significant = std::max(0.2, 0.05 * node.chi2);
                    if ((jacobian * apart).squaredNorm() / acceptance_.variance > significant &&
                        chi2 < node.chi2 - negligible && (best == work.nodes.size() || chi2 < lowest.squares)) {
                        best = other;
                        lowest = {std::move(predicted.unit), chi2};
                    }
                }
                if (best < work.nodes.size()) {
                    node.tried.push_back(best);
                    wave.push_back({s, n, {std::move(lowest.unit)}, next_chain_++});
                } else {
                    node.look = false;
                }
            }
        }
        return wave;
    }

    // every_start: the lowest end of all starts, not that of the first with an answer.
    bool run(std::vector<Task>& wave, bool every_start) {
        const bool finished =
            engine_.chains("landscape", wave[0].chain, wave.size(), [&](std::size_t i, run::Chain& c) {
                for (const auto& start : wave[i].starts) {
                    Node found = fit(slices_[wave[i].slice], start, c);
                    if (found.found && found.chi2 < wave[i].result.chi2) {
                        wave[i].result = std::move(found);
                    }
                    if (wave[i].result.found && !every_start) {
                        break;
                    }
                }
            });
        if (!finished) {
            return false;
        }
        for (Task& task : wave) {
            Work& work = slices_[task.slice];
            Node& node = work.nodes[task.node];
            const bool gains =
                task.result.found && (!node.found || task.result.chi2 < node.chi2 - 0.5 * tolerance(node.chi2));
            if (gains) {
                // Its neighbours may now start from it once more.
                for (const std::size_t other : work.neighbours(task.node)) {
                    Node& beside = work.nodes[other];
                    if (beside.found) {
                        std::erase(beside.tried, task.node);
                        beside.look = true;
                    }
                }
                node = std::move(task.result);
            }
        }
        return true;
    }

    static double tolerance(double chi2) { return std::max(negligible, negligible_relative * chi2); }

    Node fit(const Work& work, const std::vector<double>& start, run::Chain& chain) const {
        const std::vector<Index> open = others(work);
        Node node;
        const auto keep = [&](const std::vector<double>& unit, problem::Evaluation e) {
            const double chi2 = e.misfit * e.misfit / acceptance_.variance;
            if (!node.found || chi2 < node.chi2) {
                node.found = true;
                node.chi2 = chi2;
                node.unit = unit;
                node.evaluation = std::move(e);
            }
        };
        if (open.empty()) {
            problem::Evaluation e = chain.at(start);
            if (e.converged()) {
                keep(start, std::move(e));
            }
            return node;
        }
        std::vector<double> unit = start;
        std::vector<double> from;
        from.reserve(open.size());
        for (const Index k : open) {
            from.push_back(start[static_cast<std::size_t>(k)]);
        }
        std::exception_ptr failure;
        const optimise::Objective objective = [&](std::span<const double> at, optimise::Sample& sample) {
            for (std::size_t i = 0; i < open.size(); ++i) {
                unit[static_cast<std::size_t>(open[i])] = at[i];
            }
            try {
                problem::Evaluation e = chain.at(unit);
                if (!e.converged()) {
                    return optimise::Answer::no_answer;
                }
                sample = run::sample_of(problem_, e);
                sample.jacobian = MatrixXd(sample.jacobian(Eigen::all, open));
                sample.limit_jacobian = MatrixXd(sample.limit_jacobian(Eigen::all, open));
                keep(unit, std::move(e));
                return optimise::Answer::computed;
            } catch (...) { // no exception crosses the optimiser
                failure = std::current_exception();
                return optimise::Answer::stop;
            }
        };
        optimise::SearchSettings settings;
        settings.max_evaluations = 25;
        settings.enough = 0.25 * negligible * acceptance_.variance;
        settings.misfit_tolerance = 0.25 * negligible_relative;
        settings.first_step = optimise::whole_cube;
        optimise::gauss_newton(from, objective, settings);
        if (failure) {
            std::rethrow_exception(failure);
        }
        return node;
    }

    run::Engine& engine_;
    const problem::Problem& problem_;
    const Acceptance& acceptance_;
    std::vector<Work> slices_;
    int next_chain_ = 0;
};

} // namespace

std::vector<double> profile_lines(int count, double best, const Reach& reach) {
    // Lines at equal steps of F(u) = u/2 + share of the window below u / 2.
    const double margin = 0.25 * std::max(reach.high - reach.low, 0.04);
    const double low = std::max(0.0, reach.low - margin);
    const double high = std::min(1.0, reach.high + margin);
    std::vector<double> lines;
    for (int i = 0; i < count; ++i) {
        const double wanted = static_cast<double>(i) / (count - 1);
        double below = 0.0;
        double above = 1.0;
        for (int halved = 0; halved < 60; ++halved) {
            const double u = 0.5 * (below + above);
            const double f = 0.5 * u + 0.5 * std::clamp((u - low) / (high - low), 0.0, 1.0);
            (f < wanted ? below : above) = u;
        }
        lines.push_back(0.5 * (below + above));
    }
    lines.front() = 0.0;
    lines.back() = 1.0;
    const auto nearest = std::min_element(lines.begin(), lines.end(),
                                          [&](double a, double b) { return std::abs(a - best) < std::abs(b - best); });
    if (nearest != lines.begin() && nearest + 1 != lines.end()) {
        *nearest = best;
    } else if (std::abs(*nearest - best) > 1e-9) { // between a bound and its neighbour: that one moves
        *(nearest == lines.begin() ? nearest + 1 : nearest - 1) = best;
    }
    return lines;
}

std::optional<ProfiledLandscape> profiled_landscape(run::Engine& engine, const problem::Problem& problem,
                                                    const Acceptance& acceptance,
                                                    const std::vector<std::vector<double>>& minima, double best_misfit,
                                                    const std::vector<Reach>& reach,
                                                    const PairProfileSettings& settings) {
    const std::size_t d = problem.space.axes.size();
    const double pairs = 0.5 * static_cast<double>(d * (d - 1));
    const int afforded = static_cast<int>(std::sqrt(settings.most_nodes / std::max(1.0, pairs)));
    const int count = std::clamp(afforded, settings.least_lines, settings.most_lines);
    std::vector<std::vector<double>> lines;
    for (std::size_t k = 0; k < d; ++k) {
        lines.push_back(profile_lines(count, minima[0][k], reach[k]));
    }
    Landscape landscape(engine, problem, acceptance);
    for (std::size_t x = 0; x < d && !settings.only; ++x) {
        landscape.add({x}, {profile_lines(2 * count - 1, minima[0][x], reach[x])});
    }
    for (std::size_t x = 0; x < d; ++x) {
        for (std::size_t y = x + 1; y < d; ++y) {
            if (!settings.only || *settings.only == std::pair(x, y)) {
                landscape.add({x, y}, {lines[x], lines[y]});
            }
        }
    }
    if (!landscape.compute(minima, settings.first_start)) {
        return std::nullopt;
    }
    ProfiledLandscape result;
    const double best = best_misfit * best_misfit / acceptance.variance;
    double lowest = best;
    for (const Work& work : landscape.slices()) {
        for (const Node& node : work.nodes) {
            lowest = std::min(lowest, node.chi2);
        }
    }
    result.lower_by = best - lowest;
    for (const Work& work : landscape.slices()) {
        Slice slice{work.axes, work.lines, {}};
        for (const Node& node : work.nodes) {
            slice.rise.push_back(node.found ? node.chi2 - lowest : std::numeric_limits<double>::quiet_NaN());
        }
        (slice.axes.size() == 1 ? result.single : result.pairs).push_back(std::move(slice));
    }
    return result;
}

} // namespace explore::landscape

#include "optimise/arrow_gauss_newton.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace explore::optimise {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::size_t common_unknowns(const std::vector<ArrowBlock>& blocks) {
    int count = 0;
    for (const ArrowBlock& block : blocks) {
        for (const int c : block.common) {
            count = std::max(count, c + 1);
        }
    }
    return static_cast<std::size_t>(count);
}

std::vector<Index> places(const ArrowBlock& block, bool own) {
    std::vector<Index> found;
    for (std::size_t k = 0; k < block.common.size(); ++k) {
        if ((block.common[k] == own_unknown) == own) {
            found.push_back(static_cast<Index>(k));
        }
    }
    return found;
}

// Where each unknown stands: held at a bound of its step (-1 low, 1 high) or open (0).
using Held = std::vector<int>;

// One linear problem: min of d.(H + damping) d / 2 + g.d over all blocks, with bounds of d.
class ArrowSystem {
public:
    ArrowSystem(const std::vector<ArrowBlock>& blocks, std::size_t common)
        : blocks_(blocks),
          common_(static_cast<Index>(common)) {
        for (const ArrowBlock& block : blocks) {
            own_.push_back(places(block, true));
            shared_.push_back(places(block, false));
            std::vector<Index>& to = to_common_.emplace_back();
            for (const Index k : shared_.back()) {
                to.push_back(block.common[static_cast<std::size_t>(k)]);
            }
        }
    }

    // The step of every block; predicted: how much lower the quadratic is there. low, high: of every block's step; of
    // common unknowns any block's.
    std::vector<VectorXd> step(const std::vector<MatrixXd>& matrix, const std::vector<VectorXd>& gradient,
                               const std::vector<VectorXd>& low, const std::vector<VectorXd>& high, double& predicted) {
        std::vector<Held> held(blocks_.size());
        Held common_held(static_cast<std::size_t>(common_), 0);
        VectorXd common_gradient = VectorXd::Zero(common_);
        VectorXd common_low = VectorXd::Zero(common_);
        VectorXd common_high = VectorXd::Zero(common_);
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            common_gradient(to_common_[b]) += gradient[b](shared_[b]);
            common_low(to_common_[b]) = low[b](shared_[b]);
            common_high(to_common_[b]) = high[b](shared_[b]);
            held[b].assign(blocks_[b].common.size(), 0);
            for (const Index k : own_[b]) {
                held[b][static_cast<std::size_t>(k)] = at_first(gradient[b][k], low[b][k], high[b][k]);
            }
        }
        for (Index c = 0; c < common_; ++c) {
            common_held[static_cast<std::size_t>(c)] = at_first(common_gradient[c], common_low[c], common_high[c]);
        }
        constexpr int rounds = 60;
        constexpr int with_release = 20; // then bounds are only added, so that it ends
        std::vector<VectorXd> d;
        for (int round = 0; round < rounds; ++round) {
            d = solve(matrix, gradient, low, high, held, common_low, common_high, common_held);
            bool changed = false;
            VectorXd common_slope = VectorXd::Zero(common_);
            VectorXd common_step = VectorXd::Zero(common_);
            predicted = 0.0;
            for (std::size_t b = 0; b < blocks_.size(); ++b) {
                const VectorXd pull = matrix[b] * d[b];
                const VectorXd slope = gradient[b] + pull;
                predicted -= gradient[b].dot(d[b]) + 0.5 * pull.dot(d[b]);
                common_slope(to_common_[b]) += slope(shared_[b]);
                common_step(to_common_[b]) = d[b](shared_[b]);
                for (const Index k : own_[b]) {
                    changed |= move(held[b][static_cast<std::size_t>(k)], d[b][k], low[b][k], high[b][k], slope[k],
                                    round < with_release);
                }
            }
            for (Index c = 0; c < common_; ++c) {
                changed |= move(common_held[static_cast<std::size_t>(c)], common_step[c], common_low[c], common_high[c],
                                common_slope[c], round < with_release);
            }
            if (!changed) {
                break;
            }
        }
        return d;
    }

private:
    static int at_first(double gradient, double low, double high) {
        return gradient > 0.0 && low >= 0.0 ? -1 : gradient < 0.0 && high <= 0.0 ? 1 : 0;
    }

    // Whether an unknown has to be held or let go.
    static bool move(int& held, double d, double low, double high, double slope, bool release) {
        if (held == 0) {
            held = d < low ? -1 : d > high ? 1 : 0;
            return held != 0;
        }
        if (release && held * slope > 0.0) { // at the lower bound a falling quadratic, at the upper a rising one
            held = 0;
            return true;
        }
        return false;
    }

    std::vector<VectorXd> solve(const std::vector<MatrixXd>& matrix, const std::vector<VectorXd>& gradient,
                                const std::vector<VectorXd>& low, const std::vector<VectorXd>& high,
                                const std::vector<Held>& held, const VectorXd& common_low, const VectorXd& common_high,
                                const Held& common_held) const {
        const std::size_t n = blocks_.size();
        std::vector<VectorXd> d(n);
        std::vector<std::vector<Index>> open(n);
        std::vector<VectorXd> alone(n);     // step of the open own unknowns for a common step of 0
        std::vector<MatrixXd> following(n); // and its change with the common step
        MatrixXd schur = MatrixXd::Zero(common_, common_);
        VectorXd right = VectorXd::Zero(common_);
        for (std::size_t b = 0; b < n; ++b) {
            d[b] = VectorXd::Zero(gradient[b].size());
            for (const Index k : own_[b]) {
                const int at = held[b][static_cast<std::size_t>(k)];
                if (at == 0) {
                    open[b].push_back(k);
                } else {
                    d[b][k] = at > 0 ? high[b][k] : low[b][k];
                }
            }
            const VectorXd slope = gradient[b] + matrix[b] * d[b];
            const MatrixXd across = matrix[b](open[b], shared_[b]);
            MatrixXd here = matrix[b](shared_[b], shared_[b]);
            VectorXd pull = -slope(shared_[b]);
            if (!open[b].empty()) {
                const MatrixXd own_matrix = matrix[b](open[b], open[b]);
                const Eigen::LLT<MatrixXd> factor(own_matrix);
                const VectorXd own_slope = -slope(open[b]);
                alone[b] = factor.solve(own_slope);
                following[b] = -factor.solve(across);
                here += across.transpose() * following[b];
                pull -= across.transpose() * alone[b];
            }
            schur(to_common_[b], to_common_[b]) += here;
            right(to_common_[b]) += pull;
        }
        const VectorXd common_step = solve_common(schur, right, common_low, common_high, common_held);
        for (std::size_t b = 0; b < n; ++b) {
            const VectorXd part = common_step(to_common_[b]);
            d[b](shared_[b]) = part;
            if (!open[b].empty()) {
                d[b](open[b]) = alone[b] + following[b] * part;
            }
        }
        return d;
    }

    VectorXd solve_common(const MatrixXd& schur, const VectorXd& right, const VectorXd& low, const VectorXd& high,
                          const Held& held) const {
        VectorXd step = VectorXd::Zero(common_);
        std::vector<Index> open;
        for (Index c = 0; c < common_; ++c) {
            const int at = held[static_cast<std::size_t>(c)];
            if (at == 0) {
                open.push_back(c);
            } else {
                step[c] = at > 0 ? high[c] : low[c];
            }
        }
        if (!open.empty()) {
            const VectorXd rest = right - schur * step;
            const VectorXd open_rest = rest(open);
            const MatrixXd part = schur(open, open);
            const VectorXd found = part.llt().solve(open_rest);
            step(open) = found;
        }
        return step;
    }

    const std::vector<ArrowBlock>& blocks_;
    Index common_;
    std::vector<std::vector<Index>> own_, shared_, to_common_; // of each block
};

// The factors of the blocks kept at a point.
struct Round {
    std::vector<MatrixXd> normal;
    std::vector<VectorXd> gradient;
    std::vector<double> squares;
    Answer answer = Answer::computed;

    double half() const {
        double sum = 0.0;
        for (const double s : squares) {
            sum += 0.5 * s;
        }
        return sum;
    }
};

Round round_at(const std::vector<std::vector<double>>& unit, const ArrowObjective& objective, const ForEach& for_each) {
    const std::size_t n = unit.size();
    Round round{.normal = std::vector<MatrixXd>(n), .gradient = std::vector<VectorXd>(n), .squares = {}};
    round.squares.assign(n, 0.0);
    std::vector<Answer> answers(n, Answer::stop);
    for_each(n, [&](std::size_t b) {
        Sample sample;
        answers[b] = objective(b, unit[b], sample);
        if (answers[b] == Answer::computed) {
            round.normal[b] = sample.jacobian.transpose() * sample.jacobian;
            round.gradient[b] = sample.jacobian.transpose() * sample.residuals;
            round.squares[b] = sample.residuals.squaredNorm();
        }
    });
    for (const Answer answer : answers) {
        if (answer == Answer::stop || (answer == Answer::no_answer && round.answer == Answer::computed)) {
            round.answer = answer;
        }
    }
    return round;
}

} // namespace

ArrowResult arrow_gauss_newton(const std::vector<ArrowBlock>& blocks, std::vector<std::vector<double>> start,
                               const ArrowObjective& objective, const ForEach& for_each,
                               const SearchSettings& settings) {
    ArrowSystem system(blocks, common_unknowns(blocks));
    ArrowResult result;
    std::vector<std::vector<double>> point = std::move(start);
    Round here = round_at(point, objective, for_each);
    result.rounds = 1;
    if (here.answer != Answer::computed) {
        result.stopped = here.answer == Answer::stop;
        result.ended = result.stopped ? "stopped" : "the start has no answer";
        return result;
    }
    // The mean over the blocks, as each adds its damping.
    double damping = 0.0;
    for (const MatrixXd& normal : here.normal) {
        damping += settings.damping * normal.diagonal().maxCoeff() / static_cast<double>(blocks.size());
    }
    double raise = 2.0;
    double half = here.half();
    while (true) {
        if (half < 1e-24) {
            result.converged = true;
            result.ended = "an exact fit";
            break;
        }
        std::vector<MatrixXd> damped = here.normal;
        std::vector<VectorXd> low;
        std::vector<VectorXd> high;
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            damped[b].diagonal().array() += damping + 1e-14 * (1.0 + here.normal[b].diagonal().maxCoeff());
            const Eigen::Map<const VectorXd> unit(point[b].data(), static_cast<Index>(point[b].size()));
            low.emplace_back(-unit);
            high.emplace_back(1.0 - unit.array());
        }
        double predicted = 0.0;
        const std::vector<VectorXd> step = system.step(damped, here.gradient, low, high, predicted);
        double longest = 0.0;
        for (const VectorXd& d : step) {
            longest = std::max(longest, d.cwiseAbs().maxCoeff());
        }
        if (predicted <= std::max(settings.misfit_tolerance * half, settings.enough)) {
            result.converged = true;
            result.ended = "the misfit no longer changes";
            break;
        }
        if (longest < settings.step_tolerance) {
            result.converged = true;
            result.ended = "the parameters no longer change";
            break;
        }
        if (result.rounds >= settings.max_evaluations) {
            result.ended = "the limit of evaluations";
            break;
        }
        std::vector<std::vector<double>> trial = point;
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            for (std::size_t k = 0; k < trial[b].size(); ++k) {
                trial[b][k] = std::clamp(point[b][k] + step[b][static_cast<Index>(k)], 0.0, 1.0);
            }
        }
        Round there = round_at(trial, objective, for_each);
        ++result.rounds;
        if (there.answer == Answer::stop) {
            result.stopped = true;
            result.ended = "stopped";
            break;
        }
        const double gain = there.answer == Answer::computed ? (half - there.half()) / predicted : -INFINITY;
        if (!(gain > 1e-4)) {
            damping *= raise;
            raise *= 2.0;
            continue;
        }
        damping *= std::max(1.0 / 10.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
        raise = 2.0;
        point = std::move(trial);
        here = std::move(there);
        half = here.half();
    }
    result.unit = std::move(point);
    result.squares = std::move(here.squares);
    result.normal = std::move(here.normal);
    return result;
}

ArrowCovariance arrow_covariance(const std::vector<ArrowBlock>& blocks, const std::vector<MatrixXd>& normal) {
    constexpr double least = 1e-6;
    const auto count = static_cast<Index>(common_unknowns(blocks));
    ArrowCovariance result{.information = MatrixXd::Identity(count, count) * least, .common = {}, .blocks = {}};
    struct Part {
        std::vector<Index> own, shared, to;
        MatrixXd alone, following; // covariance of the own unknowns for fixed common ones; how they follow those
    };
    std::vector<Part> parts;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        Part& part = parts.emplace_back(Part{places(blocks[b], true), places(blocks[b], false), {}, {}, {}});
        for (const Index k : part.shared) {
            part.to.push_back(blocks[b].common[static_cast<std::size_t>(k)]);
        }
        MatrixXd own = normal[b](part.own, part.own);
        own.diagonal().array() += least;
        const MatrixXd across = normal[b](part.own, part.shared);
        const auto n = static_cast<Index>(part.own.size());
        if (n > 0) {
            part.alone = own.llt().solve(MatrixXd::Identity(n, n));
        }
        part.following = -part.alone * across;
        result.information(part.to, part.to) +=
            normal[b](part.shared, part.shared) + across.transpose() * part.following;
    }
    if (count > 0) {
        result.common = result.information.llt().solve(MatrixXd::Identity(count, count));
    }
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const Part& part = parts[b];
        const auto n = static_cast<Index>(blocks[b].common.size());
        MatrixXd& covariance = result.blocks.emplace_back(n, n);
        const MatrixXd common = result.common(part.to, part.to);
        covariance(part.shared, part.shared) = common;
        covariance(part.own, part.shared) = part.following * common;
        covariance(part.shared, part.own) = common * part.following.transpose();
        covariance(part.own, part.own) = part.alone + part.following * common * part.following.transpose();
    }
    return result;
}

} // namespace explore::optimise

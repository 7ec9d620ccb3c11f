#include "landscape/output_walks.h"

#include "inference/kriging.h"

#include <algorithm>
#include <cmath>

namespace explore::landscape {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using inference::KnownPoint;
using inference::Kriging;

constexpr int most_walk_rounds = 8;
constexpr int chains_of_round = 5'000;
constexpr double close_enough = 0.002; // of the range of an output: how far runs may be from what was expected
constexpr double same_point = 1e-6;    // in every unit coordinate

class BetweenRuns {
public:
    BetweenRuns(const UniquenessTask& task, const Acceptance& acceptance, const std::vector<Minimum>& from, int first)
        : task_(task),
          acceptance_(acceptance),
          from_(from),
          first_(first),
          branches_(2 * from.size() * task.outputs.size()) {}

    std::optional<OutputWalks> walk(const std::vector<Minimum>& complete) {
        for (const Minimum& minimum : complete) {
            add(minimum.evaluation);
        }
        for (std::size_t i = 0; i < branches_.size(); ++i) {
            open_.push_back(i);
        }
        for (int round = 0; round < most_walk_rounds; ++round) {
            if (!walk_between(round)) {
                return std::nullopt;
            }
            if (std::any_of(branches_.begin(), branches_.end(),
                            [](const Branch& b) { return b.end == WalkEnd::better; })) {
                return OutputWalks{std::move(branches_), {}}; // what is walked to from there will count
            }
            const auto have_answers = run_ends(round);
            if (!have_answers) {
                return std::nullopt;
            }
            if (!*have_answers) {
                return OutputWalks{};
            }
            settle(round > 0);
            if (open_.empty()) {
                auto between = std::make_shared<Kriging>(known_);
                take_over(*between);
                return OutputWalks{std::move(branches_), [between](const std::vector<double>& unit) -> VectorXd {
                                       return between->at(unit, false).values;
                                   }};
            }
        }
        return OutputWalks{};
    }

private:
    std::size_t output_of(std::size_t branch) const { return branch / (2 * from_.size()); }

    // A run of everything, unless one was made there. Its values by unit coordinates.
    void add(const problem::Evaluation& e) {
        KnownPoint point{.unit = task_.everything.space.unit(e.parameters), .values = {}, .slopes = {}};
        const auto count = static_cast<Index>(task_.outputs.size());
        point.values.resize(count);
        point.slopes.resize(count, static_cast<Index>(point.unit.size()));
        for (Index o = 0; o < count; ++o) {
            const Quantity output = response(task_.everything.space, task_.outputs[static_cast<std::size_t>(o)]);
            point.values[o] = output.value(point.unit, e);
            point.slopes.row(o) = output.gradient(point.unit, e).transpose();
        }
        known_.push_back(std::move(point));
    }

    const KnownPoint* known_at(const std::vector<double>& unit) const {
        const auto found = std::find_if(known_.begin(), known_.end(), [&](const KnownPoint& known) {
            return std::equal(unit.begin(), unit.end(), known.unit.begin(),
                              [](double a, double b) { return std::abs(a - b) < same_point; });
        });
        return found == known_.end() ? nullptr : &*found;
    }

    bool walk_between(int round) {
        const Kriging between(known_);
        const auto quantity = [&](std::size_t output) {
            const auto o = static_cast<Index>(output);
            return Quantity{[&between, o](const std::vector<double>& unit, const problem::Evaluation&) {
                                return between.at(unit, false).values[o];
                            },
                            [&between, o](const std::vector<double>& unit, const problem::Evaluation&) -> VectorXd {
                                return between.at(unit, true).slopes.row(o).transpose();
                            }};
        };
        return task_.fitted_engine.chains(
            "outputs", first_ + round * chains_of_round, open_.size(), [&](std::size_t k, run::Chain& chain) {
                const std::size_t i = open_[k];
                branches_[i] = landscape::walk(chain, task_.fitted, acceptance_, from_[(i / 2) % from_.size()],
                                               from_[0].evaluation.misfit, quantity(output_of(i)), i % 2 == 0 ? -1 : 1);
            });
    }

    // Runs of everything at the ends of open branches; whether all have answers. Nothing: interrupted.
    std::optional<bool> run_ends(int round) {
        std::vector<std::vector<double>> wanted;
        for (const std::size_t i : open_) {
            const std::vector<double>& unit = branches_[i].limit_unit;
            if (known_at(unit) == nullptr && std::find(wanted.begin(), wanted.end(), unit) == wanted.end()) {
                wanted.push_back(unit);
            }
        }
        std::vector<problem::Evaluation> runs(wanted.size());
        if (!task_.everything_engine.chains("outputs", first_ + (most_walk_rounds + round) * chains_of_round,
                                            wanted.size(),
                                            [&](std::size_t i, run::Chain& chain) { runs[i] = chain.at(wanted[i]); })) {
            return std::nullopt;
        }
        for (std::size_t i = 0; i < runs.size(); ++i) {
            if (!runs[i].converged()) {
                return false;
            }
            if (known_at(wanted[i]) == nullptr) {
                add(runs[i]);
            }
        }
        return true;
    }

    // Closes the branches whose end the run there confirms, at a value that is the one of the round before.
    void settle(bool has_before) {
        std::vector<double> there(branches_.size());
        for (std::size_t i = 0; i < branches_.size(); ++i) {
            there[i] = known_at(branches_[i].limit_unit)->values[static_cast<Index>(output_of(i))];
        }
        std::erase_if(open_, [&](std::size_t i) {
            const std::size_t of_output = 2 * from_.size();
            const auto begin = there.begin() + static_cast<std::ptrdiff_t>(output_of(i) * of_output);
            const auto [low, high] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(of_output));
            constexpr double least = 1e-9; // of the value: an output that does not depend on the parameters
            const double allowed = std::max(close_enough * (*high - *low), least * std::abs(*high));
            return has_before && std::abs(there[i] - branches_[i].limit) <= allowed &&
                   std::abs(there[i] - before_[i]) <= allowed;
        });
        before_ = std::move(there);
    }

    // The points of the branches by all that is known now, their ends by the runs themselves.
    void take_over(const Kriging& between) {
        for (std::size_t i = 0; i < branches_.size(); ++i) {
            const auto o = static_cast<Index>(output_of(i));
            for (ProfilePoint& point : branches_[i].points) {
                point.value =
                    point.unit == branches_[i].limit_unit ? before_[i] : between.at(point.unit, false).values[o];
            }
            branches_[i].limit = before_[i];
        }
    }

    const UniquenessTask& task_;
    const Acceptance& acceptance_;
    const std::vector<Minimum>& from_;
    int first_;
    std::vector<Branch> branches_;
    std::vector<std::size_t> open_; // branches whose ends are not confirmed yet
    std::vector<double> before_;    // the output at the end of each branch, by the runs of the last round
    std::vector<KnownPoint> known_;
};

} // namespace

std::optional<OutputWalks> walk_outputs(const UniquenessTask& task, const Acceptance& acceptance,
                                        const std::vector<Minimum>& from, const std::vector<Minimum>& complete,
                                        int first) {
    return BetweenRuns(task, acceptance, from, first).walk(complete);
}

} // namespace explore::landscape

#include "analysis/design/design_walks.h"

#include "data/hash.h"
#include "inference/kriging.h"
#include "inference/quantiles.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double close_enough = 0.02; // of ln(life), between what was expected at an end and the run there
constexpr int most_rounds = 8;

// A problem of its own for the fit; the strains at the critical places are interpolated between runs of everything.
class BetweenRuns final : public problem::ForwardFunction {
public:
    BetweenRuns(const problem::Problem& fitted, std::size_t first, std::shared_ptr<const inference::Kriging> strains)
        : fitted_(fitted.function),
          space_(fitted.space),
          first_(first),
          strains_(std::move(strains)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return fitted_->make_workspace(); }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> parameters, bool with_jacobian,
                                                Workspace& workspace) const override {
        auto outcome = fitted_->evaluate(parameters, with_jacobian, workspace);
        if (!outcome) {
            return outcome.failure();
        }
        problem::Prediction all = std::move(outcome).value();
        const std::vector<double> unit = space_.unit(parameters);
        const inference::Kriging::Answer there = strains_->at(unit, with_jacobian);
        all.responses.resize(first_);
        all.responses.insert(all.responses.end(), there.values.begin(), there.values.end());
        if (with_jacobian) {
            all.jacobian.conservativeResize(static_cast<Index>(all.responses.size()), Eigen::NoChange);
        }
        for (std::size_t k = 0; with_jacobian && k < unit.size(); ++k) {
            all.jacobian.col(static_cast<Index>(k)).tail(there.values.size()) =
                there.slopes.col(static_cast<Index>(k)) / space_.axes[k].d_physical(unit[k]);
        }
        return all;
    }

private:
    std::shared_ptr<const problem::ForwardFunction> fitted_;
    problem::ParameterSpace space_;
    std::size_t first_; // of the critical places, which follow all others
    std::shared_ptr<const inference::Kriging> strains_;
};

// A run of everything, as a point to interpolate between.
inference::KnownPoint known_point(const problem::ParameterSpace& space, std::size_t first,
                                  const problem::Evaluation& e) {
    inference::KnownPoint point{.unit = space.unit(e.parameters), .values = {}, .slopes = {}};
    const auto count = static_cast<Index>(e.responses.size() - first);
    point.values = Eigen::Map<const VectorXd>(e.responses.data() + first, count);
    point.slopes = e.jacobian.bottomRows(count);
    for (std::size_t k = 0; k < point.unit.size(); ++k) {
        point.slopes.col(static_cast<Index>(k)) *= space.axes[k].d_physical(point.unit[k]);
    }
    return point;
}

class Walks {
public:
    explicit Walks(const LifeWalkTask& task) : task_(task) {}

    std::optional<LifeWalks> run(const problem::Evaluation& best) {
        for (const Life& life : task_.lives) {
            critical_.push_back(life.critical(life.at(best.parameters), best.responses));
        }
        return walk(best) ? std::optional(std::move(found_)) : std::nullopt;
    }

private:
    bool walk(const problem::Evaluation& best) {
        const problem::ParameterSpace& space = task_.everything.space;
        std::vector<std::vector<double>> points{task_.answer.minima[0].unit};
        std::vector<problem::Evaluation> there{best};
        const auto add = [&](const std::vector<double>& unit) {
            const auto at = std::find(points.begin(), points.end(), unit);
            const auto index = static_cast<std::size_t>(at - points.begin());
            if (at == points.end()) {
                points.push_back(unit);
            }
            return index;
        };
        for (const std::size_t m : task_.answer.alternative_of) {
            add(task_.answer.minima[m].unit);
        }
        for (const landscape::Range& range : task_.answer.parameters) {
            for (const auto* set : {&range.low_set, &range.high_set}) {
                if (!set->empty()) {
                    add(space.unit(*set));
                }
            }
        }
        for (int round = 0;; ++round) {
            if (!compute(points, there)) {
                return false;
            }
            if (round > 0) {
                found_.off = 0.0;
                for_each_end([&](std::size_t l, LifeEnd& end, const std::vector<double>& limit) {
                    confirm(l, there[add(limit)], end);
                });
            }
            found_.between = points.size();
            if (round > 0 && (!(found_.off > close_enough) || round == most_rounds)) {
                return true;
            }
            std::vector<inference::KnownPoint> known;
            for (const problem::Evaluation& e : there) {
                if (e.converged()) {
                    known.push_back(known_point(space, task_.places.first, e));
                }
            }
            problem::Problem walked = task_.fitted;
            walked.function = std::make_shared<BetweenRuns>(
                task_.fitted, task_.places.first, std::make_shared<const inference::Kriging>(std::move(known)));
            auto engine = task_.session.engine(walked, task_.session.begin(task_.places.study, "design-walks",
                                                                           settings_at("from between runs", points)));
            if (!walk_of_round(walked, engine)) {
                return false;
            }
            count(engine);
            for_each_end([&](std::size_t, LifeEnd&, const std::vector<double>& limit) { add(limit); });
        }
    }

    // Those of the points that were not computed yet. False: interrupted.
    bool compute(const std::vector<std::vector<double>>& points, std::vector<problem::Evaluation>& there) {
        const search::Design design{"runs that strains are taken from between",
                                    {points.begin() + static_cast<std::ptrdiff_t>(there.size()), points.end()}};
        if (design.points.empty()) {
            return true;
        }
        auto engine = task_.session.engine(task_.everything, task_.session.begin(task_.places.study, "design-runs",
                                                                                 settings_at("runs", design.points)));
        const auto more = engine.evaluate(design, true);
        if (more) {
            std::copy(more->begin(), more->end(), std::back_inserter(there));
            count(engine);
        }
        return more.has_value();
    }

    // The settings that a run of the store depends on.
    std::string settings_at(std::string_view what, const std::vector<std::vector<double>>& points) const {
        std::string text;
        for (const auto& point : points) {
            text += fmt::format("{:a} ", fmt::join(point, " "));
        }
        return fmt::format("{}, {} at {}", task_.settings, what, data::hash_of(text));
    }

    void count(const run::Engine& engine) {
        found_.computed += engine.tally().computed;
        found_.kept += engine.tally().kept;
    }

    // From the minima of that problem next to those of the answer, which a reduced model's are not.
    bool walk_of_round(const problem::Problem& problem, run::Engine& engine) {
        std::vector<std::vector<double>> starts;
        for (const std::size_t m : task_.answer.alternative_of) {
            starts.push_back(task_.answer.minima[m].unit);
        }
        const auto ends = engine.search(starts, *optimise::find_method("gauss-newton"), {});
        if (!ends) {
            return false;
        }
        std::vector<landscape::Minimum> from;
        for (const run::Endpoint& end : *ends) {
            if (!end.search.unit.empty()) {
                landscape::Minimum minimum = task_.answer.minima[task_.answer.alternative_of[from.size()]];
                minimum.unit = end.search.unit;
                minimum.evaluation = end.evaluation;
                from.push_back(std::move(minimum));
            }
        }
        std::stable_sort(from.begin(), from.end(),
                         [](const auto& a, const auto& b) { return a.evaluation.misfit < b.evaluation.misfit; });
        return walk_from(from, problem, engine);
    }

    landscape::Quantity quantity(std::size_t l) const {
        const Life& life = task_.lives[l];
        return {[&life, candidate = critical_[l]](const std::vector<double>&, const problem::Evaluation& e) {
                    return life.log_repetitions(candidate, life.at(e.parameters), e.responses);
                },
                [&life, candidate = critical_[l]](const std::vector<double>& unit, const problem::Evaluation& e)
                    -> VectorXd { return life.gradient(candidate, unit, e); }};
    }

    // To both ends of every life, as that problem has them.
    bool walk_from(const std::vector<landscape::Minimum>& from, const problem::Problem& problem, run::Engine& engine) {
        const std::size_t count = from.size();
        std::vector<landscape::Branch> branches(2 * count * task_.lives.size());
        constexpr int beyond_searches = 1000;
        if (!engine.chains("lives", beyond_searches, branches.size(), [&](std::size_t i, run::Chain& chain) {
                branches[i] =
                    landscape::walk(chain, problem, *task_.answer.acceptance, from[(i / 2) % count],
                                    from[0].evaluation.misfit, quantity(i / (2 * count)), i % 2 == 0 ? -1 : 1);
            })) {
            return false;
        }
        found_.shortest.clear();
        found_.longest.clear();
        limits_.clear();
        for (std::size_t l = 0; l < task_.lives.size(); ++l) {
            for (const std::size_t side : {0, 1}) {
                const std::size_t a = farthest(branches, l, count, side);
                const landscape::Branch& branch = branches[2 * (l * count + a) + side];
                (side == 0 ? found_.shortest : found_.longest).push_back(end_of(branch, from, a, l));
                limits_.push_back(branch.limit_unit);
            }
        }
        return true;
    }

    // Of the walks from all minima; side: 0 to the shortest, 1 to the longest.
    static std::size_t farthest(const std::vector<landscape::Branch>& branches, std::size_t l, std::size_t count,
                                std::size_t side) {
        const double sign = side == 0 ? -1.0 : 1.0;
        std::size_t far = 0;
        for (std::size_t a = 1; a < count; ++a) {
            if (sign * branches[2 * (l * count + a) + side].limit >
                sign * branches[2 * (l * count + far) + side].limit) {
                far = a;
            }
        }
        return far;
    }

    LifeEnd end_of(const landscape::Branch& branch, const std::vector<landscape::Minimum>& from, std::size_t a,
                   std::size_t l) const {
        const landscape::Acceptance& acceptance = *task_.answer.acceptance;
        LifeEnd end;
        end.log_life = branch.limit;
        const double begin = std::max(0.0, acceptance.rise(from[a].evaluation.misfit, from[0].evaluation.misfit));
        end.way.emplace_back(std::sqrt(begin), from[a].unit);
        end.log_lives.push_back(quantity(l).value(from[a].unit, from[a].evaluation));
        const problem::Evaluation* last = &from[a].evaluation;
        for (const landscape::ProfilePoint& p : branch.points) {
            if (p.rise <= acceptance.threshold) {
                end.way.emplace_back(std::sqrt(std::max(p.rise, 0.0)), p.unit);
                end.log_lives.push_back(p.value);
                last = &p.evaluation;
            }
        }
        if (branch.end == landscape::WalkEnd::threshold) {
            end.way.emplace_back(std::sqrt(acceptance.threshold), branch.limit_unit);
            end.log_lives.push_back(branch.limit);
        }
        end.strain = task_.lives[l].strain(critical_[l], last->responses);
        return end;
    }

    // By a run there. Where another place is strained more at that set, its life counts.
    void confirm(std::size_t l, const problem::Evaluation& there, LifeEnd& end) {
        if (!there.converged()) {
            return;
        }
        const Life& life = task_.lives[l];
        const auto at = life.at(there.parameters);
        const double off = life.log_repetitions(critical_[l], at, there.responses) - end.log_life;
        found_.off = std::max(found_.off, std::isnan(off) ? 0.0 : std::abs(off));
        end.strain = life.strain(life.critical(at, there.responses), there.responses);
        end.log_life = life.log_repetitions(at, there.responses);
        end.log_lives.back() = end.log_life;
    }

    void for_each_end(const auto& body) {
        for (std::size_t l = 0; l < task_.lives.size(); ++l) {
            body(l, found_.shortest[l], limits_[2 * l]);
            body(l, found_.longest[l], limits_[2 * l + 1]);
        }
    }

    const LifeWalkTask& task_;
    std::vector<std::size_t> critical_; // of each life, at the best set
    LifeWalks found_;
    std::vector<std::vector<double>> limits_; // sets at the shortest and the longest end of each life
};

} // namespace

std::vector<double> LifeEnd::at(double deviate, double threshold) const {
    const double root = std::sqrt(threshold) * deviate / inference::two_sided_95;
    for (std::size_t i = 1; i < way.size(); ++i) {
        if (root <= way[i].first) {
            const double span = way[i].first - way[i - 1].first;
            const double t = span > 0.0 ? std::max(0.0, (root - way[i - 1].first) / span) : 1.0;
            std::vector<double> unit = way[i - 1].second;
            for (std::size_t k = 0; k < unit.size(); ++k) {
                unit[k] += t * (way[i].second[k] - unit[k]);
            }
            return unit;
        }
    }
    return way.back().second;
}

std::optional<LifeWalks> walk_lives(const LifeWalkTask& task, const problem::Evaluation& best) {
    return Walks(task).run(best);
}

} // namespace explore::analysis

#include "landscape/uniqueness.h"

#include "base/random.h"
#include "landscape/accepted_ends.h"
#include "landscape/confirmation.h"
#include "landscape/multistart.h"
#include "landscape/output_walks.h"
#include "landscape/readings_alone.h"
#include "landscape/walker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace explore::landscape {
namespace {

using Eigen::VectorXd;

// Which start numbers the chains of each part are kept under.
constexpr int chain_range = 100'000;
enum Part { searches, verification, polishing, passes, traces, profiles, predictions, groups, alone, parts };
constexpr int first_of(Part part, int round = 0) {
    return (round * parts + part) * chain_range;
}

// Rounds that are none of the walks': of the comparison of groups, of the searches that follow those of an explorer.
constexpr int groups_round = 99;
constexpr int confirming_round = 98;
static_assert(first_of(parts, groups_round) <= first_start_of_others);

// Among the chains of outputs: walks from the minima where those between runs fail; from the ends of profiles.
constexpr int from_minima = chain_range - 20'000;
constexpr int on_from_profiles = chain_range - 10'000;

constexpr int most_rounds = 4;
constexpr std::string_view search_method = "gauss-newton";

class Analysis {
public:
    Analysis(const UniquenessTask& task, const UniquenessSettings& settings) : task_(task), settings_(settings) {}

    std::optional<Uniqueness> run() {
        if (!explore() || !search()) {
            return std::nullopt;
        }
        if (result_.minima.empty()) {
            result_.missing.push_back(run::why_no_minimum(task_.fitted, result_.explored));
            return std::move(result_);
        }
        // Around minima that a second method moved, once more.
        bool moved = false;
        if (!walk_around(0) || !confirm_minima(moved) || (moved && !(group(), walk_around(most_rounds)))) {
            return std::nullopt;
        }
        if (result_.acceptance) {
            result_.priors = prior_influence(task_.fitted, *result_.acceptance, result_.minima[0]);
        }
        if (result_.acceptance && task_.groups.size() > 1 && !compare_groups()) {
            return std::nullopt;
        }
        classify();
        project();
        judge();
        return std::move(result_);
    }

private:
    // The ranges around the minima. A walk that finds a better minimum begins a new round. False: interrupted.
    bool walk_around(int first_round) {
        for (int i = 0; i < most_rounds; ++i) {
            if (!find_alone(task_.fitted_engine, task_.fitted, result_.minima[0], first_of(alone, first_round + i))) {
                return false;
            }
            result_.acceptance = acceptance_of(task_.fitted, result_.minima[0]);
            if (!result_.acceptance) {
                result_.missing.emplace_back(
                    "the noise of the readings: none is stated, and there are not more readings "
                    "than parameters to estimate it from");
                break;
            }
            std::vector<std::vector<double>> better;
            if (!around_minimum(first_round + i, better)) {
                return false;
            }
            if (better.empty()) {
                break;
            }
            if (i + 1 == most_rounds) {
                result_.missing.emplace_back("the best minimum: walks from the minima kept finding lower ones");
                break;
            }
            if (!polish(better, first_round + i)) {
                return false;
            }
        }
        return true;
    }

    optimise::SearchSettings search_settings() const {
        optimise::SearchSettings s;
        s.max_evaluations = settings_.max_evaluations;
        return s;
    }

    run::Engine& exploring_engine() const { return task_.explorer != nullptr ? *task_.explorer : task_.fitted_engine; }

    bool explore() {
        result_.sample = search::sobol(task_.fitted.space, settings_.explore, task_.seed);
        auto explored = exploring_engine().evaluate(result_.sample, true);
        if (!explored) {
            return false;
        }
        result_.explored = std::move(*explored);
        return true;
    }

    // Searches from the sample's own minima, then from independent starts until enough of them found nothing new.
    bool search() {
        const int dimension = task_.fitted.space.dimension();
        const int neighbours = 2 * dimension;
        std::vector<double> misfit;
        std::vector<VectorXd> gradients;
        for (const auto& e : result_.explored) {
            misfit.push_back(e.misfit);
            gradients.push_back(
                e.converged() ? VectorXd(task_.fitted.residual_jacobian(e).transpose() * task_.fitted.residuals(e))
                              : VectorXd());
        }
        result_.tree = merge_tree(result_.sample.points, misfit, neighbours);
        auto from = unlinked_points(result_.sample.points, misfit, gradients, neighbours);
        if (from.empty()) {
            return true;
        }
        const auto most = static_cast<std::size_t>(std::max(1, settings_.max_searches - settings_.verify));
        from.resize(std::min(from.size(), most));
        std::vector<std::vector<double>> starts;
        starts.reserve(from.size());
        for (const std::size_t i : from) {
            starts.push_back(result_.sample.points[i]);
        }
        const auto& method = *optimise::find_method(search_method);
        auto ends = exploring_engine().search(starts, method, search_settings(), first_of(searches));
        if (!ends) {
            return false;
        }
        ends_ = std::move(*ends);
        const pave::RandomStream random(task_.seed, 0x5eedULL);
        int drawn = 0;
        std::uint64_t numbers = 0;
        while (true) {
            group();
            result_.unseen = count_unseen();
            const int left = settings_.max_searches - static_cast<int>(ends_.size());
            const int wanted = std::min(settings_.verify - result_.unseen.since_new, left);
            if (wanted <= 0) {
                return task_.explorer == nullptr || confirm();
            }
            starts.clear();
            for (int i = 0; i < wanted; ++i) {
                std::vector<double> unit(static_cast<std::size_t>(dimension));
                for (double& u : unit) {
                    u = random.uniform(numbers++);
                }
                starts.push_back(std::move(unit));
            }
            auto more = exploring_engine().search(starts, method, search_settings(), first_of(verification) + drawn);
            if (!more) {
                return false;
            }
            drawn += wanted;
            std::move(more->begin(), more->end(), std::back_inserter(ends_));
        }
    }

    void group() {
        // A minimum is what the model itself has; the explorer's ends belong where searches from them ended.
        std::vector<run::Endpoint> own;
        std::copy_if(ends_.begin(), ends_.end(), std::back_inserter(own),
                     [&](const auto& end) { return !followed_by_.contains(end.start); });
        result_.minima = distinct_minima(own, task_.fitted);
        home_.clear();
        for (std::size_t m = 0; m < result_.minima.size(); ++m) {
            for (const int start : result_.minima[m].members) {
                home_[start] = static_cast<int>(m);
            }
        }
        for (const auto& [start, next] : followed_by_) {
            if (const auto home = home_.find(next); home != home_.end()) {
                home_[start] = home->second;
                result_.minima[static_cast<std::size_t>(home->second)].members.push_back(start);
            }
        }
    }

    // The explorer's minima, found again by the model itself.
    bool confirm() {
        constexpr int first = first_of(polishing, confirming_round);
        std::vector<std::vector<double>> starts;
        for (std::size_t m = 0; m < result_.minima.size(); ++m) {
            starts.push_back(result_.minima[m].unit);
            for (const int start : result_.minima[m].members) {
                followed_by_[start] = first + static_cast<int>(m);
            }
        }
        auto ends = task_.fitted_engine.search(starts, *optimise::find_method(search_method), search_settings(), first);
        if (!ends) {
            return false;
        }
        std::move(ends->begin(), ends->end(), std::back_inserter(ends_));
        group();
        result_.unseen = count_unseen();
        return true;
    }

    Unseen count_unseen() const {
        // Number the minima so that those known from the sample come first.
        std::vector<int> number(result_.minima.size(), -1);
        int known = 0;
        for (std::size_t m = 0; m < result_.minima.size(); ++m) {
            const auto& members = result_.minima[m].members;
            if (std::any_of(members.begin(), members.end(), [](int s) { return s < chain_range; })) {
                number[m] = known++;
            }
        }
        int next = known;
        std::vector<int> found;
        for (const auto& end : ends_) {
            if (end.start < chain_range || end.start >= first_of(polishing)) {
                continue;
            }
            const auto home = home_.find(end.start);
            if (home == home_.end() || !end.search.converged) {
                found.push_back(-1);
                continue;
            }
            int& n = number[static_cast<std::size_t>(home->second)];
            n = n < 0 ? next++ : n;
            found.push_back(n);
        }
        return unseen(found, known);
    }

    bool polish(const std::vector<std::vector<double>>& from, int round) {
        auto ends = task_.fitted_engine.search(from, *optimise::find_method(search_method), search_settings(),
                                               first_of(polishing, round));
        if (!ends) {
            return false;
        }
        std::move(ends->begin(), ends->end(), std::back_inserter(ends_));
        group();
        return true;
    }

    // Directions, passes, traces, profiles and predictions at the minima that the data accept.
    bool around_minimum(int round, std::vector<std::vector<double>>& better) {
        const Acceptance& acceptance = *result_.acceptance;
        const problem::Problem& problem = task_.fitted;
        const double best_misfit = result_.minima[0].evaluation.misfit;
        result_.directions = directions(problem, acceptance, result_.minima[0]);
        result_.accepted.clear();
        constexpr std::size_t most_accepted = 64;
        for (std::size_t m = 0; m < result_.minima.size() && result_.accepted.size() < most_accepted; ++m) {
            if (acceptance.rise(result_.minima[m].evaluation.misfit, best_misfit) < acceptance.threshold) {
                result_.accepted.push_back(m);
            }
        }
        if (!find_passes(round, best_misfit)) {
            return false;
        }

        result_.traces.clear();
        if (!result_.directions.flat.empty()) {
            result_.traces.resize(2);
            const bool finished =
                task_.fitted_engine.chains("valley", first_of(traces, round), 2, [&](std::size_t i, run::Chain& chain) {
                    const VectorXd v = result_.directions.vectors.back();
                    result_.traces[i] =
                        trace_valley(chain, problem, acceptance, result_.minima[0], i == 0 ? VectorXd(-v) : v);
                });
            if (!finished) {
                return false;
            }
        }

        const auto d = static_cast<std::size_t>(problem.space.dimension());
        std::vector<Quantity> quantities;
        for (std::size_t k = 0; k < d; ++k) {
            quantities.push_back(coordinate(k));
        }
        std::vector<Quantity> predicted;
        for (const std::size_t i : task_.outputs) {
            predicted.push_back(response(task_.everything.space, i));
        }
        auto walked = walk_all(task_.fitted_engine, problem, quantities, "profile", first_of(profiles, round), nullptr);
        if (!walked) {
            return false;
        }
        result_.parameters = std::move(*walked);
        for (std::size_t k = 0; k < d; ++k) {
            Range& range = result_.parameters[k];
            range.low = problem.space.axes[k].physical(range.low);
            range.high = problem.space.axes[k].physical(range.high);
        }
        if (!walk_on(round, quantities)) {
            return false;
        }
        reach_accepted(problem.space, result_);
        result_.outputs.clear();
        if (!predicted.empty()) {
            // The minima once more, with every response.
            std::vector<Minimum> complete;
            for (const std::size_t m : result_.alternative_of) {
                Minimum minimum = result_.minima[m];
                minimum.evaluation = task_.everything_engine.evaluate_one(minimum.unit);
                complete.push_back(std::move(minimum));
            }
            if (std::all_of(complete.begin(), complete.end(), [](const auto& m) { return m.evaluation.converged(); })) {
                const int first = first_of(predictions, round);
                Expected expected;
                if (!walk_to_outputs(complete, predicted, first, expected) ||
                    !walk_outputs_on(predicted, expected, first + on_from_profiles)) {
                    return false;
                }
                result_.minima[0].evaluation = complete[0].evaluation;
            } else {
                result_.missing.emplace_back("the outputs: the model of a load that is only predicted has no answer at "
                                             "the best minimum");
            }
        }
        const auto collect = [&](const Branch& branch) {
            if (branch.end == WalkEnd::better) {
                better.push_back(branch.points.back().unit);
            }
        };
        std::for_each(result_.traces.begin(), result_.traces.end(), collect);
        for (const auto* list : {&result_.parameters, &result_.outputs}) {
            for (const Range& range : *list) {
                std::for_each(range.branches.begin(), range.branches.end(), collect);
            }
        }
        return true;
    }

    bool find_passes(int round, double best_misfit) {
        const Acceptance& acceptance = *result_.acceptance;
        const auto& accepted = result_.accepted;
        result_.passes.clear();
        // Each with the nearest of those that are lower.
        constexpr std::size_t few = 5;
        for (std::size_t j = 1; j < accepted.size(); ++j) {
            const VectorXd here = vector_of(result_.minima[accepted[j]].unit);
            std::vector<std::size_t> lower(accepted.begin(), accepted.begin() + static_cast<std::ptrdiff_t>(j));
            const auto distance = [&](std::size_t m) { return (vector_of(result_.minima[m].unit) - here).norm(); };
            std::stable_sort(lower.begin(), lower.end(),
                             [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
            lower.resize(std::min(lower.size(), few));
            for (const std::size_t i : lower) {
                result_.passes.push_back({i, accepted[j], {}});
            }
        }
        const std::size_t n = result_.passes.size();
        std::vector<std::vector<ProfilePoint>> ways(2 * n);
        const auto walk_way = [&](std::size_t i, run::Chain& chain) {
            const auto& p = result_.passes[i / 2];
            const auto& a = result_.minima[i % 2 == 0 ? p.a : p.b];
            const auto& b = result_.minima[i % 2 == 0 ? p.b : p.a];
            ways[i] = approach(chain, task_.fitted, acceptance, a, b, best_misfit);
        };
        const auto join_ways = [&](std::size_t i, run::Chain& chain) {
            result_.passes[i].pass = pass_between(chain, acceptance, ways[2 * i], ways[2 * i + 1], best_misfit);
        };
        const int first = first_of(passes, round);
        if (n > 0 && !(task_.fitted_engine.chains("passes", first, 2 * n, walk_way) &&
                       task_.fitted_engine.chains("passes", first + static_cast<int>(2 * n), n, join_ways))) {
            return false;
        }
        // Minima that an acceptable way joins are one answer.
        std::vector<std::size_t> part(result_.minima.size());
        std::iota(part.begin(), part.end(), 0);
        for (std::size_t again = 0; again < accepted.size(); ++again) {
            for (const auto& p : result_.passes) {
                if (p.pass.rise < acceptance.threshold) {
                    part[p.a] = part[p.b] = std::min(part[p.a], part[p.b]);
                }
            }
        }
        result_.alternative_of.clear();
        for (const std::size_t m : accepted) {
            if (part[m] == m) {
                result_.alternative_of.push_back(m);
            }
        }
        return true;
    }

    // Down and up from every alternative, for every quantity. minima: in place of the alternatives themselves.
    std::optional<std::vector<Range>> walk_all(run::Engine& engine, const problem::Problem& problem,
                                               const std::vector<Quantity>& quantities, const std::string& what,
                                               int first, const std::vector<Minimum>* minima) {
        const Acceptance& acceptance = *result_.acceptance;
        const double best_misfit = result_.minima[0].evaluation.misfit;
        const std::size_t alternatives = result_.alternative_of.size();
        const auto minimum = [&](std::size_t a) -> const Minimum& {
            return minima != nullptr ? (*minima)[a] : result_.minima[result_.alternative_of[a]];
        };
        std::vector<Branch> branches(2 * alternatives * quantities.size());
        if (!engine.chains(what, first, branches.size(), [&](std::size_t i, run::Chain& chain) {
                branches[i] = walk(chain, problem, acceptance, minimum((i / 2) % alternatives), best_misfit,
                                   quantities[i / (2 * alternatives)], i % 2 == 0 ? -1 : 1);
            })) {
            return std::nullopt;
        }
        return ranges_of(problem.space, std::move(branches), quantities.size());
    }

    // The ends of the outputs. complete: the alternatives, evaluated as everything. False: interrupted.
    // expected: of outputs anywhere, where that is known.
    bool walk_to_outputs(const std::vector<Minimum>& complete, const std::vector<Quantity>& predicted, int first,
                         Expected& expected) {
        if (task_.outputs_cost_more) {
            std::vector<Minimum> from;
            std::transform(result_.alternative_of.begin(), result_.alternative_of.end(), std::back_inserter(from),
                           [&](std::size_t m) { return result_.minima[m]; });
            auto walks = walk_outputs(task_, *result_.acceptance, from, complete, first);
            if (!walks) {
                return false;
            }
            if (!walks->branches.empty()) {
                result_.outputs = ranges_of(task_.fitted.space, std::move(walks->branches), predicted.size());
                expected = std::move(walks->between);
                return true;
            }
        }
        auto ranges = walk_all(task_.everything_engine, task_.everything, predicted, "outputs",
                               first + (task_.outputs_cost_more ? from_minima : 0), &complete);
        if (ranges) {
            result_.outputs = std::move(*ranges);
        }
        return ranges.has_value();
    }

    // branches: down and up from each alternative for each quantity.
    std::vector<Range> ranges_of(const problem::ParameterSpace& space, std::vector<Branch> branches,
                                 std::size_t quantities) const {
        const std::size_t alternatives = result_.alternative_of.size();
        std::vector<Range> ranges(quantities);
        for (std::size_t q = 0; q < quantities; ++q) {
            Range& range = ranges[q];
            range.low = std::numeric_limits<double>::infinity();
            range.high = -range.low;
            for (std::size_t a = 0; a < alternatives; ++a) {
                for (const int side : {0, 1}) {
                    Branch& branch = branches[2 * (q * alternatives + a) + static_cast<std::size_t>(side)];
                    if (side == 0 && branch.limit < range.low) {
                        range.low = branch.limit;
                        range.low_end = branch.end;
                        range.low_bounds = branch.on_bound;
                        range.low_limits = branch.on_limit;
                        range.low_set = space.physical(branch.limit_unit);
                    }
                    if (side == 1 && branch.limit > range.high) {
                        range.high = branch.limit;
                        range.high_end = branch.end;
                        range.high_bounds = branch.on_bound;
                        range.high_limits = branch.on_limit;
                        range.high_set = space.physical(branch.limit_unit);
                    }
                    range.branches.push_back(std::move(branch));
                }
            }
        }
        return ranges;
    }

    // Walks on from sets that the data accept beyond where a range ended. Nothing: interrupted.
    std::optional<std::vector<Branch>> walks_from(run::Engine& engine, const problem::Problem& problem,
                                                  const std::vector<Beyond>& from,
                                                  const std::vector<Quantity>& quantities, const std::string& what,
                                                  int first) {
        std::vector<Branch> walked(from.size());
        const double best_misfit = result_.minima[0].evaluation.misfit;
        if (!from.empty() && !engine.chains(what, first, from.size(), [&](std::size_t i, run::Chain& chain) {
                const Beyond& one = from[i];
                const bool has_derivatives = one.point.evaluation.jacobian.size() > 0;
                const Minimum at =
                    minimum_at(has_derivatives ? one.point.evaluation : chain.at(one.point.unit), one.point.unit);
                walked[i] =
                    walk(chain, problem, *result_.acceptance, at, best_misfit, quantities[one.quantity], one.sign);
            })) {
            return std::nullopt;
        }
        return walked;
    }

    // Profiles that ended although another walk met accepted sets beyond go on from there. False: interrupted.
    bool walk_on(int round, const std::vector<Quantity>& quantities) {
        std::vector<Beyond> from = beyond_ends(task_.fitted.space, result_);
        constexpr int behind_the_others = chain_range / 2;
        auto walked = walks_from(task_.fitted_engine, task_.fitted, from, quantities, "profile",
                                 first_of(profiles, round) + behind_the_others);
        for (std::size_t i = 0; walked && i < from.size(); ++i) {
            Branch& on = (*walked)[i];
            const problem::Axis& axis = task_.fitted.space.axes[from[i].quantity];
            Range& range = result_.parameters[from[i].quantity];
            const double to = axis.physical(on.limit);
            walked_on(task_.fitted.space, std::move(from[i]), std::move(on), to, range);
        }
        return walked.has_value();
    }

    // The same of outputs, from the ends of the profiles. False: interrupted.
    bool walk_outputs_on(const std::vector<Quantity>& predicted, const Expected& expected, int first) {
        auto from = outputs_beyond(task_.outputs, expected, task_.everything_engine, first, result_);
        if (!from) {
            return false;
        }
        constexpr int behind_the_ends = 1'000;
        auto walked =
            walks_from(task_.everything_engine, task_.everything, *from, predicted, "outputs", first + behind_the_ends);
        for (std::size_t i = 0; walked && i < from->size(); ++i) {
            Branch& on = (*walked)[i];
            Range& range = result_.outputs[(*from)[i].quantity];
            const double to = on.limit;
            walked_on(task_.everything.space, std::move((*from)[i]), std::move(on), to, range);
        }
        return walked.has_value();
    }

    // The minima by a second method. moved: it found lower ones, which are ends from now on. False: interrupted.
    bool confirm_minima(bool& moved) {
        const std::size_t searched = result_.explored.size() + static_cast<std::size_t>(search_evaluations(ends_));
        constexpr int first = first_of(polishing, groups_round);
        if (!landscape::confirm(task_.fitted_engine, task_.fitted, confirming_method(search_method),
                                analyse(result_.minima[0], task_.fitted).noise, confirming_evaluations(searched), first,
                                result_.minima)) {
            return false;
        }
        result_.confirmation = confirmation_words(result_.minima);
        for (const Minimum& m : result_.minima) {
            if (m.second && !m.second->agrees) {
                moved = true;
                run::Endpoint& end = ends_.emplace_back();
                end.start = first + chain_range / 2 + static_cast<int>(&m - result_.minima.data());
                end.search = {.unit = m.unit,
                              .misfit = m.evaluation.misfit,
                              .evaluations = m.second->evaluations,
                              .converged = m.converged,
                              .stopped = false,
                              .ended = m.second->ended};
                end.evaluation = m.evaluation;
            }
        }
        return true;
    }

    bool compare_groups() {
        std::vector<std::vector<double>> starts{result_.minima[0].unit};
        const auto lowest = run::distinct_starts(result_.sample, result_.explored, 3, 0.25);
        for (const std::size_t i : lowest) {
            starts.push_back(result_.sample.points[i]);
        }
        Minimum joint = result_.minima[0]; // groups are compared by their readings alone
        if (result_.priors) {
            joint.evaluation = result_.priors->readings_alone;
            joint.evaluation.misfit = result_.priors->readings_misfit;
            joint.unit = task_.fitted.space.unit(joint.evaluation.parameters);
            starts.push_back(joint.unit);
        }
        result_.conflict = conflict_of(task_.fitted_engine, task_.fitted.without_priors(), *result_.acceptance, joint,
                                       task_.groups, starts, first_of(groups, groups_round));
        return result_.conflict.has_value();
    }

    void classify() {
        for (const auto& end : ends_) {
            ClassifiedEnd c;
            c.start = end.start;
            c.evaluations = end.search.evaluations;
            const auto home = home_.find(end.start);
            c.minimum = home == home_.end() ? -1 : home->second;
            if (end.search.unit.empty() || !end.search.converged) {
                c.unfinished = end.search.ended;
                result_.ends.push_back(std::move(c));
                continue;
            }
            const auto met = bounds_met(end.search.unit);
            c.bounds = met;
            bool flat = false;
            if (result_.acceptance) {
                const Minimum here = minimum_at(end.evaluation, end.search.unit);
                flat = !directions(task_.fitted, *result_.acceptance, here).flat.empty();
            }
            c.kind = flat ? EndKind::valley : met.empty() ? EndKind::interior : EndKind::bound;
            result_.ends.push_back(std::move(c));
        }
    }

    // Everything that was computed along the way, by cells of every pair of parameters.
    void project() {
        constexpr std::size_t cells = 16;
        std::vector<std::pair<std::vector<double>, double>> points;
        const auto add = [&](const std::vector<double>& unit, const problem::Evaluation& e) {
            points.emplace_back(unit, e.misfit);
        };
        for (std::size_t i = 0; i < result_.explored.size(); ++i) {
            add(result_.sample.points[i], result_.explored[i]);
        }
        for (const auto& end : ends_) {
            if (!end.search.unit.empty()) {
                add(end.search.unit, end.evaluation);
            }
        }
        const auto add_branch = [&](const Branch& branch) {
            for (const auto& p : branch.points) {
                add(p.unit, p.evaluation);
            }
        };
        std::for_each(result_.traces.begin(), result_.traces.end(), add_branch);
        for (const Range& range : result_.parameters) {
            std::for_each(range.branches.begin(), range.branches.end(), add_branch);
        }
        const auto d = static_cast<std::size_t>(task_.fitted.space.dimension());
        for (std::size_t x = 0; x < d; ++x) {
            for (std::size_t y = x + 1; y < d; ++y) {
                Projection p{x, y, static_cast<int>(cells), {}};
                p.misfit.assign(cells * cells, std::numeric_limits<double>::quiet_NaN());
                const auto cell = [](double unit) {
                    return std::min(cells - 1, static_cast<std::size_t>(unit * static_cast<double>(cells)));
                };
                for (const auto& [unit, misfit] : points) {
                    double& value = p.misfit[cell(unit[x]) + cells * cell(unit[y])];
                    if (!std::isnan(misfit) && !(value <= misfit)) {
                        value = misfit;
                    }
                }
                result_.projections.push_back(std::move(p));
            }
        }
    }

    void judge() {
        if (!result_.acceptance) {
            return;
        }
        result_.alternatives = result_.alternative_of.size() > 1;
        // A set the data accept that reaches over more than half of what the study allows for a parameter, or over a
        // fifth when it is the box that ends it on both sides.
        constexpr double wide = 0.5;
        constexpr double cut_off = 0.2;
        bool incomplete = false;
        bool is_open = false; // some way leads on, or the box ends it
        for (std::size_t k = 0; k < result_.parameters.size(); ++k) {
            const problem::Axis& axis = task_.fitted.space.axes[k];
            const Range& range = result_.parameters[k];
            const double reach = axis.unit(range.high) - axis.unit(range.low);
            const bool flat = kind_of(range) == ProfileKind::flat;
            if (reach > (flat ? cut_off : wide)) {
                if (kind_of(range) == ProfileKind::bounded && result_.traces.empty()) {
                    result_.wide.push_back(k);
                } else {
                    is_open = true;
                }
            }
            incomplete = incomplete || kind_of(range) == ProfileKind::incomplete;
        }
        for (std::size_t k = 0; k < static_cast<std::size_t>(task_.fitted.space.dimension()); ++k) {
            double low = 1.0;
            double high = 0.0;
            for (const Branch& trace : result_.traces) {
                for (const auto& p : trace.points) {
                    if (p.rise < result_.acceptance->threshold) {
                        low = std::min(low, p.unit[k]);
                        high = std::max(high, p.unit[k]);
                    }
                }
            }
            is_open = is_open || high - low > wide;
        }
        if (is_open || result_.alternatives) { // between separate minima a range holds what the data do not accept
            result_.wide.clear();
        }
        result_.valley = is_open || !result_.wide.empty();
        if (!result_.minima[0].converged) {
            result_.missing.emplace_back("a finished search: the best one met its limit of evaluations");
        }
        const auto unfinished = std::count_if(result_.ends.begin(), result_.ends.end(),
                                              [](const auto& e) { return e.kind == EndKind::unfinished; });
        if (2 * static_cast<std::size_t>(unfinished) > result_.ends.size()) {
            result_.missing.emplace_back("searches: more than half of them ended unfinished");
        }
        if (result_.minima[0].on_bound.size() == result_.minima[0].unit.size()) {
            result_.missing.emplace_back("an answer of the data: everything that is fitted ends on a bound, where the "
                                         "box answers");
        }
        if (incomplete) {
            result_.missing.emplace_back("a profile: points without an answer or the limit of steps stopped it");
        }
        if (result_.valley || result_.alternatives) {
            result_.verdict = Verdict::non_unique;
        } else {
            result_.verdict = result_.missing.empty() ? Verdict::unique : Verdict::undecided;
        }
    }

    const UniquenessTask& task_;
    const UniquenessSettings& settings_;
    Uniqueness result_;
    std::vector<run::Endpoint> ends_;
    std::map<int, int> home_;        // minimum of a start
    std::map<int, int> followed_by_; // of a start of the explorer: the start from where it ended
};

} // namespace

ProfileKind kind_of(const Range& range) {
    const auto incomplete = [](WalkEnd end) {
        return end == WalkEnd::hole || end == WalkEnd::limit || end == WalkEnd::better;
    };
    if (incomplete(range.low_end) || incomplete(range.high_end)) {
        return ProfileKind::incomplete;
    }
    const bool low = range.low_end == WalkEnd::threshold;
    const bool high = range.high_end == WalkEnd::threshold;
    return low && high ? ProfileKind::bounded : low || high ? ProfileKind::one_sided : ProfileKind::flat;
}

std::optional<Uniqueness> uniqueness(const UniquenessTask& task, const UniquenessSettings& settings) {
    return Analysis(task, settings).run();
}

} // namespace explore::landscape

#include "landscape/multistart.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <set>

namespace explore::landscape {

int search_evaluations(const std::vector<run::Endpoint>& ends) {
    return std::accumulate(ends.begin(), ends.end(), 0,
                           [](int sum, const run::Endpoint& end) { return sum + end.search.evaluations; });
}

namespace {

constexpr int first_of_also = 100'000'000;
constexpr int first_between = 200'000'000;

double distance(const std::vector<double>& a, const std::vector<double>& b) {
    return std::sqrt(search::squared_distance(a, b));
}

// Two ends that fit alike, and may lie in one valley.
struct Gap {
    std::size_t minimum;       // that may be one with the best
    const run::Endpoint* from; // of the lower misfit
    const run::Endpoint* to;

    Gap(std::size_t of, const run::Endpoint& a, const run::Endpoint& b) : minimum(of), from(&a), to(&b) {
        if (b.search.misfit < a.search.misfit) {
            std::swap(from, to);
        }
    }

    double width() const { return distance(from->search.unit, to->search.unit); }
    std::vector<double> middle() const {
        std::vector<double> unit = from->search.unit;
        for (std::size_t k = 0; k < unit.size(); ++k) {
            unit[k] = (unit[k] + to->search.unit[k]) / 2.0;
        }
        return unit;
    }
};

// Between the best minimum and those that fit alike, a few at most: the ends that lie nearest to each other.
std::vector<Gap> gaps_of(const std::vector<run::Endpoint>& ends, const std::vector<Minimum>& minima,
                         const problem::Problem& by_noise) {
    constexpr std::size_t most = 3;
    std::vector<Gap> gaps;
    for (std::size_t m = 1; m < minima.size() && gaps.size() < most; ++m) {
        std::optional<Gap> nearest;
        for (const int a : minima[0].members) {
            for (const int b : minima[m].members) {
                const Gap gap(m, ends[static_cast<std::size_t>(a)], ends[static_cast<std::size_t>(b)]);
                if ((!nearest || gap.width() < nearest->width()) && fit_alike(*gap.from, *gap.to, by_noise)) {
                    nearest = gap;
                }
            }
        }
        if (nearest) {
            gaps.push_back(*nearest);
        }
    }
    return gaps;
}

// The minima that one valley joins with the best: a search from halfway between ends of the two stays there and fits
// alike, or does so from halfway to where that one ended. From a ridge it falls back to one of them. Nothing:
// interrupted.
std::optional<std::set<std::size_t>> joined_with_best(run::Engine& engine, const problem::Problem& problem,
                                                      const std::vector<run::Endpoint>& ends,
                                                      const std::vector<Minimum>& minima,
                                                      const MultistartSettings& settings) {
    const problem::Problem by_noise = problem.in_units_of_noise();
    std::vector<Gap> gaps = gaps_of(ends, minima, by_noise);
    std::set<std::size_t> joined;
    for (const Gap& gap : gaps) {
        joined.insert(gap.minimum);
    }
    std::deque<run::Endpoint> found;
    constexpr int rounds = 5;
    int number = first_between;
    for (int round = 0; round < rounds && !gaps.empty(); ++round) {
        std::vector<std::vector<double>> starts;
        std::vector<int> kept_as;
        for (const Gap& gap : gaps) {
            starts.push_back(gap.middle());
            kept_as.push_back(number++);
        }
        auto middles = engine.search(starts, *optimise::find_method(settings.method), settings.search, 0, kept_as);
        if (!middles) {
            return std::nullopt;
        }
        std::vector<Gap> left;
        for (std::size_t g = 0; g < gaps.size(); ++g) {
            if ((*middles)[g].search.unit.empty()) {
                joined.erase(gaps[g].minimum);
                continue;
            }
            const run::Endpoint& middle = found.emplace_back(std::move((*middles)[g]));
            constexpr double stays = 0.15; // of the gap
            const bool has_stayed = distance(starts[g], middle.search.unit) < stays * gaps[g].width();
            for (const run::Endpoint* side : {gaps[g].from, gaps[g].to}) {
                const Gap half(gaps[g].minimum, *side, middle);
                if (are_one_minimum(*half.from, *half.to, by_noise)) {
                    continue;
                }
                constexpr double nearer = 0.9;
                if (!fit_alike(*half.from, *half.to, by_noise) || half.width() > nearer * gaps[g].width()) {
                    joined.erase(half.minimum);
                } else if (!has_stayed) {
                    left.push_back(half);
                }
            }
        }
        std::erase_if(left, [&](const Gap& gap) { return !joined.contains(gap.minimum); });
        gaps = std::move(left);
    }
    for (const Gap& gap : gaps) {
        joined.erase(gap.minimum);
    }
    return joined;
}

// Those minima made one with the best.
std::vector<Minimum> join(const std::vector<run::Endpoint>& ends, std::vector<Minimum> minima,
                          const std::set<std::size_t>& joined) {
    std::vector<Minimum> left;
    left.reserve(minima.size());
    Minimum& best = left.emplace_back(std::move(minima[0]));
    for (std::size_t m = 1; m < minima.size(); ++m) {
        if (!joined.contains(m)) {
            left.push_back(std::move(minima[m]));
            continue;
        }
        best.members.insert(best.members.end(), minima[m].members.begin(), minima[m].members.end());
        for (std::size_t k = 0; k < best.lowest.size(); ++k) {
            best.lowest[k] = std::min(best.lowest[k], minima[m].lowest[k]);
            best.highest[k] = std::max(best.highest[k], minima[m].highest[k]);
        }
    }
    std::stable_sort(best.members.begin(), best.members.end(), [&](int a, int b) {
        return ends[static_cast<std::size_t>(a)].search.misfit < ends[static_cast<std::size_t>(b)].search.misfit;
    });
    return left;
}

} // namespace

std::optional<MultistartResult> multistart(run::Engine& engine, const problem::Problem& problem,
                                           const search::Design& design, const MultistartSettings& settings) {
    auto explored = engine.evaluate(design);
    if (!explored) {
        return std::nullopt;
    }
    return refine(engine, problem, design, std::move(*explored), {}, settings);
}

std::optional<MultistartResult> refine(run::Engine& engine, const problem::Problem& problem,
                                       const search::Design& design, std::vector<problem::Evaluation> explored,
                                       const std::vector<std::vector<double>>& also,
                                       const MultistartSettings& settings) {
    // By the point that it starts from: more points or starts continue a run.
    std::vector<std::vector<double>> starts;
    std::vector<int> kept_as;
    for (const std::size_t i : run::distinct_starts(design, explored, settings.starts, settings.start_distance)) {
        kept_as.push_back(settings.first_kept + static_cast<int>(i));
        starts.push_back(design.points[i]);
    }
    for (const auto& start : also) {
        kept_as.push_back(first_of_also + static_cast<int>(&start - also.data()));
        starts.push_back(start);
    }
    auto ends = engine.search(starts, *optimise::find_method(settings.method), settings.search, 0, kept_as);
    if (!ends) {
        return std::nullopt;
    }
    auto minima = distinct_minima(*ends, problem);
    if (minima.size() > 1) {
        const auto joined = joined_with_best(engine, problem, *ends, minima, settings);
        if (!joined) {
            return std::nullopt;
        }
        minima = join(*ends, std::move(minima), *joined);
    }
    return MultistartResult{std::move(explored), std::move(*ends), std::move(minima)};
}

} // namespace explore::landscape

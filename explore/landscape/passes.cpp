// Ways over from one minimum to another.
#include "landscape/walker.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {

using Eigen::VectorXd;

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
        auto found =
            walker.lowest(clamped(way.back().unit, std::clamp(part, 0.0, 1.0) * left), share, {.target = target});
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
            pass.way.push_back({.value = forth[i].value, .rise = rise, .unit = unit, .evaluation = std::move(e)});
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
            best.way.insert(best.way.begin() + left + 1, ProfilePoint{.value = 0.5 * (a.value + b.value),
                                                                      .rise = rise,
                                                                      .unit = unit,
                                                                      .evaluation = std::move(e)});
        }
    }
    return best;
}

} // namespace explore::landscape

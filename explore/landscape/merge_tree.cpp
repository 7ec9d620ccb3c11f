#include "landscape/merge_tree.h"

#include "search/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {

namespace {

// Points with an answer, lowest misfit first.
std::vector<std::size_t> by_misfit(std::span<const double> misfit) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < misfit.size(); ++i) {
        if (!std::isnan(misfit[i])) {
            order.push_back(i);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return misfit[a] < misfit[b]; });
    return order;
}

// The `count` nearest of `among` to each of them.
std::vector<std::vector<std::size_t>> nearest(std::span<const std::vector<double>> points,
                                              const std::vector<std::size_t>& among, int count) {
    std::vector<std::vector<std::size_t>> result(points.size());
    std::vector<std::vector<double>> cloud;
    cloud.reserve(among.size());
    for (const std::size_t i : among) {
        cloud.push_back(points[i]);
    }
    const search::Neighbours tree(cloud);
    for (const std::size_t i : among) {
        for (const auto& n : tree.nearest(points[i], static_cast<std::size_t>(count) + 1)) {
            if (among[n.point] != i && result[i].size() < static_cast<std::size_t>(count)) {
                result[i].push_back(among[n.point]);
            }
        }
    }
    return result;
}

} // namespace

std::vector<SampledMinimum> merge_tree(std::span<const std::vector<double>> points, std::span<const double> misfit,
                                       int neighbours) {
    const std::size_t n = points.size();
    const std::vector<std::size_t> order = by_misfit(misfit);
    auto edges = nearest(points, order, neighbours);
    for (const std::size_t i : order) {
        const auto own = edges[i];
        for (std::size_t k = 0; k < std::min(own.size(), static_cast<std::size_t>(neighbours)); ++k) {
            edges[own[k]].push_back(i);
        }
    }

    // Flood: every point joins the basins it touches; of two that meet the higher minimum ends.
    constexpr std::size_t dry = std::numeric_limits<std::size_t>::max();
    std::vector<SampledMinimum> minima;
    std::vector<std::size_t> basin(n, dry); // of a point: index of a minimum
    std::vector<std::size_t> root;          // of a minimum: the one it has become part of
    const auto find = [&](std::size_t m) {
        while (root[m] != m) {
            m = root[m] = root[root[m]];
        }
        return m;
    };
    for (const std::size_t i : order) {
        std::vector<std::size_t> met;
        for (const std::size_t j : edges[i]) {
            if (basin[j] != dry) {
                met.push_back(find(basin[j]));
            }
        }
        std::sort(met.begin(), met.end()); // minima are numbered by misfit
        met.erase(std::unique(met.begin(), met.end()), met.end());
        if (met.empty()) {
            basin[i] = minima.size();
            root.push_back(minima.size());
            minima.push_back({i, misfit[i], std::numeric_limits<double>::infinity(), -1, 1});
            continue;
        }
        basin[i] = met.front();
        for (std::size_t k = 1; k < met.size(); ++k) {
            minima[met[k]].pass = misfit[i];
            minima[met[k]].joins = static_cast<std::ptrdiff_t>(met.front());
            root[met[k]] = met.front();
        }
        ++minima[met.front()].basin;
    }
    return minima;
}

std::vector<std::size_t> unlinked_points(std::span<const std::vector<double>> points, std::span<const double> misfit,
                                         std::span<const Eigen::VectorXd> gradients, int neighbours) {
    const std::vector<std::size_t> order = by_misfit(misfit);
    const auto near = nearest(points, order, neighbours);
    std::vector<std::size_t> unlinked;
    for (const std::size_t i : order) {
        const bool linked = std::any_of(near[i].begin(), near[i].end(), [&](std::size_t j) {
            double slope = 0.0;
            for (std::size_t k = 0; k < points[i].size(); ++k) {
                slope += gradients[i][static_cast<Eigen::Index>(k)] * (points[j][k] - points[i][k]);
            }
            return misfit[j] < misfit[i] && slope < 0.0;
        });
        if (!linked) {
            unlinked.push_back(i);
        }
    }
    return unlinked;
}

} // namespace explore::landscape

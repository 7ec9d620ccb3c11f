#include "landscape/accepted_ends.h"

#include <algorithm>
#include <cmath>

namespace explore::landscape {

void widen_ranges(const problem::ParameterSpace& space, Uniqueness& u) {
    const auto widen = [&](const ProfilePoint& p) {
        if (p.rise > u.acceptance->threshold) {
            return;
        }
        const std::vector<double> set = space.physical(p.unit);
        for (std::size_t k = 0; k < set.size(); ++k) {
            Range& range = u.parameters[k];
            if (set[k] < range.low) {
                range.low = set[k];
                range.low_set = set;
            }
            if (set[k] > range.high) {
                range.high = set[k];
                range.high_set = set;
            }
        }
    };
    for (const Branch& trace : u.traces) {
        std::for_each(trace.points.begin(), trace.points.end(), widen);
    }
    for (const Range& range : u.parameters) {
        for (const Branch& branch : range.branches) {
            std::for_each(branch.points.begin(), branch.points.end(), widen);
        }
    }
}

std::vector<double> accepted_end(const problem::ParameterSpace& space, const Uniqueness& u, const Branch& trace) {
    const double wall = std::sqrt(u.acceptance->threshold);
    std::vector<double> inside = u.minima[0].unit;
    double root = 0.0;
    for (const ProfilePoint& p : trace.points) {
        const double there = std::sqrt(std::max(0.0, p.rise));
        if (there <= wall) {
            inside = p.unit;
            root = there;
            continue;
        }
        double share = (wall - root) / (there - root);
        for (std::size_t k = 0; k < inside.size(); ++k) {
            const double move = p.unit[k] - inside[k];
            const double end = space.axes[k].unit(move > 0.0 ? u.parameters[k].high : u.parameters[k].low);
            if (share * std::abs(move) > std::abs(end - inside[k])) {
                share = std::abs((end - inside[k]) / move);
            }
        }
        for (std::size_t k = 0; k < inside.size(); ++k) {
            inside[k] += share * (p.unit[k] - inside[k]);
        }
        return inside;
    }
    return inside;
}

} // namespace explore::landscape

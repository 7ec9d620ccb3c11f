// Ranges where inequalities or bounds hold an answer back, or inequalities are near: they end at what is allowed, on
// one side.
#pragma once

#include "landscape/minima.h"

namespace explore::landscape {

struct HeldRange {
    double low = 0.0, high = 0.0;
};

struct HeldRanges {
    std::vector<std::size_t> limits; // inequalities that cut the ranges
    std::vector<BoundMet> bounds;    // that the minimum meets, if they count; neither: nothing below
    // Of each parameter that they change, 95 %, in unit coordinates; nothing: the standard error tells it.
    std::vector<std::optional<HeldRange>> parameters;

    bool any() const { return !limits.empty() || !bounds.empty(); }
    std::optional<HeldRange> of(std::size_t parameter) const {
        return parameter < parameters.size() ? parameters[parameter] : std::nullopt;
    }
};

// The 95 % ranges of profiles to first order: all moves d in the cube that meet the inequalities, themselves linear
// about the minimum, with |root d + rest|^2 (LocalAnalysis) no more than the square of the quantile above its lowest
// value among them. Not a half of a symmetric range: with the answer on the limit the readings would have it beyond,
// and the rise is counted from there. local: of the minimum. bounds_count: one that the minimum meets is
// reason enough for such ranges, without an inequality that is near.
HeldRanges held_ranges(const problem::Problem& problem, const Minimum& minimum, const LocalAnalysis& local,
                       bool bounds_count = false);

// The same of a quantity: how far it may move from its value at the minimum. gradient: by unit coordinates. Nothing: no
// inequality and no bound that counts changes it, or no noise is known.
std::optional<HeldRange> held_range(const problem::Problem& problem, const Minimum& minimum, const LocalAnalysis& local,
                                    const Eigen::VectorXd& gradient, bool bounds_count = false);

} // namespace explore::landscape

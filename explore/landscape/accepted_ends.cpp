#include "landscape/accepted_ends.h"

#include <algorithm>
#include <optional>

namespace explore::landscape {
namespace {

std::vector<const Branch*> walks_of(const Uniqueness& u) {
    std::vector<const Branch*> walks;
    for (const Branch& trace : u.traces) {
        walks.push_back(&trace);
    }
    for (const Range& range : u.parameters) {
        for (const Branch& branch : range.branches) {
            walks.push_back(&branch);
        }
    }
    return walks;
}

} // namespace

std::vector<Beyond> beyond_ends(const problem::ParameterSpace& space, const Uniqueness& u) {
    constexpr double hair = 2e-3; // of the box
    const std::size_t count = u.parameters.size();
    std::vector<double> ends(2 * count); // lower and upper of each
    for (std::size_t k = 0; k < count; ++k) {
        ends[2 * k] = space.axes[k].unit(u.parameters[k].low) - hair;
        ends[2 * k + 1] = space.axes[k].unit(u.parameters[k].high) + hair;
    }
    std::vector<const ProfilePoint*> furthest(2 * count, nullptr);
    const auto look_at = [&](const ProfilePoint& p) {
        if (p.rise > u.acceptance->threshold) {
            return;
        }
        for (std::size_t k = 0; k < count; ++k) {
            if (p.unit[k] < ends[2 * k]) {
                ends[2 * k] = p.unit[k];
                furthest[2 * k] = &p;
            }
            if (p.unit[k] > ends[2 * k + 1]) {
                ends[2 * k + 1] = p.unit[k];
                furthest[2 * k + 1] = &p;
            }
        }
    };
    for (const Branch* branch : walks_of(u)) {
        std::for_each(branch->points.begin(), branch->points.end(), look_at);
    }
    std::vector<Beyond> beyond;
    for (std::size_t i = 0; i < furthest.size(); ++i) {
        if (furthest[i] != nullptr) {
            Beyond& one = beyond.emplace_back(Beyond{i / 2, i % 2 == 0 ? -1 : 1, *furthest[i]});
            one.point.value = one.point.unit[one.quantity];
            one.point.slope = 0.0;
        }
    }
    return beyond;
}

std::optional<std::vector<Beyond>> outputs_beyond(const std::vector<std::size_t>& responses, const Expected& expected,
                                                  run::Engine& everything, int first, Uniqueness& u) {
    const auto may_be_beyond = [&](const std::vector<double>& unit) {
        const Eigen::VectorXd values = expected ? expected(unit) : Eigen::VectorXd();
        bool is_beyond = !expected;
        for (Eigen::Index o = 0; o < values.size(); ++o) {
            const Range& range = u.outputs[static_cast<std::size_t>(o)];
            is_beyond = is_beyond || values[o] < range.low || values[o] > range.high;
        }
        return is_beyond;
    };
    std::vector<std::vector<double>> ends;
    for (const Branch* branch : walks_of(u)) {
        if (!branch->limit_unit.empty() && std::find(ends.begin(), ends.end(), branch->limit_unit) == ends.end() &&
            may_be_beyond(branch->limit_unit)) {
            ends.push_back(branch->limit_unit);
        }
    }
    std::vector<problem::Evaluation> there(ends.size());
    if (!everything.chains("outputs", first, ends.size(),
                           [&](std::size_t i, run::Chain& chain) { there[i] = chain.at(ends[i], false); })) {
        return std::nullopt;
    }
    std::vector<Beyond> beyond;
    for (std::size_t o = 0; o < responses.size(); ++o) {
        Range& range = u.outputs[o];
        constexpr double hair = 5e-3; // of the range
        const double allowed = hair * (range.high - range.low);
        for (const int sign : {-1, 1}) {
            double& end = sign > 0 ? range.high : range.low;
            double value = end;
            std::optional<std::size_t> furthest;
            for (std::size_t i = 0; i < ends.size(); ++i) {
                if (there[i].converged() && sign * (there[i].responses[responses[o]] - value) > 0.0) {
                    value = there[i].responses[responses[o]];
                    furthest = i;
                }
            }
            if (!furthest) {
                continue;
            }
            if (sign * (value - end) > allowed) {
                Beyond& one = beyond.emplace_back(Beyond{o, sign, {}});
                one.point.value = value;
                one.point.unit = ends[*furthest];
                one.point.evaluation = there[*furthest];
            } else {
                end = value;
                (sign > 0 ? range.high_set : range.low_set) = there[*furthest].parameters;
            }
        }
    }
    return beyond;
}

void walked_on(const problem::ParameterSpace& space, Beyond from, Branch walked, double to, Range& range) {
    const bool up = from.sign > 0;
    // The branch of that side that came furthest: what it met beyond the new point was of its own neighbourhood.
    Branch* own = nullptr;
    for (std::size_t b = up ? 1 : 0; b < range.branches.size(); b += 2) {
        if (own == nullptr || from.sign * (range.branches[b].limit - own->limit) > 0.0) {
            own = &range.branches[b];
        }
    }
    std::erase_if(own->points, [&](const ProfilePoint& p) { return from.sign * (p.value - from.point.value) >= 0.0; });
    own->points.push_back(std::move(from.point));
    std::move(walked.points.begin(), walked.points.end(), std::back_inserter(own->points));
    own->end = walked.end;
    own->limit = walked.limit;
    own->limit_unit = std::move(walked.limit_unit);
    own->on_bound = std::move(walked.on_bound);
    own->on_limit = std::move(walked.on_limit);
    (up ? range.high : range.low) = to;
    (up ? range.high_end : range.low_end) = own->end;
    (up ? range.high_bounds : range.low_bounds) = own->on_bound;
    (up ? range.high_limits : range.low_limits) = own->on_limit;
    (up ? range.high_set : range.low_set) = space.physical(own->limit_unit);
}

void reach_accepted(const problem::ParameterSpace& space, Uniqueness& u) {
    std::vector<const std::vector<double>*> accepted;
    for (const Branch* branch : walks_of(u)) {
        for (const ProfilePoint& p : branch->points) {
            if (p.rise <= u.acceptance->threshold) {
                accepted.push_back(&p.unit);
            }
        }
        if (!branch->limit_unit.empty()) {
            accepted.push_back(&branch->limit_unit);
        }
    }
    for (const std::vector<double>* unit : accepted) {
        for (std::size_t k = 0; k < u.parameters.size(); ++k) {
            Range& range = u.parameters[k];
            const double value = space.axes[k].physical((*unit)[k]);
            if (value < range.low) {
                range.low = value;
                range.low_set = space.physical(*unit);
            }
            if (value > range.high) {
                range.high = value;
                range.high_set = space.physical(*unit);
            }
        }
    }
}

} // namespace explore::landscape

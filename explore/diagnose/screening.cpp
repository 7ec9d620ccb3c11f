#include "diagnose/screening.h"

#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Members with_member(Members members, std::size_t candidate) {
    members.insert(std::upper_bound(members.begin(), members.end(), candidate), candidate);
    return members;
}

std::vector<double> with_size(std::vector<double> unit, std::size_t at, double size) {
    unit.insert(unit.begin() + static_cast<std::ptrdiff_t>(at), size);
    return unit;
}

std::size_t size_index(Workbench& bench, const Members& members, std::size_t candidate) {
    const auto at = std::find(members.begin(), members.end(), candidate) - members.begin();
    return bench.problem({})->space.axes.size() + static_cast<std::size_t>(at);
}

namespace {

// The computed statistics of one candidate.
struct Signature {
    std::string impossible;
    Shift shift;                 // at its null value; empty: not computed
    VectorXd derivative;         // by the size at its null value; empty: none
    std::vector<double> sizes;   // unit coordinates
    std::vector<VectorXd> moved; // residuals there - residuals at null; empty: no answer
};

// Sizes around the null value at which the residuals are computed.
std::vector<double> scan_of(const Candidate& candidate) {
    const double reach = candidate.typical - candidate.null;
    std::vector<double> sizes;
    for (const double share : {1.0, 0.4, 2.0, 4.0, -1.0, -0.4, -2.0}) {
        const double size = candidate.null + share * reach;
        constexpr double edge = 0.02;
        if (size > 0.0 && size < 1.0) {
            sizes.push_back(size);
        } else if (size - (size > 0.5 ? 1.0 : 0.0) != candidate.null) {
            const double end = size > 0.5 ? 1.0 - edge : edge;
            const bool is_new = std::none_of(sizes.begin(), sizes.end(),
                                             [&](double other) { return std::abs(other - end) < 2.0 * edge; });
            if (is_new && std::abs(end - candidate.null) > 2.0 * edge) {
                sizes.push_back(end);
            }
        }
    }
    return sizes;
}

// The point of the base with a candidate more, at this size.
std::vector<double> point_of(Workbench& bench, const Model& base, std::size_t candidate, double size) {
    return with_size(base.unit, size_index(bench, with_member(base.members, candidate), candidate), size);
}

// An effect whose size multiplies readings takes no run.
class Scaling {
public:
    // own: the problem of the base; with: of the base with the effect, whose last axis is the size.
    Scaling(const problem::Problem& own, const problem::Axis& size, const problem::Evaluation& base,
            const std::vector<std::size_t>& scaled)
        : own_(own),
          size_(size),
          base_(base),
          scaled_(scaled) {}

    VectorXd residuals(double size) const {
        problem::Evaluation e = base_;
        for (const std::size_t r : scaled_) {
            e.responses[r] *= size_.physical(size);
        }
        return own_.residuals(e);
    }
    // By the unit coordinate of the size, where that is 1.
    VectorXd derivative(double null) const {
        VectorXd sum = VectorXd::Zero(static_cast<Index>(own_.rows()));
        for (std::size_t i = 0; i < own_.readings(); ++i) {
            if (std::find(scaled_.begin(), scaled_.end(), own_.response_of(i)) != scaled_.end()) {
                sum += own_.change_by_gain(i, base_);
            }
        }
        return sum * size_.d_physical(null);
    }

private:
    const problem::Problem& own_;
    const problem::Axis& size_;
    const problem::Evaluation& base_;
    const std::vector<std::size_t>& scaled_;
};

// At its null value, where the residuals are those of the base: the shift and the derivative by the size.
void differentiate(Workbench& bench, const Model& base, const std::vector<Candidate>& candidates, std::size_t c,
                   int number, Signature& s) {
    const Members members = with_member(base.members, c);
    bench.chain(
        members, number,
        [&](const problem::Problem& problem, run::Chain& chain) {
            const auto e = chain.at(point_of(bench, base, c, candidates[c].null));
            if (!e.converged()) {
                s.impossible = e.reason;
                return;
            }
            s.shift = shift_between(base.evaluation, e);
            const auto at = static_cast<Index>(size_index(bench, members, c));
            s.derivative = problem.residual_jacobian(shifted(problem, e, s.shift)).col(at);
        },
        Mesh::coarse);
}

// The residuals at these sizes.
void scan(Workbench& bench, const Model& base, std::size_t c, int number, const std::vector<double>& sizes,
          Signature& s) {
    if (!s.impossible.empty() || s.shift.empty() || sizes.empty()) {
        return;
    }
    bench.chain(
        with_member(base.members, c), number,
        [&](const problem::Problem& problem, run::Chain& chain) {
            for (const double size : sizes) {
                const auto e = shifted(problem, chain.at(point_of(bench, base, c, size), false), s.shift);
                s.sizes.push_back(size);
                s.moved.push_back(e.converged() ? problem.residuals(e) - base.residuals : VectorXd());
            }
        },
        Mesh::coarse);
}

// The further sizes of scan_of: where the derivative predicts what the typical size does, those on the side that the
// data want.
std::vector<double> further_sizes(const Candidate& candidate, const Signature& s, const inference::Nuisance& nuisance,
                                  const VectorXd& residuals) {
    std::vector<double> sizes = scan_of(candidate);
    sizes.erase(sizes.begin());
    if (s.derivative.size() == 0 || s.moved.empty() || s.moved[0].size() == 0) {
        return sizes;
    }
    const VectorXd foretold = s.derivative * (candidate.typical - candidate.null);
    constexpr double straight = 0.5;
    if ((s.moved[0] - foretold).norm() < straight * s.moved[0].norm()) {
        const double wanted = -nuisance.beyond(s.derivative).dot(residuals);
        std::erase_if(sizes, [&](double size) { return (size - candidate.null) * wanted < 0.0; });
    }
    return sizes;
}

// Least sum of squares that a change, of any size and on the sides that exist, leaves of the residuals.
double least_sum(const inference::Nuisance& nuisance, const VectorXd& residuals, const VectorXd& change, int sense) {
    const VectorXd direction = nuisance.beyond(change);
    const double length = direction.norm();
    const double pull = length > 0.0 ? -direction.dot(residuals) / length : 0.0;
    return residuals.squaredNorm() - (pull * sense >= 0.0 ? pull * pull : 0.0);
}

bool is_same(const VectorXd& a, const VectorXd& b) {
    constexpr double same = 1e-6;
    return (a - b).norm() <= same * a.norm();
}

int sense_of(const Candidate& candidate) {
    return candidate.null <= 0.0 ? 1 : candidate.null >= 1.0 ? -1 : 0;
}

} // namespace

std::optional<Screening> screen(Workbench& bench, const Model& base, const std::vector<Candidate>& candidates,
                                double variance, bool estimated, std::uint64_t seed, std::size_t scanned, int number,
                                const Screening* first) {
    const double noise = std::sqrt(variance);
    const auto own = bench.problem(base.members);
    Screening screening;
    screening.base = on_coarse(bench, base, number + 3);
    const inference::Nuisance nuisance(own->residual_jacobian(screening.base.evaluation) / noise, base.unit,
                                       base.residuals / noise);
    const auto is_member = [&](std::size_t c) {
        return std::any_of(base.members.begin(), base.members.end(), [&](std::size_t m) {
            return candidates[m].effect == candidates[c].effect; // an effect once in a model
        });
    };
    std::vector<Signature> signatures(candidates.size());
    std::vector<double> least(candidates.size(), base.sum);
    tbb::task_arena arena(run::concurrency(bench.threads()));
    {
        run::Progress progress(base.members.empty() ? "effects" : "further effects",
                               static_cast<std::int64_t>(candidates.size()));
        run::for_each_index(arena, candidates.size(), [&](std::size_t c) {
            Signature& s = signatures[c];
            if (is_member(c)) {
                s.impossible = "in the model already";
            } else if (candidates[c].reading) {
                // A wrong reading moves its own residual, by any amount, and what is expected of those correlated with
                // it.
                s.derivative = own->change_by(*candidates[c].reading);
            } else if (!candidates[c].scaled.empty()) {
                const Scaling scaling(*own, candidates[c].axis, screening.base.evaluation, candidates[c].scaled);
                const VectorXd at_base = own->residuals(screening.base.evaluation);
                s.shift = screening.base.shift;
                s.derivative = scaling.derivative(candidates[c].null);
                for (const double size : scan_of(candidates[c])) {
                    s.sizes.push_back(size);
                    s.moved.push_back(scaling.residuals(size) - at_base);
                }
            } else {
                if (first == nullptr) {
                    differentiate(bench, base, candidates, c, number, s);
                } else { // one run fewer: the difference to the typical size does for a second effect
                    s.shift = screening.base.shift;
                    for (std::size_t i = 0; i < s.shift.size() && !first->items[c].shift.empty(); ++i) {
                        s.shift[i] += first->items[c].shift[i] - first->base.shift[i];
                    }
                }
                if (const auto sizes = scan_of(candidates[c]); !sizes.empty()) {
                    scan(bench, base, c, number + 1, {sizes[0]}, s);
                }
                const int sense = sense_of(candidates[c]);
                if (s.derivative.size() > 0) {
                    least[c] = least_sum(nuisance, base.residuals, s.derivative, sense);
                }
                if (!s.moved.empty() && s.moved[0].size() > 0) {
                    const int side = sense == 0 ? 0 : 1; // the typical size is on the one that exists
                    least[c] = std::min(least[c], least_sum(nuisance, base.residuals, s.moved[0], side));
                }
            }
            progress.add(1, true);
        });
    }
    if (scanned > 0) {
        std::vector<std::size_t> order;
        for (std::size_t c = 0; c < candidates.size(); ++c) {
            if (!signatures[c].sizes.empty() && candidates[c].scaled.empty()) {
                order.push_back(c);
            }
        }
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return least[a] < least[b]; });
        order.resize(std::min(order.size(), scanned));
        run::for_each_index(arena, order.size(), [&](std::size_t i) {
            Signature& s = signatures[order[i]];
            scan(bench, base, order[i], number + 2, further_sizes(candidates[order[i]], s, nuisance, base.residuals),
                 s);
        });
    }
    if (run::interrupted()) {
        return std::nullopt;
    }
    screening.items.resize(candidates.size());
    std::vector<VectorXd> directions;
    std::vector<VectorXd> wholes;  // before what parameters follow was taken out
    std::vector<VectorXd> typical; // the change of a typical size; empty: not computed
    std::vector<int> sense;
    std::vector<std::size_t> owner;
    const double left = static_cast<double>(base.residuals.size() - nuisance.rank());
    const double scale = estimated ? nuisance.beyond(base.residuals).norm() / std::sqrt(std::max(1.0, left)) : noise;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        const Candidate& candidate = candidates[c];
        const Signature& s = signatures[c];
        Screened& item = screening.items[c];
        item.predicted = base.sum;
        item.impossible = s.impossible;
        item.shift = s.shift.empty() ? screening.base.shift : s.shift; // a wrong reading moves no response
        if (!s.impossible.empty()) {
            continue;
        }
        item.sense = sense_of(candidate);
        const double reach = candidate.typical - candidate.null;
        const bool has_moved = !s.moved.empty() && s.moved[0].size() > 0;
        if (s.derivative.size() == 0 && !has_moved) {
            item.impossible = "no answer at a typical size";
            continue;
        }
        // Some effects have no first derivative at their null size.
        constexpr double flat = 0.1;
        if (s.derivative.size() == 0) {
            item.change = s.moved[0] / reach;
        } else if (has_moved && std::abs(reach) * s.derivative.norm() < flat * s.moved[0].norm()) {
            item.change = s.moved[0] / reach;
            item.sense = reach > 0.0 ? 1 : -1;
        } else {
            item.change = s.derivative;
        }
        const VectorXd whole = item.change;
        item.change = nuisance.beyond(item.change);
        constexpr double invisible = 0.05; // standard deviations, crossing the whole range
        const double length = item.change.norm();
        if (length < invisible * noise) {
            item.impossible = "the fitted parameters can reproduce it, or no reading is sensitive to it";
            continue;
        }
        const VectorXd direction = item.change / length;
        item.score = -direction.dot(base.residuals) / scale;
        for (std::size_t other = 0; other < directions.size(); ++other) {
            if (candidates[owner[other]].effect == candidate.effect &&
                std::abs(directions[other].dot(direction)) > 1.0 - 1e-6) {
                item.duplicate = true;
                // Variants that are alike near none may differ at a size that is seen: a load beside its line, by
                // symmetry.
                item.identical = item.identical ||
                                 (is_same(whole, wholes[other]) &&
                                  (!has_moved || typical[other].size() == 0 || is_same(s.moved[0], typical[other])));
            }
        }
        // Where to start a fit.
        const auto propose = [&](double size, const VectorXd& moved) {
            const VectorXd there = base.residuals + moved;
            const Members members = with_member(base.members, c);
            item.starts.push_back(
                {with_size(nuisance.best_response(base.unit, there / noise), size_index(bench, members, c), size),
                 nuisance.beyond(there).squaredNorm()});
        };
        for (std::size_t i = 0; i < s.sizes.size(); ++i) {
            if (s.moved[i].size() > 0) {
                propose(s.sizes[i], s.moved[i]);
            }
        }
        if (s.sizes.empty()) { // a wrong reading: to the right one
            propose(candidate.null + std::copysign(reach, item.score), s.derivative * (item.score * scale / length));
        }
        std::stable_sort(item.starts.begin(), item.starts.end(),
                         [](const auto& a, const auto& b) { return a.predicted < b.predicted; });
        item.predicted = std::min(item.predicted, item.starts.empty() ? base.sum : item.starts[0].predicted);
        if (item.score * item.sense >= 0.0) {
            item.predicted = std::min(item.predicted, base.sum - item.score * item.score * scale * scale);
        }
        if (!item.duplicate) {
            directions.push_back(direction);
            wholes.push_back(whole);
            typical.push_back(has_moved ? s.moved[0] : VectorXd());
            sense.push_back(item.sense);
            owner.push_back(c);
        }
    }
    if (directions.empty()) {
        return screening;
    }
    MatrixXd all(base.residuals.size(), static_cast<Index>(directions.size()));
    for (std::size_t j = 0; j < directions.size(); ++j) {
        all.col(static_cast<Index>(j)) = directions[j];
    }
    screening.family.emplace(all, sense, nuisance, estimated, seed,
                             [&](VectorXd deviates) { return own->noise_rows(base.evaluation, std::move(deviates)); });
    constexpr double level = 0.05;
    screening.threshold = screening.family->threshold(level);
    for (Screened& item : screening.items) {
        if (item.impossible.empty()) {
            const double counted = item.sense == 0 ? std::abs(item.score) : std::max(0.0, item.sense * item.score);
            item.p_familywise = counted > 0.0 ? screening.family->p_value(counted) : 1.0;
            if (!item.duplicate) {
                screening.p_familywise = std::min(screening.p_familywise, item.p_familywise);
            }
        }
    }
    return screening;
}

} // namespace explore::diagnose

#include "fe/deadline.h"
#include "fe/reduced_motion.h"
#include "fe/whole_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace pave::fe {
namespace {

// The mean of 1/E along a straight path from one stress by another. Where little confines at rest it begins as one over
// the root of the share of the way: share = x^2.
template <class Stress>
double softness(const LayerMaterial& layer, const Stress& from, const Stress& by) {
    double sum = 0.0;
    for (const auto& [xi, weight] : three_points) {
        const double x = (1.0 + xi) / 2.0;
        const auto at = mechanics::invariants<Stress::RowsAtCompileTime>(Stress(from + x * x * by));
        sum += weight * x / layer.law->modulus(layer.parameters, at).value;
    }
    return sum;
}

// Of the stress-dependent layers: the strain at the end beyond that which its stress is reached with along a straight
// path from rest, over that of a displacement where it is largest, as roots of energy with the moduli there.
template <class Element, class Work>
double kept_share(const Work& w, const PathState<Element>& end, const Eigen::VectorXd& largest_u,
                  const Eigen::VectorXd& largest_modulus) {
    using Stress = typename Element::Stress;
    double kept = 0.0;
    double all = 0.0;
    for (int q = 0; q < w.points(); ++q) {
        const int e = w.active[q / Element::gauss];
        const int g = q % Element::gauss;
        const LayerMaterial& layer = w.layer_of(e);
        const auto strain_of = [&](const Eigen::VectorXd& u) {
            return Stress(Element::strain(w.point(e, g), w.model->gather(e, u.data())));
        };
        Stress beyond = strain_of(end.u);
        if (w.energies.at(q) != nullptr) {
            beyond -= w.energies.strain_of_load(q, w.initial[q] + end.stress.col(q));
        } else {
            beyond -=
                softness(layer, w.initial[q], Stress(end.stress.col(q))) * (w.compliance(e, g) * end.stress.col(q));
        }
        const Stress largest = strain_of(largest_u);
        const double stiffness = w.point(e, g).weight * largest_modulus[q];
        kept += stiffness * beyond.dot(w.unit(e, g) * beyond);
        all += stiffness * largest.dot(w.unit(e, g) * largest);
    }
    return all > 0.0 ? std::sqrt(kept / all) : 0.0;
}

// A step of h from u, v and the stress there. At its middle the velocity is du/h and the acceleration
// 2 (du/h - v)/h, so that twice the equation of motion there is
//     (4/h^2 M + 2/h C + K) du = 2 f - 2 F + 4/h M v,
// with f the mean load and F the internal forces before the step; K and C hold the moduli at the middle. What relaxes
// has its K as the share of the change that it still feels half a step on, and its F as what is felt then of u.
// motion: of all unknowns or of a subspace. path: its buffers. ended(i, now, by): after step i.
template <class Element, class Space, class Work, class Ended>
std::optional<Failure> march(const Work& w, Space& motion, LoadPath<PathState<Element>>& path, const Pulse& pulse,
                             const std::vector<double>& factors, std::vector<Memory>& memories,
                             const SolverSettings& settings, Marched<Element>& result, Ended ended) {
    using State = PathState<Element>;
    const int points = motion.points();
    const int count = w.count();
    const Eigen::Index unknowns = motion.unknowns();
    const double h = pulse.step;
    const Eigen::VectorXd& load = motion.load();
    path.set_zero(static_cast<int>(unknowns), points, count);
    State& now = path.now;
    State& change = path.slope[0];
    State& ahead = path.trial; // at the middle of the step
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns);
    Rates dv = Rates::Zero(unknowns, count);
    const auto kinetic_energy = [&] {
        Eigen::VectorXd momentum = Eigen::VectorXd::Zero(unknowns);
        motion.add_mass(1.0, v, momentum);
        return momentum.dot(v) / 2.0;
    };
    double most_work = 0.0;
    const Deadline deadline(settings.time_limit);
    std::vector<Eigen::VectorXd> felt(memories.size());
    std::vector<Eigen::MatrixXd> felt_rates(memories.size());
    for (std::size_t i = 0; i < pulse.means.size(); ++i) {
        if (deadline.has_passed()) {
            return Deadline::failure();
        }
        const double factor = pulse.means[i];
        if (points > 0) {
            // As in the step before.
            ahead.stress = now.stress + 0.5 * change.stress;
            ahead.d_stress = now.d_stress + 0.5 * change.d_stress;
            motion.set_moduli(ahead.stress, ahead.d_stress);
        }
        if (!motion.set_matrix()) {
            return stiffness_not_definite();
        }
        Eigen::VectorXd& du = change.u;
        du = factor * load;
        motion.add_lasting(-1.0, now.u, du);
        motion.subtract_force(now.stress, 1, 0, du);
        for (std::size_t m = 0; m < memories.size(); ++m) {
            felt[m] = memories[m].before(h / 2.0, now.u);
            motion.add_layer(memories[m].layer, -1.0, felt[m], du);
        }
        du *= 2.0;
        motion.add_mass(4.0 / h, v, du);
        if (!motion.solve(du)) {
            return stiffness_not_definite();
        }

        Eigen::MatrixXd& right = change.du;
        right = factor * motion.load_rates();
        if (count > 0) {
            motion.add_history_rates(2.0 / h, dv, now.du, right);
        }
        for (int k = 0; k < count; ++k) {
            auto column = right.col(k);
            motion.subtract_force(now.d_stress, count, k, column);
            motion.subtract_force_motion(k, now.stress, column);
            for (const Memory& m : memories) {
                motion.add_layer(m.layer, -1.0, m.before_rate(h / 2.0, now.u, now.du.col(k), k), column);
            }
        }
        right *= 2.0;
        if (count > 0) {
            // Twice what F answers to, and what K and C do.
            const Eigen::VectorXd both = 2.0 * now.u + du;
            std::vector<Eigen::VectorXd> by_layer;
            by_layer.reserve(factors.size());
            for (const double of_change : factors) {
                by_layer.emplace_back(2.0 * now.u + of_change * du);
            }
            for (std::size_t m = 0; m < memories.size(); ++m) {
                by_layer[memories[m].layer] = 2.0 * felt[m] + factors[memories[m].layer] * du;
            }
            std::vector<const Eigen::VectorXd*> by;
            by.reserve(by_layer.size());
            for (const Eigen::VectorXd& x : by_layer) {
                by.push_back(&x);
            }
            const Eigen::VectorXd slowed = v - du / h;
            for (int k = 0; k < count; ++k) {
                auto column = right.col(k);
                const Variation& variation = (*w.variations)[static_cast<std::size_t>(k)];
                motion.add_mass_rate(k, 4.0 / h, slowed, column);
                motion.add_spring_rate(k, -1.0, both, column);
                motion.add_dashpot_rate(k, -2.0 / h, du, column);
                motion.subtract_linear_rate(k, both, by, column);
                for (const Memory& m : memories) {
                    motion.add_layer(m.layer, -m.share_rate(h / 2.0, k), du, column);
                }
                if (variation.kind == Variation::Kind::damping && !w.prepared[variation.layer].stress_dependent) {
                    motion.add_layer(static_cast<std::size_t>(variation.layer), -2.0 / h, du, column);
                }
            }
        }
        motion.set_stress(du, change.stress, change.d_stress, right);
        for (int k = 0; k < count; ++k) {
            const Variation& variation = (*w.variations)[static_cast<std::size_t>(k)];
            if (variation.kind == Variation::Kind::damping && w.prepared[variation.layer].stress_dependent) {
                Eigen::VectorXd force = Eigen::VectorXd::Zero(unknowns);
                motion.subtract_force(change.stress, 1, 0, force, variation.layer);
                right.col(k) += 2.0 / h * force;
            }
        }
        if (count > 0) {
            if (!motion.solve(right)) {
                return stiffness_not_definite();
            }
            motion.add_stress_rates(right, change.d_stress);
        }

        result.work += factor * load.dot(du);
        Eigen::VectorXd resisting = Eigen::VectorXd::Zero(unknowns);
        motion.add_dashpots(1.0 / h, du, resisting);
        result.absorbed += resisting.dot(du);
        now.add(1.0, change);
        motion.settle(now, change);
        v = 2.0 / h * du - v;
        dv = 2.0 / h * right - dv;
        if (points > 0) { // what is linear cannot give back more than it got
            most_work = std::max(most_work, result.work);
            constexpr double much = 4.0;
            if (!(kinetic_energy() <= much * most_work)) {
                return Failure{Status::failed,
                               "the motion grows beyond what the load puts into the section: the moduli of "
                               "stress-dependent layers do not settle under a load so sudden. Give the layers damping "
                               "(damping_time_ms), or the history a rise that takes longer"};
            }
        }
        Felt by = motion.felt_by_all(now);
        for (std::size_t m = 0; m < memories.size(); ++m) {
            memories[m].advance(h, du, right);
            felt[m] = memories[m].felt(now.u);
            felt_rates[m] = memories[m].felt_rates(now.u, now.du);
            by.u[memories[m].layer] = &felt[m];
            by.du[memories[m].layer] = &felt_rates[m];
        }
        motion.read_all(now, by, i, result.course);
        ended(i, now, by);
    }
    result.kinetic = kinetic_energy();
    return std::nullopt;
}

} // namespace

template <class Element>
Outcome<Marched<Element>>
Solver<Element>::pulse(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load, const Pulse& pulse,
                       const std::vector<Functional<Element>>& readings, const std::vector<Variation>& variations,
                       const SolverSettings& settings, const std::vector<double>& springs,
                       const std::vector<Motion<Element>>& motions, const Subspace* subspace) {
    using State = PathState<Element>;
    Work& w = *work_;
    SolverSettings exact = settings; // nothing brings back to equilibrium what adds up over the steps
    exact.linear_tolerance = std::min(settings.linear_tolerance, 1e-6);
    w.prepare(layers, variations, exact, springs, motions);
    const int points = w.points();
    const int count = w.count();
    const double h = pulse.step;
    std::vector<Memory> memories =
        memories_of(layers, variations, subspace != nullptr ? subspace->modes.cols() : w.model->free_unknowns());

    // Of each layer: what K + 2/h C is of its stiffness, and F of that.
    std::vector<double> factors;
    factors.reserve(layers.size());
    std::vector<double> shares(layers.size(), 1.0);
    for (const LayerMaterial& layer : layers) {
        factors.push_back(1.0 + 2.0 * layer.damping_time / h);
    }
    for (const Memory& m : memories) {
        factors[m.layer] += m.share(h / 2.0) - 1.0;
        shares[m.layer] = 0.0;
    }
    const std::size_t steps = pulse.means.size();
    const auto largest =
        static_cast<std::size_t>(std::max_element(pulse.means.begin(), pulse.means.end()) - pulse.means.begin());
    Marched<Element> result;
    result.course = Course(static_cast<Eigen::Index>(readings.size()), steps, count, false);
    auto& path = w.path;
    path.set_zero(static_cast<int>(w.model->free_unknowns()), points, count);
    w.set_moduli(path.now.stress, path.now.d_stress);
    if (subspace != nullptr) {
        ReducedMotion<Element, Work> motion(w, *subspace, readings, load, factors, shares, h);
        if (const auto failure = march<Element>(w, motion, path, pulse, factors, memories, settings, result,
                                                [](std::size_t, const State&, const Felt&) {})) {
            return *failure;
        }
        result.at_largest.statistics.load_steps = static_cast<int>(steps);
        return result;
    }
    double largest_stress = 0.0;
    Eigen::VectorXd largest_u; // when it was reached
    Eigen::VectorXd largest_modulus;
    WholeMotion<Element, Work> motion(w, readings, load, factors, shares, h);
    const auto ended = [&](std::size_t i, const State& now, const Felt& by) {
        if (on_march_) {
            on_march_(now.u, w.modulus);
        }
        double stress = 0.0; // of the stress-dependent layers, squared
        for (int q = 0; q < points; ++q) {
            stress +=
                w.point(w.active[q / Element::gauss], q % Element::gauss).weight * now.stress.col(q).squaredNorm();
        }
        if (stress > largest_stress) {
            largest_stress = stress;
            largest_u = now.u;
            largest_modulus = w.modulus;
        }
        if (i == largest) {
            result.at_largest = w.solution_at(now, by, pulse.means[i] * load);
        }
    };
    if (const auto failure = march<Element>(w, motion, path, pulse, factors, memories, settings, result, ended)) {
        return *failure;
    }
    Statistics& statistics = result.at_largest.statistics;
    statistics.residual_relative = 0.0; // of motion: none is left
    constexpr double nothing = 0.05;    // of the largest load
    if (largest_stress > 0.0 && std::abs(pulse.means.back()) < nothing * pulse.means[largest]) {
        statistics.kept_share = kept_share(w, path.now, largest_u, largest_modulus);
    }
    statistics.load_steps = static_cast<int>(steps);
    statistics.factorizations = w.system.factorizations();
    return result;
}

template Outcome<Marched<AxisymmetricQ8>>
Solver<AxisymmetricQ8>::pulse(const std::vector<LayerMaterial>&, const Eigen::VectorXd&, const Pulse&,
                              const std::vector<Functional<AxisymmetricQ8>>&, const std::vector<Variation>&,
                              const SolverSettings&, const std::vector<double>&,
                              const std::vector<Motion<AxisymmetricQ8>>&, const Subspace*);
template Outcome<Marched<Hex20>> Solver<Hex20>::pulse(const std::vector<LayerMaterial>&, const Eigen::VectorXd&,
                                                      const Pulse&, const std::vector<Functional<Hex20>>&,
                                                      const std::vector<Variation>&, const SolverSettings&,
                                                      const std::vector<double>&, const std::vector<Motion<Hex20>>&,
                                                      const Subspace*);

} // namespace pave::fe

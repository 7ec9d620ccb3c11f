#include "fe/boundary.h"
#include "fe/deadline.h"
#include "fe/memory.h"
#include "fe/rates.h"
#include "fe/solver_work.h"

#include <algorithm>
#include <cmath>

namespace pave::fe {
namespace {

// to += factor * values; empty values: zero.
void add(double factor, const std::vector<double>& values, std::vector<double>& to) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        to[i] += factor * values[i];
    }
}

// A matrix of few entries.
Spring sparse(const Pattern& lower, const std::vector<double>& values) {
    Spring matrix;
    for (int j = 0; j < lower.size && !values.empty(); ++j) {
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            if (values[static_cast<std::size_t>(k)] != 0.0) {
                matrix.entries.push_back({lower.row[k], j, k, values[static_cast<std::size_t>(k)]});
            }
        }
    }
    return matrix;
}

// Mass of every layer, or of one as if its unit weight were 1.
template <class Work, class Element>
std::vector<double> mass_of(const Work& w, const Model<Element>& model, const Variation* by) {
    std::vector<double> mass(w.topology->lower.row.size(), 0.0);
    for (int e = 0; e < model.elements(); ++e) {
        if (by == nullptr) {
            add_mass(model, e, w.layer_of(e).unit_weight / unit::gravity, mass);
        } else if (by->layer == w.topology->layer[e]) {
            add_mass(model, e, 1.0 / unit::gravity, mass);
        }
    }
    return mass;
}

// By a variation; empty: none.
template <class Work>
std::vector<double> mass_rate(const Work& w, int k) {
    const Variation& v = (*w.variations)[static_cast<std::size_t>(k)];
    if (v.kind == Variation::Kind::unit_weight) {
        return mass_of(w, *w.model, &v);
    }
    std::vector<double> rate;
    if (const auto* motion = w.motion_of(k)) {
        rate.assign(w.topology->lower.row.size(), 0.0);
        for (const auto& [weight, there] : motion->beside) {
            add(weight, mass_of(w, there, nullptr), rate);
        }
    }
    return rate;
}

template <class Element, class Work>
Sides sides_rate(const Work& w, int k) {
    Sides rate = OpenSides<Element, Work>(w, *w.model).rates(k);
    if (const auto* motion = w.motion_of(k)) {
        rate.dashpots.resize(w.topology->lower.row.size(), 0.0);
        rate.springs.resize(w.topology->lower.row.size(), 0.0);
        for (const auto& [weight, there] : motion->beside) {
            const Sides sides = OpenSides<Element, Work>(w, there).matrices();
            add(weight, sides.dashpots, rate.dashpots);
            add(weight, sides.springs, rate.springs);
        }
    }
    return rate;
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
        // The mean of 1/E over the path. Where little confines at rest it begins as one over the root of the share of
        // the way: share = x^2.
        double softness = 0.0;
        for (const auto& [xi, weight] : three_points) {
            const double x = (1.0 + xi) / 2.0;
            const Stress total = w.initial[q] + x * x * end.stress.col(q);
            const auto at = mechanics::invariants<Element::voigt>(total);
            softness += weight * x / layer.law->modulus(layer.parameters, at).value;
        }
        const auto strain_of = [&](const Eigen::VectorXd& u) {
            return Stress(Element::strain(w.point(e, g), w.model->gather(e, u.data())));
        };
        const Stress beyond = strain_of(end.u) - softness * (w.compliance(e, g) * end.stress.col(q));
        const Stress largest = strain_of(largest_u);
        const double stiffness = w.point(e, g).weight * largest_modulus[q];
        kept += stiffness * beyond.dot(w.unit(e, g) * beyond);
        all += stiffness * largest.dot(w.unit(e, g) * largest);
    }
    return all > 0.0 ? std::sqrt(kept / all) : 0.0;
}

} // namespace

// A step of h from u, v and the stress there. At its middle the velocity is du/h and the acceleration
// 2 (du/h - v)/h, so that twice the equation of motion there is
//     (4/h^2 M + 2/h C + K) du = 2 f - 2 F + 4/h M v,
// with f the mean load and F the internal forces before the step; K and C hold the moduli at the middle. What relaxes
// has its K as the share of the change that it still feels half a step on, and its F as what is felt then of u.
template <class Element>
Outcome<Marched<Element>> Solver<Element>::pulse(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                                                 const Pulse& pulse, const std::vector<Functional<Element>>& readings,
                                                 const std::vector<Variation>& variations,
                                                 const SolverSettings& settings, const std::vector<double>& springs,
                                                 const std::vector<Motion<Element>>& motions) {
    using State = PathState<Element>;
    using Kind = Variation::Kind;
    Work& w = *work_;
    SolverSettings exact = settings; // nothing brings back to equilibrium what adds up over the steps
    exact.linear_tolerance = std::min(settings.linear_tolerance, 1e-6);
    w.prepare(layers, variations, exact, springs, motions);
    const Pattern& lower = w.topology->lower;
    const int points = w.points();
    const int count = w.count();
    const Eigen::Index unknowns = w.model->free_unknowns();
    const double h = pulse.step;
    std::vector<Memory> memories = memories_of(layers, variations, unknowns);

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

    auto& path = w.path;
    path.set_zero(static_cast<int>(unknowns), points, count);
    State& now = path.now;
    State& change = path.slope[0];
    State& ahead = path.trial; // at the middle of the step
    w.set_moduli(now.stress, now.d_stress);
    const Sides sides = OpenSides<Element, Work>(w, *w.model).matrices();
    const Spring dashpots = sparse(lower, sides.dashpots);
    const std::vector<double> mass = mass_of(w, *w.model, nullptr);
    std::vector<Spring> spring_rates;
    std::vector<Spring> dashpot_rates;
    std::vector<std::vector<double>> mass_rates;
    for (int k = 0; k < count; ++k) {
        const Sides rates = sides_rate<Element>(w, k);
        spring_rates.push_back(sparse(lower, rates.springs));
        dashpot_rates.push_back(sparse(lower, rates.dashpots));
        mass_rates.push_back(mass_rate(w, k));
    }

    w.assemble_linear(shares);
    add(1.0, sides.springs, w.linear);
    const std::vector<double> lasting = w.linear; // F of what neither relaxes nor follows the stress
    w.assemble_linear(factors);
    add(1.0, sides.springs, w.linear);
    add(2.0 / h, sides.dashpots, w.linear);
    add(4.0 / (h * h), mass, w.linear);

    Eigen::MatrixXd load_rate;
    w.set_load_rates(load, load_rate);
    Eigen::VectorXd v = Eigen::VectorXd::Zero(unknowns);
    Rates dv = Rates::Zero(unknowns, count);
    Rates rows(unknowns, count);
    const auto of_layer = [&](std::size_t layer, double factor, const Eigen::Ref<const Eigen::VectorXd>& x,
                              Eigen::Ref<Eigen::VectorXd> y) {
        add_product(lower, w.held[layer].values, factor * w.prepared[layer].modulus, x, y);
    };

    const auto n = static_cast<Eigen::Index>(readings.size());
    const std::size_t steps = pulse.means.size();
    const auto largest =
        static_cast<std::size_t>(std::max_element(pulse.means.begin(), pulse.means.end()) - pulse.means.begin());
    Marched<Element> result;
    result.course = Course(n, steps, count, false);
    Course& course = result.course;

    const auto kinetic_energy = [&] {
        Eigen::VectorXd momentum = Eigen::VectorXd::Zero(unknowns);
        add_product(lower, mass, 1.0, v, momentum);
        return momentum.dot(v) / 2.0;
    };
    double most_work = 0.0;
    double largest_stress = 0.0;
    Eigen::VectorXd largest_u; // when it was reached
    Eigen::VectorXd largest_modulus;
    const Deadline deadline(settings.time_limit);
    bool has_matrix = false;
    std::vector<Eigen::VectorXd> felt(memories.size());
    std::vector<Eigen::MatrixXd> felt_rates(memories.size());
    for (std::size_t i = 0; i < steps; ++i) {
        if (deadline.has_passed()) {
            return Deadline::failure();
        }
        const double factor = pulse.means[i];
        if (points > 0) {
            // As in the step before.
            ahead.stress = now.stress + 0.5 * change.stress;
            ahead.d_stress = now.d_stress + 0.5 * change.d_stress;
            w.set_moduli(ahead.stress, ahead.d_stress);
        }
        if (points > 0 || !has_matrix) {
            Eigen::VectorXd acting = w.modulus;
            for (int q = 0; q < points; ++q) {
                acting[q] *= factors[static_cast<std::size_t>(w.topology->layer[w.active[q / Element::gauss]])];
            }
            w.assemble(acting);
            has_matrix = w.system.set_matrix(w.values);
            if (!has_matrix) {
                return stiffness_not_definite();
            }
        }
        Eigen::VectorXd& du = change.u;
        du = factor * load;
        add_product(lower, lasting, -1.0, now.u, du);
        w.subtract_force(now.stress, 1, 0, du);
        for (std::size_t m = 0; m < memories.size(); ++m) {
            felt[m] = memories[m].before(h / 2.0, now.u);
            of_layer(memories[m].layer, -1.0, felt[m], du);
        }
        du *= 2.0;
        add_product(lower, mass, 4.0 / h, v, du);
        if (!w.system.solve(du, {})) {
            return stiffness_not_definite();
        }

        Eigen::MatrixXd& right = change.du;
        right = factor * load_rate;
        if (count > 0) {
            rows.setZero();
            add_product(lower, mass, Rates((2.0 / h) * dv), rows);
            add_product(lower, lasting, Rates(-now.du), rows);
            right += rows;
        }
        for (int k = 0; k < count; ++k) {
            auto column = right.col(k);
            w.subtract_force(now.d_stress, count, k, column);
            w.subtract_force_motion(k, now.stress, column.data());
            for (const Memory& m : memories) {
                of_layer(m.layer, -1.0, m.before_rate(h / 2.0, now.u, now.du.col(k), k), column);
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
            for (int k = 0; k < count; ++k) {
                auto column = right.col(k);
                const Variation& variation = variations[static_cast<std::size_t>(k)];
                if (const auto& rate = mass_rates[static_cast<std::size_t>(k)]; !rate.empty()) {
                    add_product(lower, rate, 4.0 / h, v - du / h, column);
                }
                spring_rates[static_cast<std::size_t>(k)].add_product(both.data(), -1.0, column.data());
                dashpot_rates[static_cast<std::size_t>(k)].add_product(du.data(), -2.0 / h, column.data());
                w.subtract_linear_rate(k, both, by, column.data());
                for (const Memory& m : memories) {
                    of_layer(m.layer, -m.share_rate(h / 2.0, k), du, column);
                }
                if (variation.kind == Kind::damping && !w.prepared[variation.layer].stress_dependent) {
                    of_layer(static_cast<std::size_t>(variation.layer), -2.0 / h, du, column);
                }
            }
        }
        w.set_stress(du, change.stress, change.d_stress, right, factors);
        for (int k = 0; k < count; ++k) {
            const Variation& variation = variations[static_cast<std::size_t>(k)];
            if (variation.kind == Kind::damping && w.prepared[variation.layer].stress_dependent) {
                Eigen::VectorXd force = Eigen::VectorXd::Zero(unknowns);
                w.subtract_force(change.stress, 1, 0, force, variation.layer);
                right.col(k) += 2.0 / h * force;
            }
        }
        if (count > 0) {
            if (!w.system.solve(right, {})) {
                return stiffness_not_definite();
            }
            w.add_stress_rates(right, change.d_stress);
        }

        result.work += factor * load.dot(du);
        Eigen::VectorXd resisting = Eigen::VectorXd::Zero(unknowns);
        dashpots.add_product(du.data(), 1.0 / h, resisting.data());
        result.absorbed += resisting.dot(du);
        now.add(1.0, change);
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
        Felt by = w.felt_by_all(now.u, now.du);
        for (std::size_t m = 0; m < memories.size(); ++m) {
            memories[m].advance(h, du, right);
            felt[m] = memories[m].felt(now.u);
            felt_rates[m] = memories[m].felt_rates(now.u, now.du);
            by.u[memories[m].layer] = &felt[m];
            by.du[memories[m].layer] = &felt_rates[m];
        }
        w.read_all(readings, now, by, i, course);
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
            result.at_largest = w.solution_at(now, by, factor * load);
        }
    }
    result.kinetic = kinetic_energy();
    Statistics& statistics = result.at_largest.statistics;
    statistics.residual_relative = 0.0; // of motion: none is left
    constexpr double nothing = 0.05;    // of the largest load
    if (largest_stress > 0.0 && std::abs(pulse.means.back()) < nothing * pulse.means[largest]) {
        statistics.kept_share = kept_share(w, now, largest_u, largest_modulus);
    }
    statistics.load_steps = static_cast<int>(steps);
    statistics.factorizations = w.system.factorizations();
    return result;
}

template Outcome<Marched<AxisymmetricQ8>>
Solver<AxisymmetricQ8>::pulse(const std::vector<LayerMaterial>&, const Eigen::VectorXd&, const Pulse&,
                              const std::vector<Functional<AxisymmetricQ8>>&, const std::vector<Variation>&,
                              const SolverSettings&, const std::vector<double>&,
                              const std::vector<Motion<AxisymmetricQ8>>&);
template Outcome<Marched<Hex20>> Solver<Hex20>::pulse(const std::vector<LayerMaterial>&, const Eigen::VectorXd&,
                                                      const Pulse&, const std::vector<Functional<Hex20>>&,
                                                      const std::vector<Variation>&, const SolverSettings&,
                                                      const std::vector<double>&, const std::vector<Motion<Hex20>>&);

} // namespace pave::fe

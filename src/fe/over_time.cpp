#include "fe/solver_work.h"

#include <cmath>

namespace pave::fe {
namespace {

// What is left of a displacement after it fades with a time of relaxation: v' = u' - v/time. Stress in a layer that
// relaxes is E C B f with f = (1 - sum of shares) u + sum of share v, for v of its terms: the strains of its memory are
// those of displacements.
struct Term {
    material::Relaxation is;
    std::vector<material::Relaxation> rates; // by every variation
    Eigen::VectorXd v;
    Eigen::MatrixXd dv;
};

// A step of a term: v becomes kept v + grown (change of u), exact where u changes evenly.
struct Fading {
    double kept, grown;
    double d_kept, d_grown; // by the time of relaxation
    Fading(double time, double step) {
        const double x = step / time;
        kept = std::exp(-x);
        grown = -std::expm1(-x) / x;
        d_kept = kept * x / time;
        d_grown = (grown - kept) / time;
    }
};

struct Memory {
    std::size_t layer = 0;
    std::vector<Term> terms;

    // f after a step: before + share (change of u).
    double share(double step) const {
        double s = 1.0;
        for (const Term& t : terms) {
            s -= t.is.share * (1.0 - Fading(t.is.time, step).grown);
        }
        return s;
    }
    double share_rate(double step, int k) const {
        double s = 0.0;
        for (const Term& t : terms) {
            const Fading f(t.is.time, step);
            const material::Relaxation& d = t.rates[static_cast<std::size_t>(k)];
            s += t.is.share * f.d_grown * d.time - d.share * (1.0 - f.grown);
        }
        return s;
    }
    Eigen::VectorXd before(double step, const Eigen::VectorXd& u) const {
        Eigen::VectorXd f = u;
        for (const Term& t : terms) {
            f += t.is.share * (Fading(t.is.time, step).kept * t.v - u);
        }
        return f;
    }
    Eigen::VectorXd before_rate(double step, const Eigen::VectorXd& u, const Eigen::VectorXd& du, int k) const {
        Eigen::VectorXd f = du;
        for (const Term& t : terms) {
            const Fading fading(t.is.time, step);
            const material::Relaxation& d = t.rates[static_cast<std::size_t>(k)];
            f += t.is.share * (fading.kept * t.dv.col(k) + fading.d_kept * d.time * t.v - du) +
                 d.share * (fading.kept * t.v - u);
        }
        return f;
    }
    // Of the change of u in a step.
    void advance(double step, const Eigen::VectorXd& change, const Eigen::MatrixXd& d_change) {
        for (Term& t : terms) {
            const Fading f(t.is.time, step);
            for (Eigen::Index k = 0; k < d_change.cols(); ++k) {
                const double d_time = t.rates[static_cast<std::size_t>(k)].time;
                t.dv.col(k) =
                    f.kept * t.dv.col(k) + f.grown * d_change.col(k) + d_time * (f.d_kept * t.v + f.d_grown * change);
            }
            t.v = f.kept * t.v + f.grown * change;
        }
    }
    // f itself.
    Eigen::VectorXd felt(const Eigen::VectorXd& u) const {
        Eigen::VectorXd f = u;
        for (const Term& t : terms) {
            f += t.is.share * (t.v - u);
        }
        return f;
    }
    Eigen::MatrixXd felt_rates(const Eigen::VectorXd& u, const Eigen::MatrixXd& du) const {
        Eigen::MatrixXd f = du;
        for (const Term& t : terms) {
            f += t.is.share * (t.dv - du);
            for (Eigen::Index k = 0; k < du.cols(); ++k) {
                f.col(k) += t.rates[static_cast<std::size_t>(k)].share * (t.v - u);
            }
        }
        return f;
    }
};

std::vector<Memory> memories_of(const std::vector<LayerMaterial>& layers, const std::vector<Variation>& variations,
                                Eigen::Index unknowns) {
    const auto count = static_cast<Eigen::Index>(variations.size());
    std::vector<Memory> memories;
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const LayerMaterial& layer = layers[l];
        std::vector<Term> terms;
        for (const material::Relaxation& r : layer.law->relaxation(layer.parameters)) {
            terms.push_back({r, {}, Eigen::VectorXd::Zero(unknowns), Eigen::MatrixXd::Zero(unknowns, count)});
        }
        for (const Variation& v : variations) {
            const bool own = v.kind == Variation::Kind::law_parameter && v.layer == static_cast<int>(l);
            const auto rates = own ? layer.law->relaxation_derivative(layer.parameters, v.index)
                                   : std::vector<material::Relaxation>(terms.size());
            for (std::size_t i = 0; i < terms.size(); ++i) {
                Term& t = terms[i];
                t.rates.push_back(rates[i]);
                if (v.kind == Variation::Kind::duration) { // shorter steps fade as longer times do
                    t.rates.back().time -= t.is.time;
                }
            }
        }
        if (!terms.empty()) {
            memories.push_back({l, std::move(terms)});
        }
    }
    return memories;
}

} // namespace

template <class Element>
Outcome<Relaxed<Element>>
Solver<Element>::over_time(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                           const History& history, const std::vector<Functional<Element>>& readings,
                           const std::vector<Variation>& variations, const SolverSettings& settings,
                           const std::vector<double>& springs) {
    using Stress = typename Element::Stress;
    using State = PathState<Element>;
    Work& w = *work_;
    static const std::vector<Motion<Element>> no_motions;
    w.prepare(layers, variations, settings, springs, no_motions);
    const Pattern& lower = w.topology->lower;
    const int points = w.points();
    const int count = w.count();
    const Eigen::Index unknowns = w.model->free_unknowns();
    std::vector<Memory> memories = memories_of(layers, variations, unknowns);
    std::vector<double> shares(layers.size(), 1.0);
    for (const Memory& m : memories) {
        shares[m.layer] = 0.0;
    }
    w.assemble_linear(shares);
    const std::vector<double> lasting = w.linear; // springs and layers that do not relax
    Eigen::MatrixXd load_rate;
    w.set_load_rates(load, load_rate);

    auto& path = w.path;
    path.set_zero(static_cast<int>(unknowns), points, count);
    State& now = path.now;
    State* change = path.slope; // over half a step, and in turns over a step
    std::array<bool, 3> known{};
    using Guess = Eigen::Map<const Eigen::MatrixXd>;
    const auto guesses = [&](int out, bool of_derivatives) {
        std::vector<Guess> list;
        for (int i = 0; i < 3; ++i) {
            if (i == out ? of_derivatives : known[static_cast<std::size_t>(i)]) {
                list.emplace_back(change[i].u.data(), unknowns, 1);
                if (i != out && of_derivatives) {
                    list.emplace_back(change[i].du.data(), unknowns, count);
                }
            }
        }
        return list;
    };

    // change[number] := that from the state of now to the load times `factor` in `step` seconds, with the moduli at
    // hand. False: not definite.
    bool has_matrix = false;
    const auto solve_step = [&](int number, double factor, double step) {
        State& out = change[number];
        if (points > 0 || !has_matrix) {
            for (const Memory& m : memories) {
                shares[m.layer] = m.share(step);
            }
            w.assemble_linear(shares);
            w.assemble(w.modulus);
            has_matrix = w.system.set_matrix(w.values);
            if (!has_matrix) {
                return false;
            }
        }
        const auto product = [&](const Memory& m, const Eigen::Ref<const Eigen::VectorXd>& x,
                                 Eigen::Ref<Eigen::VectorXd> y) {
            add_product(lower, w.held[m.layer].values, -w.prepared[m.layer].modulus, x, y);
        };
        out.u = factor * load;
        add_product(lower, lasting, -1.0, now.u, out.u);
        w.subtract_force(now.stress, 1, 0, out.u);
        std::vector<Eigen::VectorXd> felt;
        felt.reserve(memories.size());
        for (const Memory& m : memories) {
            felt.push_back(m.before(step, now.u));
            product(m, felt.back(), out.u);
        }
        if (!w.system.solve(out.u, guesses(number, false))) {
            return false;
        }
        const Eigen::VectorXd reached = now.u + out.u;
        std::vector<const Eigen::VectorXd*> by(layers.size(), &reached);
        for (std::size_t m = 0; m < memories.size(); ++m) {
            felt[m] += memories[m].share(step) * out.u;
            by[memories[m].layer] = &felt[m];
        }
        out.du = factor * load_rate;
        for (int k = 0; k < count; ++k) {
            auto right = out.du.col(k);
            add_product(lower, lasting, -1.0, now.du.col(k), right);
            w.subtract_force(now.d_stress, count, k, right);
            for (const Memory& m : memories) {
                product(m, m.before_rate(step, now.u, now.du.col(k), k) + m.share_rate(step, k) * out.u, right);
            }
            w.subtract_linear_rate(k, reached, by, right.data());
        }
        w.set_stress(out.u, out.stress, out.d_stress, out.du);
        if (count > 0) {
            if (!w.system.solve(out.du, guesses(number, true))) {
                return false;
            }
            w.add_stress_rates(out.du, out.d_stress);
        }
        known[static_cast<std::size_t>(number)] = true;
        return true;
    };

    std::vector<int> active_number(static_cast<std::size_t>(w.model->elements()), -1);
    for (std::size_t a = 0; a < w.active.size(); ++a) {
        active_number[static_cast<std::size_t>(w.active[a])] = static_cast<int>(a);
    }
    const auto n = static_cast<Eigen::Index>(readings.size());
    const std::size_t steps = history.factors.size();
    const std::size_t largest = history.largest();
    Relaxed<Element> result;
    result.course = Course(n, steps, count, false);
    Course& course = result.course;

    double before = 0.0;
    for (std::size_t i = 0; i < steps; ++i) {
        const double factor = history.factors[i];
        w.set_moduli(now.stress, now.d_stress);
        if (points > 0) {
            if (!solve_step(0, (before + factor) / 2.0, history.step / 2.0)) {
                return stiffness_not_definite();
            }
            w.set_moduli(now.stress + change[0].stress, now.d_stress + change[0].d_stress);
        }
        const int number = 1 + static_cast<int>(i % 2);
        if (!solve_step(number, factor, history.step)) {
            return stiffness_not_definite();
        }
        before = factor;
        now.add(1.0, change[number]);
        std::vector<Eigen::VectorXd> felt;
        std::vector<Eigen::MatrixXd> felt_rates;
        felt.reserve(memories.size());
        felt_rates.reserve(memories.size());
        Felt by = w.felt_by_all(now.u, now.du);
        for (Memory& m : memories) {
            m.advance(history.step, change[number].u, change[number].du);
            felt.push_back(m.felt(now.u));
            felt_rates.push_back(m.felt_rates(now.u, now.du));
            by.u[m.layer] = &felt.back();
            by.du[m.layer] = &felt_rates.back();
        }
        for (Eigen::Index r = 0; r < n; ++r) {
            const Functional<Element>& f = readings[static_cast<std::size_t>(r)];
            double& value = course.values(r, static_cast<Eigen::Index>(i));
            auto rates = course.d_values[i].row(r);
            value = f.of_displacement(now.u.data());
            for (int k = 0; k < count; ++k) {
                rates[k] = f.of_displacement(now.du.col(k).data());
            }
            for (const auto& [point, weight, direction] : f.on_stress) {
                const int e = point / Element::gauss;
                const int g = point % Element::gauss;
                const auto& p = w.prepared_of(e);
                if (p.stress_dependent) {
                    const Eigen::Index q =
                        static_cast<Eigen::Index>(active_number[static_cast<std::size_t>(e)]) * Element::gauss + g;
                    value += weight * direction.dot(now.stress.col(q));
                    for (int k = 0; k < count; ++k) {
                        rates[k] += weight * direction.dot(now.d_stress.col(q * count + k));
                    }
                    continue;
                }
                const auto layer = static_cast<std::size_t>(w.topology->layer[e]);
                const Stress strain = Element::strain(w.point(e, g), w.model->gather(e, by.u[layer]->data()));
                value += weight * p.modulus * direction.dot(w.unit(e, g) * strain);
                for (int k = 0; k < count; ++k) {
                    const Stress rate = Element::strain(w.point(e, g), w.model->gather(e, by.du[layer]->col(k).data()));
                    rates[k] += weight * direction.dot(p.modulus * (w.unit(e, g) * rate) +
                                                       w.linear_stiffness_rate(e, g, k) * strain);
                }
            }
        }
        if (i == largest) {
            Solution<Element>& shown = result.at_largest = w.empty_solution();
            shown.displacement = now.u;
            shown.d_displacement = now.du;
            w.set_moduli(now.stress, now.d_stress);
            w.store(now.stress, now.d_stress, shown);
            w.finish(factor * load, by, shown);
        }
    }
    Statistics& statistics = result.at_largest.statistics;
    statistics.load_steps = static_cast<int>(steps);
    statistics.factorizations = w.system.factorizations();
    statistics.iterations = w.system.iterations();
    return result;
}

template Outcome<Relaxed<AxisymmetricQ8>>
Solver<AxisymmetricQ8>::over_time(const std::vector<LayerMaterial>&, const Eigen::VectorXd&, const History&,
                                  const std::vector<Functional<AxisymmetricQ8>>&, const std::vector<Variation>&,
                                  const SolverSettings&, const std::vector<double>&);
template Outcome<Relaxed<Hex20>> Solver<Hex20>::over_time(const std::vector<LayerMaterial>&, const Eigen::VectorXd&,
                                                          const History&, const std::vector<Functional<Hex20>>&,
                                                          const std::vector<Variation>&, const SolverSettings&,
                                                          const std::vector<double>&);

} // namespace pave::fe

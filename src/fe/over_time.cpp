#include "fe/memory.h"
#include "fe/solver_work.h"

namespace pave::fe {
template <class Element>
Outcome<Marched<Element>>
Solver<Element>::over_time(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                           const History& history, const std::vector<Functional<Element>>& readings,
                           const std::vector<Variation>& variations, const SolverSettings& settings,
                           const std::vector<double>& springs, const std::vector<Motion<Element>>& motions) {
    using State = PathState<Element>;
    Work& w = *work_;
    w.prepare(layers, variations, settings, springs, motions);
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
        w.subtract_force(now.stress, 1, 0, out.u.data());
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
            w.subtract_force(now.d_stress, count, k, right.data());
            w.subtract_force_motion(k, now.stress, right.data());
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

    const auto n = static_cast<Eigen::Index>(readings.size());
    const std::size_t steps = history.factors.size();
    const std::size_t largest = history.largest();
    Marched<Element> result;
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
        w.settle(now, change[number]);
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
        w.read_all(readings, now, by, i, course);
        if (i == largest) {
            result.at_largest = w.solution_at(now, by, factor * load);
        }
    }
    Statistics& statistics = result.at_largest.statistics;
    statistics.load_steps = static_cast<int>(steps);
    statistics.factorizations = w.system.factorizations();
    statistics.iterations = w.system.iterations();
    return result;
}

template Outcome<Marched<AxisymmetricQ8>>
Solver<AxisymmetricQ8>::over_time(const std::vector<LayerMaterial>&, const Eigen::VectorXd&, const History&,
                                  const std::vector<Functional<AxisymmetricQ8>>&, const std::vector<Variation>&,
                                  const SolverSettings&, const std::vector<double>&,
                                  const std::vector<Motion<AxisymmetricQ8>>&);
template Outcome<Marched<Hex20>> Solver<Hex20>::over_time(const std::vector<LayerMaterial>&, const Eigen::VectorXd&,
                                                          const History&, const std::vector<Functional<Hex20>>&,
                                                          const std::vector<Variation>&, const SolverSettings&,
                                                          const std::vector<double>&,
                                                          const std::vector<Motion<Hex20>>&);

} // namespace pave::fe

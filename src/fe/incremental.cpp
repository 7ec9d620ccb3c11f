#include "fe/solver_work.h"

#include <algorithm>
#include <cmath>

namespace pave::fe {
template <class Element>
Outcome<Solution<Element>>
Solver<Element>::incremental(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                             const std::vector<Variation>& variations, const SolverSettings& settings,
                             const std::vector<double>& springs, const std::vector<Motion<Element>>& motions,
                             const std::vector<double>& on_the_way) {
    using Vector = typename Element::Vector;
    Work& w = *work_;
    w.prepare(layers, variations, settings, springs, motions);
    const int points = w.points();
    const int count = w.count();
    Solution<Element> solution = w.empty_solution();
    Statistics& statistics = solution.statistics;

    const Deadline deadline(settings.time_limit);
    using State = PathState<Element>;
    auto& path = w.path;
    path.set_zero(w.model->free_unknowns(), points, count);
    State* slope = path.slope;
    State& now = path.now;
    State& last = path.trial; // once a step has ended, its start
    Eigen::VectorXd& modulus = w.modulus;

    // Rates found before span something near the next one; so do, for the derivatives of a rate, they and the rates.
    std::array<bool, LoadPath<State>::stages> known{};
    using Guess = Eigen::Map<const Eigen::MatrixXd>;
    const auto guesses = [&](const State& out, bool of_derivatives) {
        std::vector<Guess> list;
        for (int i = 0; i < LoadPath<State>::stages; ++i) {
            const State& state = slope[i];
            const bool before = known[i] && &state != &out;
            if (before || (of_derivatives && &state == &out)) {
                list.emplace_back(state.u.data(), state.u.size(), 1);
            }
            if (before && of_derivatives) {
                list.emplace_back(state.du.data(), state.u.size(), count);
            }
        }
        return list;
    };

    // d(state)/d(load factor) at a state, slope[number]: one matrix, 1 + count right-hand sides. False: not definite.
    const auto rate = [&](const State& x, int number) {
        State& out = slope[number];
        w.set_moduli(x.stress, x.d_stress);
        w.assemble(modulus);
        out.u = load;
        if (!w.system.set_matrix(w.values) || !w.system.solve(out.u, guesses(out, false))) {
            return false;
        }
        if (count > 0) {
            w.set_load_rates(load, out.du);
            w.subtract_linear_rates(out.u, out.du);
        }
        w.set_stress(out.u, out.stress, out.d_stress, out.du);
        if (count > 0) {
            if (!w.system.solve(out.du, guesses(out, true))) {
                return false;
            }
            w.add_stress_rates(out.du, out.d_stress);
        }
        known[number] = true;
        return true;
    };

    solution.on_the_way.resize(on_the_way.size());
    double before = 0.0; // the load factor of `trial` and of the last slope, once a step has ended
    const auto note_the_way = [&](double load_factor) {
        const double h = load_factor - before;
        for (std::size_t i = 0; i < on_the_way.size(); ++i) {
            if (!(on_the_way[i] > before && on_the_way[i] <= load_factor)) {
                continue;
            }
            const double t = (on_the_way[i] - before) / h;
            const double from = (1.0 + 2.0 * t) * (1.0 - t) * (1.0 - t);
            const double from_rate = h * t * (1.0 - t) * (1.0 - t);
            const double to_rate = h * t * t * (t - 1.0);
            const State& old_rate = path.rate_before();
            solution.on_the_way[i] = {
                from * last.u + (1.0 - from) * now.u + from_rate * old_rate.u + to_rate * slope[0].u,
                from * last.du + (1.0 - from) * now.du + from_rate * old_rate.du + to_rate * slope[0].du};
        }
        before = load_factor;
    };

    const Failure not_definite = stiffness_not_definite();
    if (points == 0) { // linear: the rate is the same all along
        if (!rate(now, 0)) {
            // The matrix is definite: every stiffness is the study's own.
            return Failure{Status::failed,
                           "the stiffness matrix of the section cannot be factorised: moduli or sizes of "
                           "cells of the mesh differ by too many orders of magnitude"};
        }
        now.u = slope[0].u;
        now.du = slope[0].du;
        for (std::size_t i = 0; i < on_the_way.size(); ++i) {
            solution.on_the_way[i] = {on_the_way[i] * now.u, on_the_way[i] * now.du};
        }
        statistics.load_steps = 1;
    } else {
        const bool turns = std::any_of(w.prepared.begin(), w.prepared.end(),
                                       [](const auto& layer) { return layer.turns_with_stress; }); // C, too
        const bool rate_at_end = Element::dim == 3 || turns || on_step_ || !on_the_way.empty();
        const auto failure = path.follow(settings.load_steps, rate_at_end, deadline, rate, [&](double load_factor) {
            note_the_way(load_factor);
            if (on_step_) {
                on_step_(load_factor, slope[0].u, modulus);
            }
        });
        if (failure) {
            return *failure;
        }
        statistics.load_steps = settings.load_steps;
        w.behind_end = !rate_at_end;
    }

    // The errors of iterative solutions leave some force unbalanced: one more solve with the last matrix.
    if (Element::dim == 3) {
        Eigen::VectorXd correction = load;
        w.subtract_linear_force(now.u, correction);
        w.subtract_force(now.stress, 1, 0, correction.data());
        if (!w.system.solve(correction, {})) {
            return not_definite;
        }
        now.u += correction;
        for (std::size_t a = 0; a < w.active.size(); ++a) {
            const int e = w.active[a];
            const Vector of_element = w.model->gather(e, correction.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                now.stress.col(q) += modulus[q] * (w.unit(e, g) * Element::strain(w.point(e, g), of_element));
            }
        }
    }

    solution.displacement = now.u;
    solution.d_displacement = now.du;
    w.store(now.stress, now.d_stress, solution);
    w.finish(load, solution);
    statistics.factorizations = w.system.factorizations();
    statistics.iterations = w.system.iterations();
    return solution;
}

template <class Element>
bool Solver<Element>::solve_at_end(Eigen::MatrixXd& right) {
    if (work_->behind_end) {
        work_->catch_up();
        if (!work_->system.set_matrix(work_->values)) {
            return false;
        }
    }
    return work_->system.solve(right, {});
}

template <class Element>
Solver<Element>::Solver(const Model<Element>& model) : work_(std::make_unique<Work>(model)) {}
template <class Element>
Solver<Element>::~Solver() = default;

template <class Element>
void Solver<Element>::move(const Model<Element>& model) {
    work_->model = &model;
    work_->held.clear();
}

template class Solver<AxisymmetricQ8>;
template class Solver<Hex20>;

} // namespace pave::fe

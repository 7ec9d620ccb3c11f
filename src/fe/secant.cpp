#include "fe/gmres.h"
#include "fe/solver_work.h"

#include <cmath>

namespace pave::fe {
namespace {

// The law at a point under the secant definition: E = Ehat(sigma0 + E s), s = C strain, solved for ln E by Newton.
// gain = 1 - (dEhat/dsigma) . s is what makes the point stable; it reaches zero at a fold.
template <int N>
struct SecantPoint {
    double modulus = 0.0;
    mechanics::Voigt<N> gradient; // dEhat/dsigma
    double gain = 0.0;
    mechanics::Invariants at;
};

template <int N>
bool solve_point(const LayerMaterial& layer, const mechanics::Voigt<N>& initial, const mechanics::Voigt<N>& s,
                 double guess, SecantPoint<N>& point) {
    double log_e = std::log(guess);
    for (int iteration = 0; iteration < 60; ++iteration) {
        const double e = std::exp(log_e);
        const mechanics::Voigt<N> total = initial + e * s;
        point.at = mechanics::invariants<N>(total);
        const auto m = layer.law->modulus(layer.parameters, point.at);
        point.gradient = modulus_gradient<N>(m, point.at, total);
        point.modulus = m.value;
        point.gain = 1.0 - point.gradient.dot(s);
        const double mismatch = log_e - std::log(m.value);
        const double slope = 1.0 - e * point.gradient.dot(s) / m.value;
        if (!std::isfinite(mismatch)) {
            return false;
        }
        if (std::abs(mismatch) < 1e-13) {
            return point.gain > 0.0;
        }
        // Where the slope is not positive the stable answer lies the other way: creep instead.
        log_e -= slope > 0.1 ? std::clamp(mismatch / slope, -1.0, 1.0) : std::clamp(mismatch, -0.5, 0.5);
    }
    return std::abs(log_e - std::log(point.modulus)) < 1e-11 && point.gain > 0.0;
}

} // namespace

template <class Element>
Outcome<Solution<Element>>
Solver<Element>::secant(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                        const std::vector<Variation>& variations, const SolverSettings& settings,
                        const std::vector<double>& springs, const std::vector<Motion<Element>>& motions) {
    using Stress = typename Element::Stress;
    using Vector = typename Element::Vector;
    constexpr int dofs = Element::dofs;
    Work& w = *work_;
    w.prepare(layers, variations, settings, springs, motions);
    const int points = w.points();
    const int count = w.count();
    Solution<Element> solution = w.empty_solution();
    Statistics& statistics = solution.statistics;
    const double load_norm = load.norm();

    const auto solve_elastic = [&](const Eigen::VectorXd& modulus, Eigen::VectorXd& u) {
        w.assemble(modulus);
        return w.system.set_matrix(w.values) && w.system.solve(u, {});
    };
    const Failure not_definite{Status::failed, "the stiffness matrix of the section is not positive definite"};

    Eigen::VectorXd modulus(points);
    Eigen::VectorXd u = load;
    if (points == 0) {
        if (!solve_elastic(modulus, u)) {
            return not_definite;
        }
    }

    // A run of the continuation: which load, which smoothing of tension (factor on the laws' own is applied by caller).
    std::vector<LayerMaterial> eased = layers;
    const std::vector<LayerMaterial>* law_layers = &layers;
    std::vector<SecantPoint<Element::voigt>> state(points);

    // Stress state for displacement x: false when a point has no stable answer. unbalanced := factor load - internal.
    const auto balance = [&](const Eigen::VectorXd& x, double factor, const Eigen::VectorXd& guess,
                             Eigen::VectorXd& unbalanced) {
        unbalanced = factor * load;
        for (std::size_t a = 0; a < w.active.size(); ++a) {
            const int e = w.active[a];
            const Vector xe = w.model->gather(e, x.data());
            Vector force = Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                const Stress s = w.unit(e, g) * Element::strain(w.point(e, g), xe);
                if (!solve_point<Element::voigt>((*law_layers)[w.topology->layer[e]], w.initial[q], s, guess[q],
                                                 state[q])) {
                    return false;
                }
                Element::add_force(w.point(e, g), state[q].modulus * s, -w.point(e, g).weight, force);
            }
            w.model->scatter_add(e, force, unbalanced.data());
        }
        w.subtract_linear_force(x, unbalanced);
        return true;
    };

    // The consistent tangent at `state` for displacement x: E C + E s (gradient^T C) / gain at every active point.
    const auto factorize_tangent = [&](const Eigen::VectorXd& x) {
        w.prepare_full();
        w.start_full();
        for (std::size_t a = 0; a < w.active.size(); ++a) {
            const int e = w.active[a];
            const Vector xe = w.model->gather(e, x.data());
            Eigen::Matrix<double, dofs, dofs> k = Eigen::Matrix<double, dofs, dofs>::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const auto& point = state[static_cast<std::size_t>(a) * Element::gauss + g];
                const auto b = Element::strain_operator(w.point(e, g));
                const Stress s = w.unit(e, g) * (b * xe);
                const mechanics::Stiffness<Element::voigt> d =
                    point.modulus * (w.unit(e, g) + s * (point.gradient.transpose() * w.unit(e, g)) / point.gain);
                const typename Element::Operator db = w.point(e, g).weight * (d * b);
                k.noalias() += b.transpose() * db;
            }
            w.add_full(e, k);
        }
        ++statistics.factorizations;
        return w.lu->factorize(w.full_values);
    };
    // The same without forming it: its symmetric part, which also preconditions, and the rest point by point. False
    // where that does not get there, as happens near a fold.
    std::vector<Stress> rest_left(points);
    std::vector<Stress> rest_right(points);
    const auto solve_iteratively = [&](const Eigen::VectorXd& x, double* columns, int number, double tolerance) {
        Eigen::VectorXd now(points);
        for (std::size_t a = 0; a < w.active.size(); ++a) {
            const int e = w.active[a];
            const Vector xe = w.model->gather(e, x.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const std::size_t q = a * Element::gauss + g;
                const auto& point = state[q];
                const Stress s = w.unit(e, g) * Element::strain(w.point(e, g), xe);
                now[static_cast<Eigen::Index>(q)] = point.modulus;
                rest_left[q] = (w.point(e, g).weight * point.modulus / point.gain) * s;
                rest_right[q] = w.unit(e, g) * point.gradient;
            }
        }
        w.assemble(now);
        if (!w.system.set_matrix(w.values)) {
            return false;
        }
        const auto apply = [&](const Eigen::VectorXd& v) {
            Eigen::VectorXd y = w.system.product(v);
            for (std::size_t a = 0; a < w.active.size(); ++a) {
                const int e = w.active[a];
                const Vector ve = w.model->gather(e, v.data());
                Vector force = Vector::Zero();
                for (int g = 0; g < Element::gauss; ++g) {
                    const std::size_t q = a * Element::gauss + g;
                    Element::add_force(w.point(e, g), rest_left[q],
                                       rest_right[q].dot(Element::strain(w.point(e, g), ve)), force);
                }
                w.model->scatter_add(e, force, y.data());
            }
            return y;
        };
        const auto precondition = [&](const Eigen::VectorXd& v) { return w.system.preconditioned(v); };
        constexpr int patience = 60;
        Eigen::Map<Eigen::MatrixXd> all(columns, load.size(), number);
        Eigen::MatrixXd answers(load.size(), number);
        for (int k = 0; k < number; ++k) {
            const Eigen::VectorXd column = all.col(k);
            Eigen::VectorXd found = column;
            int steps = gmres(found, apply, precondition, tolerance, patience);
            if (steps < 0) { // once more with a factor of this very state
                found = column;
                steps = w.system.took_steps(steps) ? gmres(found, apply, precondition, tolerance, patience) : -1;
            }
            if (steps < 0) {
                return false;
            }
            w.system.took_steps(steps);
            answers.col(k) = found;
        }
        all = answers;
        return true;
    };
    // columns := tangent^-1 columns.
    const auto solve_tangent = [&](const Eigen::VectorXd& x, double* columns, int number, double tolerance) {
        if (Element::dim == 3 && solve_iteratively(x, columns, number, tolerance)) {
            return true;
        }
        if (!factorize_tangent(x)) {
            return false;
        }
        w.lu->solve(columns, number);
        return true;
    };

    // Newton at one load. Keeps x and modulus of the last balanced state; false when it gets stuck.
    const auto newton = [&](double factor, Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        Eigen::VectorXd unbalanced;
        if (!balance(x, factor, e_guess, unbalanced)) {
            return false;
        }
        double norm = unbalanced.norm();
        for (int step = 0; step < 25; ++step) {
            for (int q = 0; q < points; ++q) {
                e_guess[q] = state[q].modulus;
            }
            if (norm <= settings.equilibrium_tolerance * factor * load_norm) {
                return true;
            }
            // Near enough for Newton's method to converge quadratically until the last step.
            const double needed = settings.equilibrium_tolerance * factor * load_norm / norm;
            Eigen::VectorXd direction = unbalanced;
            if (!solve_tangent(x, direction.data(), 1, std::clamp(0.3 * needed, 1e-10, 1e-6))) {
                return false;
            }
            ++statistics.newton_steps;
            double length = 1.0;
            Eigen::VectorXd trial;
            for (;; length *= 0.5) {
                if (length < 1.0 / 64.0) {
                    return false;
                }
                trial = x + length * direction;
                if (balance(trial, factor, e_guess, unbalanced) && unbalanced.norm() < (1.0 - 0.1 * length) * norm) {
                    break;
                }
            }
            x = trial;
            norm = unbalanced.norm();
        }
        return false;
    };

    // Starting state at one load: a few damped elastic solutions with moduli from the stress before.
    const auto start = [&](double factor, Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        for (int q = 0; q < points; ++q) {
            const LayerMaterial& layer = (*law_layers)[w.topology->layer[w.active[q / Element::gauss]]];
            e_guess[q] =
                layer.law->modulus(layer.parameters, mechanics::invariants<Element::voigt>(w.initial[q])).value;
        }
        for (int pass = 0; pass < 4; ++pass) {
            x = factor * load;
            if (!solve_elastic(e_guess, x)) {
                return false;
            }
            for (int q = 0; q < points; ++q) {
                const int e = w.active[q / Element::gauss];
                const LayerMaterial& layer = (*law_layers)[w.topology->layer[e]];
                const Stress strain = Element::strain(w.point(e, q % Element::gauss), w.model->gather(e, x.data()));
                const Stress total = w.initial[q] + e_guess[q] * (w.unit(e, q % Element::gauss) * strain);
                const auto m = layer.law->modulus(layer.parameters, mechanics::invariants<Element::voigt>(total));
                e_guess[q] = std::sqrt(e_guess[q] * m.value);
            }
        }
        return true;
    };

    // Load continuation: the full load at once, else in steps halved on failure, from a small load that balances.
    double reached = 0.0;
    const auto follow_load = [&](Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        reached = 0.0;
        if (start(1.0, x, e_guess) && newton(1.0, x, e_guess)) {
            reached = 1.0;
            return true;
        }
        constexpr double smallest = 1.0 / 256.0;
        Eigen::VectorXd good_x = Eigen::VectorXd::Zero(x.size());
        Eigen::VectorXd good_e(points);
        double step = 0.25;
        while (reached < 1.0 && step >= smallest) {
            const double next = std::min(1.0, reached + step);
            bool ok = false;
            if (reached == 0.0) {
                ok = start(next, x, e_guess) && newton(next, x, e_guess);
            } else {
                x = good_x * (next / reached);
                e_guess = good_e;
                ok = newton(next, x, e_guess);
            }
            if (ok) {
                reached = next;
                good_x = x;
                good_e = e_guess;
                step *= 1.5;
            } else {
                step *= 0.5;
            }
        }
        return reached >= 1.0;
    };

    bool found = points == 0 || follow_load(u, modulus);
    const double reached_by_load = reached;
    double reached_by_smoothing = 0.0;
    if (!found) {
        // Delta continuation: a softer floor of theta has an answer more often; lower it to the study's own.
        const auto ease = [&](double factor) {
            for (std::size_t l = 0; l < layers.size(); ++l) {
                if (const auto delta = layers[l].law->index_of("tension_smoothing_kPa")) {
                    eased[l].parameters[*delta] = layers[l].parameters[*delta] * factor;
                }
            }
            law_layers = &eased;
        };
        for (double factor = 4.0; factor <= 64.0 && reached_by_smoothing == 0.0; factor *= 4.0) {
            ease(factor);
            if (follow_load(u, modulus)) {
                reached_by_smoothing = factor;
            }
        }
        double ratio = 0.5;
        Eigen::VectorXd good_u = u;
        Eigen::VectorXd good_e = modulus;
        while (reached_by_smoothing > 1.0 && ratio < 0.98) {
            const double next = std::max(1.0, reached_by_smoothing * ratio);
            ease(next);
            if (newton(1.0, u, modulus)) {
                reached_by_smoothing = next;
                good_u = u;
                good_e = modulus;
            } else {
                u = good_u;
                modulus = good_e;
                ratio = std::sqrt(ratio);
            }
        }
        found = reached_by_smoothing == 1.0;
        law_layers = &layers;
    }
    if (!found) {
        return Failure{Status::no_equilibrium, w.describe_fold(reached_by_load, reached_by_smoothing)};
    }

    Eigen::VectorXd unbalanced;
    if (points > 0) {
        balance(u, 1.0, modulus, unbalanced);
    }
    solution.displacement = u;
    if (count > 0) {
        w.set_load_rates(load, solution.d_displacement);
        w.subtract_linear_rates(u, solution.d_displacement);
    }
    // First the stress rates at held displacement, then what the displacement rates add.
    for (std::size_t a = 0; a < w.active.size(); ++a) {
        const int e = w.active[a];
        const LayerMaterial& layer = w.layer_of(e);
        const Vector ue = w.model->gather(e, u.data());
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = static_cast<int>(a) * Element::gauss + g;
            const int to = e * Element::gauss + g;
            const auto& point = state[q];
            const Stress strain = Element::strain(w.point(e, g), ue);
            const Stress s = w.unit(e, g) * strain;
            solution.stress.col(to) = point.modulus * s;
            solution.modulus[to] = point.modulus;
            const auto here = layer.law->modulus(layer.parameters, point.at);
            for (int k = 0; k < count; ++k) {
                Vector force = Vector::Zero();
                Stress turned = point.modulus * (w.unit_rate(e, g, k) * strain);
                if (const Motion<Element>* motion = w.motion_of(k)) {
                    turned +=
                        w.subtract_motion(*motion, e, g, ue, point.modulus * s, point.modulus * w.unit(e, g), force);
                }
                const double explicit_rate = w.explicit_modulus_rate(layer, w.topology->layer[e], point.at, here, k);
                const double e_rate =
                    (explicit_rate +
                     point.gradient.dot(w.initial_rate[static_cast<std::size_t>(q) * count + k] + turned)) /
                    point.gain;
                const Stress d = turned + e_rate * s;
                solution.d_stress.col(static_cast<Eigen::Index>(to) * count + k) = d;
                Element::add_force(w.point(e, g), d, -w.point(e, g).weight, force);
                w.model->scatter_add(e, force, solution.d_displacement.col(k).data());
            }
        }
    }
    if (count > 0) {
        if (points == 0) {
            if (!w.system.solve(solution.d_displacement, {})) {
                return not_definite;
            }
        } else if (!solve_tangent(u, solution.d_displacement.data(), count, settings.linear_tolerance)) {
            return Failure{Status::no_equilibrium, "the equilibrium found is a fold: its tangent is singular"};
        }
        for (std::size_t a = 0; a < w.active.size(); ++a) {
            const int e = w.active[a];
            const Vector ue = w.model->gather(e, u.data());
            for (int k = 0; k < count; ++k) {
                const Vector de = w.model->gather(e, solution.d_displacement.col(k).data());
                for (int g = 0; g < Element::gauss; ++g) {
                    const auto& point = state[static_cast<std::size_t>(a) * Element::gauss + g];
                    const Stress s = w.unit(e, g) * Element::strain(w.point(e, g), ue);
                    const Stress ds = point.modulus * (w.unit(e, g) * Element::strain(w.point(e, g), de));
                    solution.d_stress.col(static_cast<Eigen::Index>(e * Element::gauss + g) * count + k) +=
                        ds + s * (point.gradient.dot(ds) / point.gain);
                }
            }
        }
    }
    statistics.load_steps = 1;
    statistics.factorizations += w.system.factorizations();
    statistics.iterations += w.system.iterations();
    w.finish(load, solution);
    return solution;
}

using Layers = std::vector<LayerMaterial>;
using Variations = std::vector<Variation>;
template Outcome<Solution<AxisymmetricQ8>> Solver<AxisymmetricQ8>::secant(const Layers&, const Eigen::VectorXd&,
                                                                          const Variations&, const SolverSettings&,
                                                                          const std::vector<double>&,
                                                                          const std::vector<Motion<AxisymmetricQ8>>&);
template Outcome<Solution<Hex20>> Solver<Hex20>::secant(const Layers&, const Eigen::VectorXd&, const Variations&,
                                                        const SolverSettings&, const std::vector<double>&,
                                                        const std::vector<Motion<Hex20>>&);

} // namespace pave::fe

#include "fe/full_matrix.h"
#include "fe/gmres.h"
#include "fe/solver_work.h"

#include <Eigen/Cholesky>
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

std::string describe_fold(double reached_by_load, double reached_by_smoothing) {
    std::string text = "the secant law has no equilibrium: raising the load ended in a fold at " +
                       std::to_string(static_cast<int>(100.0 * reached_by_load)) + " % of it; ";
    if (reached_by_smoothing > 1.0) {
        text += "lowering the tension smoothing ended in a fold at " +
                std::to_string(reached_by_smoothing).substr(0, 4) + " times the study's value";
    } else {
        text += "no larger tension smoothing (up to 64 times) has one either";
    }
    return text + ". Where base stiffness grows as fast as stress, strain cannot balance the load";
}

// One run on the shared work, which is prepared for it.
template <class Element, class Work>
class Secant {
public:
    Secant(Work& work, const Eigen::VectorXd& load, const SolverSettings& settings)
        : w_(work),
          load_(load),
          settings_(settings),
          points_(work.points()),
          layers_(work.layers),
          state_(static_cast<std::size_t>(points_)),
          rest_left_(static_cast<std::size_t>(points_)),
          rest_right_(static_cast<std::size_t>(points_)) {}

    Outcome<Solution<Element>> solve() {
        Solution<Element> solution = w_.empty_solution();
        const Failure not_definite{Status::failed, "the stiffness matrix of the section is not positive definite"};
        Eigen::VectorXd modulus(points_);
        Eigen::VectorXd u = load_;
        if (points_ == 0) {
            if (!solve_elastic(modulus, u)) {
                return not_definite;
            }
        } else if (!follow_load(u, modulus)) {
            const double reached_by_load = reached_;
            const double reached_by_smoothing = follow_smoothing(u, modulus);
            if (reached_by_smoothing != 1.0) {
                return Failure{Status::no_equilibrium, describe_fold(reached_by_load, reached_by_smoothing)};
            }
        }
        if (points_ > 0) {
            Eigen::VectorXd unbalanced;
            balance(u, 1.0, modulus, unbalanced);
            statistics_.indefinite_share = indefinite_share(u);
        }
        solution.displacement = u;
        if (w_.count() > 0) {
            w_.set_load_rates(load_, solution.d_displacement);
            w_.subtract_linear_rates(u, solution.d_displacement);
        }
        set_stress_at_held_displacement(solution);
        if (w_.count() > 0) {
            if (points_ == 0) {
                if (!w_.system.solve(solution.d_displacement, {})) {
                    return not_definite;
                }
            } else if (!solve_tangent(u, solution.d_displacement.data(), w_.count(), settings_.linear_tolerance)) {
                return Failure{Status::no_equilibrium, "the equilibrium found is a fold: its tangent is singular"};
            }
            add_stress_rates(solution);
        }
        statistics_.load_steps = 1;
        statistics_.factorizations += w_.system.factorizations();
        statistics_.iterations += w_.system.iterations();
        solution.statistics = statistics_;
        w_.finish(load_, solution);
        return solution;
    }

private:
    using Stress = typename Element::Stress;
    using Vector = typename Element::Vector;

    bool solve_elastic(const Eigen::VectorXd& modulus, Eigen::VectorXd& u) {
        w_.assemble(modulus);
        return w_.system.set_matrix(w_.values) && w_.system.solve(u, {});
    }

    // Stress state for displacement x: false when a point has no stable answer. unbalanced := factor load - internal.
    bool balance(const Eigen::VectorXd& x, double factor, const Eigen::VectorXd& guess, Eigen::VectorXd& unbalanced) {
        unbalanced = factor * load_;
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const Vector xe = w_.model->gather(e, x.data());
            Vector force = Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                const Stress s = w_.unit(e, g) * Element::strain(w_.point(e, g), xe);
                if (!solve_point<Element::voigt>((*layers_)[w_.topology->layer[e]], w_.initial[q], s, guess[q],
                                                 state_[q])) {
                    return false;
                }
                Element::add_force(w_.point(e, g), state_[q].modulus * s, -w_.point(e, g).weight, force);
            }
            w_.model->scatter_add(e, force, unbalanced.data());
        }
        w_.subtract_linear_force(x, unbalanced);
        return true;
    }

    // E C + E s (gradient^T C) / gain, s = C strain.
    mechanics::Stiffness<Element::voigt> tangent_at(int e, int g, const SecantPoint<Element::voigt>& point,
                                                    const Vector& xe) const {
        const Stress s = w_.unit(e, g) * Element::strain(w_.point(e, g), xe);
        return point.modulus * (w_.unit(e, g) + s * (point.gradient.transpose() * w_.unit(e, g)) / point.gain);
    }

    // Where the symmetric part of the tangent is positive definite everywhere there is one equilibrium nearby (Hill
    // 1958, doi 10.1016/0022-5096(58)90029-2). The share, weighted by the energy of the load stress, where it is not.
    double indefinite_share(const Eigen::VectorXd& x) const {
        constexpr double by = 0.1; // of the modulus
        double share = 0.0;
        double energy = 0.0;
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const Vector xe = w_.model->gather(e, x.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const auto& point = state_[static_cast<std::size_t>(a) * Element::gauss + g];
                const mechanics::Stiffness<Element::voigt> d = tangent_at(e, g, point, xe);
                const Stress strain = Element::strain(w_.point(e, g), xe);
                const double w = w_.point(e, g).weight * point.modulus * strain.dot(w_.unit(e, g) * strain);
                mechanics::Stiffness<Element::voigt> raised = 0.5 * (d + d.transpose());
                raised.diagonal().array() += by * point.modulus;
                energy += w;
                share += raised.llt().info() == Eigen::Success ? 0.0 : w;
            }
        }
        return energy > 0.0 ? share / energy : 0.0;
    }

    // The consistent tangent at the state for displacement x, at every active point.
    bool factorize_tangent(const Eigen::VectorXd& x) {
        if (w_.full == nullptr) {
            w_.full = std::make_unique<FullMatrix<Element>>(*w_.topology);
        }
        w_.full->set(w_.linear);
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const Vector xe = w_.model->gather(e, x.data());
            ElementMatrix<Element> k = ElementMatrix<Element>::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const auto& point = state_[static_cast<std::size_t>(a) * Element::gauss + g];
                const mechanics::Stiffness<Element::voigt> d = tangent_at(e, g, point, xe);
                k += point_matrix<Element>(w_.point(e, g), d, w_.point(e, g), w_.point(e, g).weight);
            }
            w_.full->add(e, k);
        }
        ++statistics_.factorizations;
        return w_.full->factorize();
    }

    // The same without forming it: its symmetric part, which also preconditions, and the rest point by point. False
    // where that does not get there, as happens near a fold.
    bool solve_iteratively(const Eigen::VectorXd& x, double* columns, int number, double tolerance) {
        Eigen::VectorXd now(points_);
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const Vector xe = w_.model->gather(e, x.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const std::size_t q = a * Element::gauss + g;
                const auto& point = state_[q];
                const Stress s = w_.unit(e, g) * Element::strain(w_.point(e, g), xe);
                now[static_cast<Eigen::Index>(q)] = point.modulus;
                rest_left_[q] = (w_.point(e, g).weight * point.modulus / point.gain) * s;
                rest_right_[q] = w_.unit(e, g) * point.gradient;
            }
        }
        w_.assemble(now);
        if (!w_.system.set_matrix(w_.values)) {
            return false;
        }
        const auto apply = [&](const Eigen::VectorXd& v) {
            Eigen::VectorXd y = w_.system.product(v);
            for (std::size_t a = 0; a < w_.active.size(); ++a) {
                const int e = w_.active[a];
                const Vector ve = w_.model->gather(e, v.data());
                Vector force = Vector::Zero();
                for (int g = 0; g < Element::gauss; ++g) {
                    const std::size_t q = a * Element::gauss + g;
                    Element::add_force(w_.point(e, g), rest_left_[q],
                                       rest_right_[q].dot(Element::strain(w_.point(e, g), ve)), force);
                }
                w_.model->scatter_add(e, force, y.data());
            }
            return y;
        };
        const auto precondition = [&](const Eigen::VectorXd& v) { return w_.system.preconditioned(v); };
        constexpr int patience = 60;
        Eigen::Map<Eigen::MatrixXd> all(columns, load_.size(), number);
        Eigen::MatrixXd answers(load_.size(), number);
        for (int k = 0; k < number; ++k) {
            const Eigen::VectorXd column = all.col(k);
            Eigen::VectorXd found = column;
            int steps = gmres(found, apply, precondition, tolerance, patience);
            if (steps < 0) { // once more with a factor of this very state
                found = column;
                steps = w_.system.took_steps(steps) ? gmres(found, apply, precondition, tolerance, patience) : -1;
            }
            if (steps < 0) {
                return false;
            }
            w_.system.took_steps(steps);
            answers.col(k) = found;
        }
        all = answers;
        return true;
    }

    // columns := tangent^-1 columns.
    bool solve_tangent(const Eigen::VectorXd& x, double* columns, int number, double tolerance) {
        if (Element::dim == 3 && solve_iteratively(x, columns, number, tolerance)) {
            return true;
        }
        if (!factorize_tangent(x)) {
            return false;
        }
        w_.full->solve(columns, number);
        return true;
    }

    // Newton at one load. Keeps x and modulus of the last balanced state; false when it gets stuck.
    bool newton(double factor, Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        Eigen::VectorXd unbalanced;
        if (!balance(x, factor, e_guess, unbalanced)) {
            return false;
        }
        double norm = unbalanced.norm();
        for (int step = 0; step < 25; ++step) {
            for (int q = 0; q < points_; ++q) {
                e_guess[q] = state_[q].modulus;
            }
            if (norm <= settings_.equilibrium_tolerance * factor * load_.norm()) {
                return true;
            }
            // Near enough for Newton's method to converge quadratically until the last step.
            const double needed = settings_.equilibrium_tolerance * factor * load_.norm() / norm;
            Eigen::VectorXd direction = unbalanced;
            if (!solve_tangent(x, direction.data(), 1, std::clamp(0.3 * needed, 1e-10, 1e-6))) {
                return false;
            }
            ++statistics_.newton_steps;
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
    }

    // Starting state at one load: a few damped elastic solutions with moduli from the stress before.
    bool start(double factor, Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        for (int q = 0; q < points_; ++q) {
            const LayerMaterial& layer = (*layers_)[w_.topology->layer[w_.active[q / Element::gauss]]];
            e_guess[q] =
                layer.law->modulus(layer.parameters, mechanics::invariants<Element::voigt>(w_.initial[q])).value;
        }
        for (int pass = 0; pass < 4; ++pass) {
            x = factor * load_;
            if (!solve_elastic(e_guess, x)) {
                return false;
            }
            for (int q = 0; q < points_; ++q) {
                const int e = w_.active[q / Element::gauss];
                const LayerMaterial& layer = (*layers_)[w_.topology->layer[e]];
                const Stress strain = Element::strain(w_.point(e, q % Element::gauss), w_.model->gather(e, x.data()));
                const Stress total = w_.initial[q] + e_guess[q] * (w_.unit(e, q % Element::gauss) * strain);
                const auto m = layer.law->modulus(layer.parameters, mechanics::invariants<Element::voigt>(total));
                e_guess[q] = std::sqrt(e_guess[q] * m.value);
            }
        }
        return true;
    }

    // Load continuation: the full load at once, else in steps halved on failure, from a small load that balances.
    bool follow_load(Eigen::VectorXd& x, Eigen::VectorXd& e_guess) {
        reached_ = 0.0;
        if (start(1.0, x, e_guess) && newton(1.0, x, e_guess)) {
            reached_ = 1.0;
            return true;
        }
        constexpr double smallest = 1.0 / 256.0;
        Eigen::VectorXd good_x = Eigen::VectorXd::Zero(x.size());
        Eigen::VectorXd good_e(points_);
        double step = 0.25;
        while (reached_ < 1.0 && step >= smallest) {
            const double next = std::min(1.0, reached_ + step);
            bool ok = false;
            if (reached_ == 0.0) {
                ok = start(next, x, e_guess) && newton(next, x, e_guess);
            } else {
                x = good_x * (next / reached_);
                e_guess = good_e;
                ok = newton(next, x, e_guess);
            }
            if (ok) {
                reached_ = next;
                good_x = x;
                good_e = e_guess;
                step *= 1.5;
            } else {
                step *= 0.5;
            }
        }
        return reached_ >= 1.0;
    }

    // Delta continuation: a softer floor of theta has an answer more often; lower it to the study's own. Returns by
    // which factor on that it ended in a fold; 1: an answer, 0: not even the largest has one.
    double follow_smoothing(Eigen::VectorXd& u, Eigen::VectorXd& modulus) {
        double reached = 0.0;
        for (double factor = 4.0; factor <= 64.0 && reached == 0.0; factor *= 4.0) {
            ease(factor);
            if (follow_load(u, modulus)) {
                reached = factor;
            }
        }
        double ratio = 0.5;
        Eigen::VectorXd good_u = u;
        Eigen::VectorXd good_e = modulus;
        while (reached > 1.0 && ratio < 0.98) {
            const double next = std::max(1.0, reached * ratio);
            ease(next);
            if (newton(1.0, u, modulus)) {
                reached = next;
                good_u = u;
                good_e = modulus;
            } else {
                u = good_u;
                modulus = good_e;
                ratio = std::sqrt(ratio);
            }
        }
        layers_ = w_.layers;
        return reached;
    }
    void ease(double factor) {
        eased_ = *w_.layers;
        for (LayerMaterial& layer : eased_) {
            if (const auto delta = layer.law->index_of("tension_smoothing_kPa")) {
                layer.parameters[*delta] *= factor;
            }
        }
        layers_ = &eased_;
    }

    // Stress and its rates at held displacement; d_displacement(:, k) -= the force of those.
    void set_stress_at_held_displacement(Solution<Element>& solution) const {
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const LayerMaterial& layer = w_.layer_of(e);
            const Vector ue = w_.model->gather(e, solution.displacement.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                const int to = e * Element::gauss + g;
                const auto& point = state_[q];
                const Stress strain = Element::strain(w_.point(e, g), ue);
                const Stress s = w_.unit(e, g) * strain;
                solution.stress.col(to) = point.modulus * s;
                solution.modulus[to] = point.modulus;
                const auto here = layer.law->modulus(layer.parameters, point.at);
                for (int k = 0; k < w_.count(); ++k) {
                    Vector force = Vector::Zero();
                    Stress turned = point.modulus * (w_.unit_rate(e, g, k) * strain);
                    if (const Motion<Element>* motion = w_.motion_of(k)) {
                        turned += w_.subtract_motion(*motion, e, g, ue, point.modulus * s,
                                                     point.modulus * w_.unit(e, g), force);
                    }
                    const double explicit_rate =
                        w_.explicit_modulus_rate(layer, w_.topology->layer[e], point.at, here, k);
                    const double e_rate =
                        (explicit_rate +
                         point.gradient.dot(w_.initial_rate[static_cast<std::size_t>(q) * w_.count() + k] + turned)) /
                        point.gain;
                    const Stress d = turned + e_rate * s;
                    solution.d_stress.col(static_cast<Eigen::Index>(to) * w_.count() + k) = d;
                    Element::add_force(w_.point(e, g), d, -w_.point(e, g).weight, force);
                    w_.model->scatter_add(e, force, solution.d_displacement.col(k).data());
                }
            }
        }
    }

    // Adds the rates of the displacement.
    void add_stress_rates(Solution<Element>& solution) const {
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            const int e = w_.active[a];
            const Vector ue = w_.model->gather(e, solution.displacement.data());
            for (int k = 0; k < w_.count(); ++k) {
                const Vector de = w_.model->gather(e, solution.d_displacement.col(k).data());
                for (int g = 0; g < Element::gauss; ++g) {
                    const auto& point = state_[static_cast<std::size_t>(a) * Element::gauss + g];
                    const Stress s = w_.unit(e, g) * Element::strain(w_.point(e, g), ue);
                    const Stress ds = point.modulus * (w_.unit(e, g) * Element::strain(w_.point(e, g), de));
                    solution.d_stress.col(static_cast<Eigen::Index>(e * Element::gauss + g) * w_.count() + k) +=
                        ds + s * (point.gradient.dot(ds) / point.gain);
                }
            }
        }
    }

    Work& w_;
    const Eigen::VectorXd& load_;
    const SolverSettings& settings_;
    const int points_;
    std::vector<LayerMaterial> eased_;
    const std::vector<LayerMaterial>* layers_; // the study's own, or eased
    std::vector<SecantPoint<Element::voigt>> state_;
    std::vector<Stress> rest_left_, rest_right_; // of the tangent, beyond its symmetric part
    Statistics statistics_;
    double reached_ = 0.0; // of the load
};

} // namespace

template <class Element>
Outcome<Solution<Element>>
Solver<Element>::secant(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                        const std::vector<Variation>& variations, const SolverSettings& settings,
                        const std::vector<double>& springs, const std::vector<Motion<Element>>& motions) {
    work_->prepare(layers, variations, settings, springs, motions);
    return Secant<Element, Work>(*work_, load, settings).solve();
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

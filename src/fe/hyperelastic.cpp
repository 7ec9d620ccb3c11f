#include "fe/solver_work.h"

#include <cmath>

namespace pave::fe {
namespace {

// A section of layers that are linear or have an energy, at a displacement.
template <class Element, class Work>
class Equilibrium {
public:
    static constexpr int lower_entries = Topology<Element>::lower_entries;
    using Stress = typename Element::Stress;
    using Vector = typename Element::Vector;
    using Stresses = Eigen::Matrix<double, Element::voigt, Eigen::Dynamic>;

    Equilibrium(Work& w, const Eigen::VectorXd& load) : w_(w), load_(load) {
        whole.resize(Eigen::NoChange, w.points());
        states.resize(static_cast<std::size_t>(w.points()));
        for (int q = 0; q < w.points(); ++q) {
            whole.col(q) = w.initial[static_cast<std::size_t>(q)];
            set_state(q);
        }
    }

    // The stress of a displacement; unbalanced := load - internal forces; energy := that of section and load. False: a
    // stress is no finite number.
    bool set(const Eigen::VectorXd& u) {
        unbalanced = Eigen::VectorXd::Zero(load_.size());
        w_.subtract_linear_force(u, unbalanced);
        energy = -0.5 * u.dot(unbalanced) - u.dot(load_);
        unbalanced += load_;
        each_element([&](int e, int first) {
            const Vector ue = w_.model->gather(e, u.data());
            Vector force = Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = first + g;
                const auto& at = w_.point(e, g);
                const Stress strain = Element::strain(at, ue);
                const auto answer = w_.energies.answer(q, strain);
                whole.col(q) = answer.whole;
                states[static_cast<std::size_t>(q)] = answer.state;
                const Stress& initial = w_.initial[static_cast<std::size_t>(q)];
                energy += at.weight * (w_.energies.at(q)->stored(answer.state) - initial.dot(strain));
                Element::add_force(at, answer.whole - initial, -at.weight, force);
            }
            w_.model->scatter_add(e, force, unbalanced.data());
        });
        return std::isfinite(energy) && unbalanced.allFinite();
    }

    // The tangent at the stresses at hand to the system. False: it is not definite.
    bool set_tangent() {
        w_.values = w_.linear;
        Eigen::Matrix<double, lower_entries, 1> k;
        each_element([&](int e, int first) {
            Eigen::Matrix<double, Element::gauss, 1> moduli;
            for (int g = 0; g < Element::gauss; ++g) {
                moduli[g] = states[static_cast<std::size_t>(first + g)].secant.value; // factors of fields are in C
            }
            k.noalias() = w_.unit_stiffness.template middleCols<Element::gauss>(first) * moduli;
            for (int g = 0; g < Element::gauss; ++g) {
                const auto& state = states[static_cast<std::size_t>(first + g)];
                Vector force = Vector::Zero();
                Element::add_force(w_.point(e, g), whole.col(first + g), 1.0, force);
                const double along = w_.point(e, g).weight * state.modulus * state.along;
                for (int i = 0, entry = 0; i < Element::dofs; ++i) {
                    const double row = along * force[i];
                    for (int j = 0; j <= i; ++j, ++entry) {
                        k[entry] += row * force[j];
                    }
                }
            }
            const auto& scatter = w_.topology->scatter[static_cast<std::size_t>(e)];
            for (int entry = 0; entry < lower_entries; ++entry) {
                if (scatter[entry] >= 0) {
                    w_.values[static_cast<std::size_t>(scatter[entry])] += k[entry];
                }
            }
        });
        return w_.system.set_matrix(w_.values);
    }

    // A step towards the equilibrium from stresses that need belong to no displacement: tangents at them turn what is
    // out of balance into a displacement u, and what they lack of its strain into stress. Where statics fix the stress,
    // it is found in one such step.
    bool step_in_stress(Eigen::VectorXd& u) {
        u = load_;
        each_element([&](int e, int first) {
            Vector force = Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = first + g;
                const Stress held = whole.col(q) - w_.initial[static_cast<std::size_t>(q)] -
                                    times_tangent(q, w_.energies.strain_of_load(q, whole.col(q)));
                Element::add_force(w_.point(e, g), held, -w_.point(e, g).weight, force);
            }
            w_.model->scatter_add(e, force, u.data());
        });
        if (!set_tangent() || !w_.system.solve(u, {})) {
            return false;
        }
        each_element([&](int e, int first) {
            const Vector ue = w_.model->gather(e, u.data());
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = first + g;
                const Stress lacking =
                    Element::strain(w_.point(e, g), ue) - w_.energies.strain_of_load(q, whole.col(q));
                whole.col(q) += times_tangent(q, lacking);
                set_state(q);
            }
        });
        return u.allFinite() && whole.allFinite();
    }

    Stress times_tangent(int q, const Stress& strain) const {
        return w_.energies.at(q)->times_tangent(states[static_cast<std::size_t>(q)], whole.col(q), strain);
    }

    // f(element, number of its first point) for the active elements.
    template <class F>
    void each_element(F f) const {
        for (std::size_t a = 0; a < w_.active.size(); ++a) {
            f(w_.active[a], static_cast<int>(a) * Element::gauss);
        }
    }

    Stresses whole; // stress, of the points of the active elements
    std::vector<typename EnergyMaterial<Element::voigt>::State> states;
    Eigen::VectorXd unbalanced;
    double energy = 0.0; // J

private:
    void set_state(int q) { states[static_cast<std::size_t>(q)] = w_.energies.at(q)->at(whole.col(q)); }

    Work& w_;
    const Eigen::VectorXd& load_;
};

} // namespace

template <class Element>
Outcome<Solution<Element>>
Solver<Element>::hyperelastic(const std::vector<LayerMaterial>& layers, const Eigen::VectorXd& load,
                              const std::vector<Variation>& variations, const SolverSettings& settings,
                              const std::vector<double>& springs, const std::vector<Motion<Element>>& motions) {
    using Stress = typename Element::Stress;
    using Vector = typename Element::Vector;
    Work& w = *work_;
    SolverSettings exact = settings; // Newton's steps are worth what their systems are solved to
    exact.linear_tolerance = std::min(settings.linear_tolerance, 1e-6);
    w.prepare(layers, variations, exact, springs, motions, true);
    const int count = w.count();
    Solution<Element> solution = w.empty_solution();
    Statistics& statistics = solution.statistics;
    const Deadline deadline(settings.time_limit);
    const Failure not_definite = stiffness_not_definite();

    Equilibrium<Element, Work> section(w, load);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(load.size());
    constexpr int steps_in_stress = 2;
    for (int i = 0; i < steps_in_stress; ++i) {
        ++statistics.newton_steps;
        if (!section.step_in_stress(u)) {
            u.setZero();
            break;
        }
    }
    if (!section.set(u)) {
        u.setZero();
        section.set(u);
    }

    constexpr int most_steps = 100;
    const double wanted = settings.equilibrium_tolerance * load.norm();
    for (int step = 0; !(section.unbalanced.norm() <= wanted); ++step) {
        if (deadline.has_passed()) {
            return Deadline::failure();
        }
        if (step == most_steps) {
            return Failure{Status::failed, "the equilibrium of the hyperelastic layers was not found"};
        }
        Eigen::VectorXd direction = section.unbalanced;
        if (!section.set_tangent() || !w.system.solve(direction, {})) {
            return not_definite;
        }
        ++statistics.newton_steps;
        // Along the direction the energy is convex: where it still falls it lies below where it came from. Else it must
        // have fallen by its share, or by all that rounding tells.
        const double start_energy = section.energy;
        const double start_slope = -section.unbalanced.dot(direction);
        const double rounding = 1e-12 * std::abs(u.dot(load));
        double length = 1.0;
        for (int tries = 0; tries < 60; ++tries) {
            if (!section.set(u + length * direction)) {
                length *= 0.1;
                continue;
            }
            const double slope = -section.unbalanced.dot(direction);
            const bool falls = slope <= 0.0;
            const bool has_fallen = section.energy <= start_energy + 1e-4 * length * start_slope;
            const bool is_flat = slope <= -0.5 * start_slope && section.energy <= start_energy + rounding;
            if (falls || has_fallen || is_flat) {
                break;
            }
            length *= std::clamp(start_slope / (start_slope - slope), 0.1, 0.7);
        }
        u += length * direction;
    }

    solution.displacement = u;
    Eigen::MatrixXd& du = solution.d_displacement;
    if (count > 0) {
        w.set_load_rates(load, du);
        w.subtract_linear_rates(u, du);
    }
    // First the stress rates at held displacement, then what its rates add.
    const auto column = [&](int e, int g, int k) {
        return solution.d_stress.col(static_cast<Eigen::Index>(e * Element::gauss + g) * count + k);
    };
    section.each_element([&](int e, int first) {
        const Vector ue = w.model->gather(e, u.data());
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = first + g;
            const auto& state = section.states[static_cast<std::size_t>(q)];
            const Stress whole = section.whole.col(q);
            const Stress stress = whole - w.initial[static_cast<std::size_t>(q)];
            solution.stress.col(e * Element::gauss + g) = stress;
            solution.modulus[e * Element::gauss + g] = state.modulus;
            for (int k = 0; k < count; ++k) {
                Vector force = Vector::Zero();
                Stress strain_rate = Stress::Zero();
                if (const Motion<Element>* motion = w.motion_of(k)) {
                    w.subtract_motion(*motion, e, g, ue, stress, mechanics::Stiffness<Element::voigt>::Zero(), force);
                    strain_rate = Element::strain(motion->points[static_cast<std::size_t>(e * Element::gauss + g)], ue);
                }
                const Stress rate = w.energies.whole_rate(q, {whole, state}, strain_rate, k) -
                                    w.initial_rate[static_cast<std::size_t>(q) * count + k];
                column(e, g, k) = rate;
                Element::add_force(w.point(e, g), rate, -w.point(e, g).weight, force);
                w.model->scatter_add(e, force, du.col(k).data());
            }
        }
    });
    if (count > 0) {
        if (!section.set_tangent() || !w.system.solve(du, {})) {
            return not_definite;
        }
        section.each_element([&](int e, int first) {
            for (int k = 0; k < count; ++k) {
                const Vector de = w.model->gather(e, du.col(k).data());
                for (int g = 0; g < Element::gauss; ++g) {
                    column(e, g, k) += section.times_tangent(first + g, Element::strain(w.point(e, g), de));
                }
            }
        });
    }
    statistics.load_steps = 1;
    statistics.factorizations = w.system.factorizations();
    statistics.iterations = w.system.iterations();
    w.finish(load, solution);
    return solution;
}

using Layers = std::vector<LayerMaterial>;
using Variations = std::vector<Variation>;
template Outcome<Solution<AxisymmetricQ8>>
Solver<AxisymmetricQ8>::hyperelastic(const Layers&, const Eigen::VectorXd&, const Variations&, const SolverSettings&,
                                     const std::vector<double>&, const std::vector<Motion<AxisymmetricQ8>>&);
template Outcome<Solution<Hex20>> Solver<Hex20>::hyperelastic(const Layers&, const Eigen::VectorXd&, const Variations&,
                                                              const SolverSettings&, const std::vector<double>&,
                                                              const std::vector<Motion<Hex20>>&);

} // namespace pave::fe

// Results of a run: stresses, readings, statistics.
#include "fe/solver_work.h"

namespace pave::fe {

template <class Element>
void Solver<Element>::Work::finish(const Eigen::VectorXd& load, const Felt& felt, Solution<Element>& solution) const {
    const int n = count();
    Statistics& s = solution.statistics;
    Eigen::VectorXd unbalanced = load;
    double energy = 0.0;
    for (int e = 0; e < model->elements(); ++e) {
        const PreparedLayer<N>& p = prepared_of(e);
        const LayerMaterial& layer = layer_of(e);
        const auto own = static_cast<std::size_t>(topology->layer[e]);
        const Vector ue = model->gather(e, felt.u[own]->data());
        Vector force = Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = e * Element::gauss + g;
            if (!p.stress_dependent) {
                const Stress strain = Element::strain(point(e, g), ue);
                solution.modulus[q] = p.modulus;
                solution.stress.col(q) = p.modulus * (unit(e, g) * strain);
                for (int k = 0; k < n; ++k) {
                    const Vector de = model->gather(e, felt.du[own]->col(k).data());
                    solution.d_stress.col(static_cast<Eigen::Index>(q) * n + k) =
                        p.modulus * (unit(e, g) * Element::strain(point(e, g), de)) +
                        linear_stiffness_rate(e, g, k) * strain;
                    if (const Motion<Element>* motion = motion_of(k)) {
                        solution.d_stress.col(static_cast<Eigen::Index>(q) * n + k) +=
                            p.modulus * (unit(e, g) * Element::strain(motion->points[q], ue));
                    }
                }
            } else {
                const Stress load_stress = solution.stress.col(q);
                const Stress total = layer.template initial_stress<N>(model->depth[q]) + load_stress;
                const auto at = mechanics::invariants<N>(total);
                const material::Modulus of_energy{.value = solution.modulus[q],
                                                  .limited = solution.modulus[q] >= material::modulus_limit};
                const auto m = layer.law->energy() ? of_energy : layer.law->modulus(layer.parameters, at);
                const double w = point(e, g).weight * load_stress.dot(compliance(e, g) * load_stress) / m.value;
                energy += w;
                s.tension_share += at.theta < 0.0 ? w : 0.0;
                s.unstable_share += at.theta * m.d_theta + at.tau * m.d_tau >= m.value ? w : 0.0;
                s.limited_share += m.limited ? w : 0.0;
            }
            Element::add_force(point(e, g), solution.stress.col(q), -point(e, g).weight, force);
        }
        model->scatter_add(e, force, unbalanced.data());
    }
    for (std::size_t i = 0; i < springs->size(); ++i) {
        model->springs[i].add_product(solution.displacement.data(), -(*springs)[i], unbalanced.data());
    }
    if (energy > 0.0) {
        s.tension_share /= energy;
        s.unstable_share /= energy;
        s.limited_share /= energy;
    }
    s.residual_relative = unbalanced.norm() / load.norm();
}

template <class Element>
Solution<Element> Solver<Element>::Work::empty_solution() const {
    Solution<Element> s;
    const int total = model->elements() * Element::gauss;
    s.displacement = Eigen::VectorXd::Zero(model->free_unknowns());
    s.stress.resize(Eigen::NoChange, total);
    s.modulus.resize(total);
    s.d_displacement = Eigen::MatrixXd::Zero(model->free_unknowns(), count());
    s.d_stress.resize(Eigen::NoChange, static_cast<Eigen::Index>(total) * count());
    return s;
}

template <class Element>
void Solver<Element>::Work::store(const Stresses& stress, const Stresses& d_stress, Solution<Element>& solution) const {
    for (std::size_t a = 0; a < active.size(); ++a) {
        for (int g = 0; g < Element::gauss; ++g) {
            const int from = static_cast<int>(a) * Element::gauss + g;
            const int to = active[a] * Element::gauss + g;
            solution.stress.col(to) = stress.col(from);
            solution.modulus[to] = modulus[from];
            for (int k = 0; k < count(); ++k) {
                solution.d_stress.col(static_cast<Eigen::Index>(to) * count() + k) =
                    d_stress.col(static_cast<Eigen::Index>(from) * count() + k);
            }
        }
    }
}

template <class Element>
void Solver<Element>::Work::read_all(const std::vector<Functional<Element>>& readings, const PathState<Element>& now,
                                     const Felt& by, std::size_t instant, Course& course) const {
    for (std::size_t r = 0; r < readings.size(); ++r) {
        const auto row = static_cast<Eigen::Index>(r);
        read(readings[r], now, by, course.values(row, static_cast<Eigen::Index>(instant)),
             course.d_values[instant].row(row));
    }
}

template <class Element>
Solution<Element> Solver<Element>::Work::solution_at(const PathState<Element>& now, const Felt& by,
                                                     const Eigen::VectorXd& load) {
    Solution<Element> solution = empty_solution();
    solution.displacement = now.u;
    solution.d_displacement = now.du;
    set_moduli(now.stress, now.d_stress);
    store(now.stress, now.d_stress, solution);
    finish(load, by, solution);
    return solution;
}

template <class Element>
void Solver<Element>::Work::read(const Functional<Element>& f, const PathState<Element>& now, const Felt& by,
                                 double& value, Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> rates) const {
    value = f.of_displacement(now.u.data());
    for (int k = 0; k < count(); ++k) {
        rates[k] = f.of_displacement(now.du.col(k).data());
    }
    for (const auto& [point_number, weight, direction] : f.on_stress) {
        const int e = point_number / Element::gauss;
        const int g = point_number % Element::gauss;
        const auto& p = prepared_of(e);
        if (p.stress_dependent) {
            const Eigen::Index q =
                static_cast<Eigen::Index>(active_number[static_cast<std::size_t>(e)]) * Element::gauss + g;
            value += weight * direction.dot(now.stress.col(q));
            for (int k = 0; k < count(); ++k) {
                rates[k] += weight * direction.dot(now.d_stress.col(q * count() + k));
            }
            continue;
        }
        const auto layer = static_cast<std::size_t>(topology->layer[e]);
        const Stress strain = Element::strain(point(e, g), model->gather(e, by.u[layer]->data()));
        value += weight * p.modulus * direction.dot(unit(e, g) * strain);
        for (int k = 0; k < count(); ++k) {
            const Stress rate = Element::strain(point(e, g), model->gather(e, by.du[layer]->col(k).data()));
            rates[k] +=
                weight * direction.dot(p.modulus * (unit(e, g) * rate) + linear_stiffness_rate(e, g, k) * strain);
            if (const Motion<Element>* motion = motion_of(k)) {
                const Stress turned = Element::strain(motion->points[static_cast<std::size_t>(point_number)],
                                                      model->gather(e, by.u[layer]->data()));
                rates[k] += weight * p.modulus * direction.dot(unit(e, g) * turned);
            }
        }
    }
}

template void Solver<AxisymmetricQ8>::Work::finish(const Eigen::VectorXd&, const Felt&,
                                                   Solution<AxisymmetricQ8>&) const;
template Solution<AxisymmetricQ8> Solver<AxisymmetricQ8>::Work::empty_solution() const;
template void Solver<AxisymmetricQ8>::Work::store(const Stresses&, const Stresses&, Solution<AxisymmetricQ8>&) const;
template void Solver<AxisymmetricQ8>::Work::read_all(const std::vector<Functional<AxisymmetricQ8>>&,
                                                     const PathState<AxisymmetricQ8>&, const Felt&, std::size_t,
                                                     Course&) const;
template Solution<AxisymmetricQ8> Solver<AxisymmetricQ8>::Work::solution_at(const PathState<AxisymmetricQ8>&,
                                                                            const Felt&, const Eigen::VectorXd&);
template void Solver<AxisymmetricQ8>::Work::read(const Functional<AxisymmetricQ8>&, const PathState<AxisymmetricQ8>&,
                                                 const Felt&, double&,
                                                 Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>) const;
template void Solver<Hex20>::Work::finish(const Eigen::VectorXd&, const Felt&, Solution<Hex20>&) const;
template Solution<Hex20> Solver<Hex20>::Work::empty_solution() const;
template void Solver<Hex20>::Work::store(const Stresses&, const Stresses&, Solution<Hex20>&) const;
template void Solver<Hex20>::Work::read_all(const std::vector<Functional<Hex20>>&, const PathState<Hex20>&, const Felt&,
                                            std::size_t, Course&) const;
template Solution<Hex20> Solver<Hex20>::Work::solution_at(const PathState<Hex20>&, const Felt&, const Eigen::VectorXd&);
template void Solver<Hex20>::Work::read(const Functional<Hex20>&, const PathState<Hex20>&, const Felt&, double&,
                                        Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>) const;
} // namespace pave::fe

#include "fe/solver_work.h"

#include <algorithm>

namespace pave::fe {

template <class Element>
void Solver<Element>::Work::prepare(const std::vector<LayerMaterial>& run_layers,
                                    const std::vector<Variation>& run_variations, const SolverSettings& settings,
                                    const std::vector<double>& run_springs,
                                    const std::vector<Motion<Element>>& run_motions, bool at_once) {
    layers = &run_layers;
    variations = &run_variations;
    springs = &run_springs;
    motions = &run_motions;
    behind_end = false;
    prepared.clear();
    prepared.resize(run_layers.size());
    for (std::size_t l = 0; l < run_layers.size(); ++l) {
        const LayerMaterial& layer = run_layers[l];
        PreparedLayer<N>& p = prepared[l];
        p.stress_dependent = layer.law->stress_dependent();
        if (!p.stress_dependent) {
            p.modulus = layer.law->modulus(layer.parameters, {}).value;
        }
        p.turns_with_stress = layer.law->turns() || (layer.law->energy() != nullptr && !at_once);
        p.unit = layer.template unit_stiffness<N>();
        p.compliance = p.unit.inverse();
        for (const Variation& v : run_variations) {
            const bool own = v.kind == Variation::Kind::law_parameter && v.layer == static_cast<int>(l);
            p.modulus_rate.push_back(
                own && !p.stress_dependent
                    ? layer.law->modulus_derivative(layer.parameters, {}, {.value = p.modulus}, v.index)
                    : 0.0);
            p.unit_rate.push_back(own ? layer.template unit_stiffness_rate<N>(v.index)
                                      : mechanics::Stiffness<N>::Zero());
            p.turns.push_back(!p.unit_rate.back().isZero(0.0));
        }
    }
    prepare_points();
    bool constants_hold = true;
    for (std::size_t l = 0; l < prepared.size(); ++l) {
        const bool changes = prepared[l].stress_dependent || run_layers[l].law->relaxes();
        constants_hold = constants_hold && !(topology->linear[l] && changes);
    }
    system.begin(settings.linear_tolerance, constants_hold);
    hold();
    assemble_linear(std::vector<double>(prepared.size(), 1.0));
    initial.resize(points());
    initial_rate.resize(static_cast<std::size_t>(points()) * count());
    for (int a = 0; a < static_cast<int>(active.size()); ++a) {
        const int e = active[a];
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = a * Element::gauss + g;
            const double z = model->depth[e * Element::gauss + g];
            initial[q] = layer_of(e).template initial_stress<N>(z);
            for (int k = 0; k < count(); ++k) {
                const Motion<Element>* motion = motion_of(k);
                initial_rate[static_cast<std::size_t>(q) * count() + k] =
                    motion != nullptr ? layer_of(e).template initial_stress_of_weight<N>(
                                            motion->vertical_stress[static_cast<std::size_t>(e) * Element::gauss + g])
                                      : initial_stress_rate<N>(*layers, topology->layer[e], z, (*variations)[k]);
            }
        }
    }
    energies.prepare(*this);
}

template <class Element>
void Solver<Element>::Work::prepare_points() {
    prepared_point_of.clear();
    prepared_points.clear();
    std::vector<bool> varies(layers->size());
    for (std::size_t l = 0; l < varies.size(); ++l) {
        varies[l] = !(*layers)[l].fields.empty() || prepared[l].turns_with_stress;
    }
    if (std::none_of(varies.begin(), varies.end(), [](bool v) { return v; })) {
        return;
    }
    prepared_point_of.assign(model->points.size(), -1);
    for (int e = 0; e < model->elements(); ++e) {
        if (!varies[static_cast<std::size_t>(topology->layer[e])]) {
            continue;
        }
        PreparedLayer<N>& p = prepared[topology->layer[e]];
        for (int g = 0; g < Element::gauss; ++g) {
            PreparedPoint<N> point;
            if (p.turns_with_stress) {
                point.unit_rate.resize(variations->size());
                p.turns.assign(variations->size(), true);
            } else {
                const Eigen::Vector3d at = position_of(*model, e, g);
                point.unit = cut(local_stiffness(layer_of(e), at, {}));
                point.compliance = point.unit.inverse();
                for (int k = 0; k < count(); ++k) {
                    const Variation& v = (*variations)[k];
                    point.unit_rate.push_back(cut(local_stiffness_rate(layer_of(e), topology->layer[e], at, {}, v)));
                    p.turns[k] = p.turns[k] || !point.unit_rate.back().isZero(0.0);
                }
            }
            prepared_point_of[e * Element::gauss + g] = static_cast<int>(prepared_points.size());
            prepared_points.push_back(std::move(point));
        }
    }
}

template <class Element>
auto Solver<Element>::Work::units_of(std::size_t l) const -> std::vector<mechanics::Stiffness<N>> {
    if (prepared[l].turns_with_stress) {
        return {};
    }
    std::vector<mechanics::Stiffness<N>> units{prepared[l].unit};
    if (!(*layers)[l].fields.empty()) {
        for (int e = 0; e < model->elements(); ++e) {
            for (int g = 0; topology->layer[e] == static_cast<int>(l) && g < Element::gauss; ++g) {
                units.push_back(unit(e, g));
            }
        }
    }
    return units;
}

template <class Element>
void Solver<Element>::Work::hold() {
    held.resize(prepared.size());
    bool same_kinds = true;
    for (std::size_t l = 0; l < prepared.size(); ++l) {
        same_kinds = same_kinds && held[l].valid && held[l].stress_dependent == prepared[l].stress_dependent;
    }
    if (!same_kinds) {
        held.assign(prepared.size(), {});
        active.clear();
        active_number.assign(static_cast<std::size_t>(model->elements()), -1);
        for (int e = 0; e < model->elements(); ++e) {
            if (prepared_of(e).stress_dependent) {
                active_number[static_cast<std::size_t>(e)] = static_cast<int>(active.size());
                active.push_back(e);
            }
        }
        unit_stiffness.resize(Eigen::NoChange, points());
    }
    std::vector<bool> is_new(prepared.size());
    for (std::size_t l = 0; l < prepared.size(); ++l) {
        Held& h = held[l];
        auto units = units_of(l);
        is_new[l] = !h.valid || h.units != units;
        h.valid = true;
        h.stress_dependent = prepared[l].stress_dependent;
        h.units = std::move(units);
        if (is_new[l] && !h.stress_dependent) {
            h.values.assign(linear.size(), 0.0);
            for (int e = 0; e < model->elements(); ++e) {
                if (topology->layer[e] == static_cast<int>(l)) {
                    add_element(e, h);
                }
            }
        }
    }
    for (std::size_t a = 0; a < active.size(); ++a) {
        const auto l = static_cast<std::size_t>(topology->layer[active[a]]);
        for (int g = 0; is_new[l] && !prepared[l].turns_with_stress && g < Element::gauss; ++g) {
            set_unit_stiffness(static_cast<int>(a) * Element::gauss + g);
        }
    }
}

template <class Element>
void Solver<Element>::Work::set_unit_stiffness(int q) {
    const auto k = point_stiffness(active[q / Element::gauss], q % Element::gauss);
    double* column = unit_stiffness.col(q).data();
    for (int i = 0; i < Element::dofs; ++i) {
        for (int j = 0; j <= i; ++j) {
            *column++ = k(i, j);
        }
    }
}

template <class Element>
typename Element::Stress Solver<Element>::Work::subtract_motion(const Motion<Element>& motion, int e, int g,
                                                                const Vector& ue, const Stress& stress,
                                                                const mechanics::Stiffness<N>& stiffness, Vector& force,
                                                                double factor) const {
    const auto& rate = motion.points[static_cast<std::size_t>(e) * Element::gauss + g];
    Stress turned = stiffness * Element::strain(rate, ue);
    Element::add_force(rate, stress, -factor * point(e, g).weight, force);
    Element::add_force(point(e, g), stress, -factor * rate.weight, force);
    return turned;
}

template <class Element>
ElementMatrix<Element> Solver<Element>::Work::point_stiffness(int e, int g) const {
    return point_matrix<Element>(point(e, g), unit(e, g), point(e, g), point(e, g).weight);
}

template <class Element>
void Solver<Element>::Work::add_element(int e, Held& h) const {
    ElementMatrix<Element> k = point_stiffness(e, 0);
    for (int g = 1; g < Element::gauss; ++g) {
        k += point_stiffness(e, g);
    }
    int entry = 0;
    for (int i = 0; i < Element::dofs; ++i) {
        for (int j = 0; j <= i; ++j, ++entry) {
            if (const int place = topology->scatter[e][entry]; place >= 0) {
                h.values[place] += k(i, j);
            }
        }
    }
}

template <class Element>
void Solver<Element>::Work::assemble_linear(const std::vector<double>& shares) {
    std::fill(linear.begin(), linear.end(), 0.0);
    for (std::size_t l = 0; l < prepared.size(); ++l) {
        if (!prepared[l].stress_dependent && shares[l] != 0.0) {
            for (std::size_t k = 0; k < linear.size(); ++k) {
                linear[k] += shares[l] * prepared[l].modulus * held[l].values[k];
            }
        }
    }
    for (std::size_t i = 0; i < springs->size(); ++i) {
        for (const Spring::Entry& entry : model->springs[i].entries) {
            linear[entry.place] += (*springs)[i] * entry.value;
        }
    }
}

template <class Element>
void Solver<Element>::Work::assemble(const Eigen::VectorXd& modulus) {
    values = linear;
    Eigen::Matrix<double, lower_entries, 1> k;
    for (int a = 0; a < static_cast<int>(active.size()); ++a) {
        k.noalias() = unit_stiffness.template middleCols<Element::gauss>(a * Element::gauss) *
                      modulus.template segment<Element::gauss>(a * Element::gauss);
        const auto& scatter = topology->scatter[active[a]];
        for (int entry = 0; entry < lower_entries; ++entry) {
            if (scatter[entry] >= 0) {
                values[scatter[entry]] += k[entry];
            }
        }
    }
}

template <class Element>
void Solver<Element>::Work::subtract_linear_rate(int k, const Eigen::VectorXd& u,
                                                 const std::vector<const Eigen::VectorXd*>& felt, double* right) const {
    const Variation& v = (*variations)[k];
    if (v.kind == Variation::Kind::spring) {
        model->springs[v.index].add_product(u.data(), -1.0, right);
    }
    if (const Motion<Element>* motion = motion_of(k)) {
        subtract_linear_motion(*motion, felt, right);
    }
    if ((v.kind != Variation::Kind::law_parameter && v.kind != Variation::Kind::field) ||
        prepared[v.layer].stress_dependent) {
        return;
    }
    for (int e = 0; e < model->elements(); ++e) {
        if (topology->layer[e] != v.layer) {
            continue;
        }
        const Vector ue = model->gather(e, felt[static_cast<std::size_t>(v.layer)]->data());
        Vector force = Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            Element::add_force(point(e, g), linear_stiffness_rate(e, g, k) * Element::strain(point(e, g), ue),
                               -point(e, g).weight, force);
        }
        model->scatter_add(e, force, right);
    }
}

template <class Element>
void Solver<Element>::Work::subtract_linear_motion(const Motion<Element>& motion,
                                                   const std::vector<const Eigen::VectorXd*>& felt,
                                                   double* right) const {
    for (int e = 0; e < model->elements(); ++e) {
        const PreparedLayer<N>& p = prepared_of(e);
        if (p.stress_dependent) {
            continue;
        }
        const Vector ue = model->gather(e, felt[static_cast<std::size_t>(topology->layer[e])]->data());
        Vector force = Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const mechanics::Stiffness<N> d = p.modulus * unit(e, g);
            const Stress stress = d * Element::strain(point(e, g), ue);
            const Stress turned = subtract_motion(motion, e, g, ue, stress, d, force);
            Element::add_force(point(e, g), turned, -point(e, g).weight, force);
        }
        model->scatter_add(e, force, right);
    }
}

template <class Element>
template <class StressRate>
void Solver<Element>::Work::turn(int q, const Stress& total, mechanics::Invariants at, const StressRate& stress_rate) {
    const int e = active[q / Element::gauss];
    const int g = q % Element::gauss;
    const LayerMaterial& layer = layer_of(e);
    const Eigen::Vector3d position = position_of(*model, e, g);
    PreparedPoint<N>& p = prepared_points[prepared_point(e, g)];
    p.unit = cut(local_stiffness(layer, position, at));
    p.compliance = p.unit.inverse();
    set_unit_stiffness(q);
    if (count() == 0) {
        return;
    }
    const auto gradient = local_stiffness_gradient(layer, position, at);
    for (int k = 0; k < count(); ++k) {
        const Stress by = stress_rate(k);
        const double theta = -by.template head<3>().sum();
        const double tau = at.tau > 0.0 ? mechanics::tau_times_gradient<N>(total).dot(by) / at.tau : 0.0;
        p.unit_rate[k] = cut(local_stiffness_rate(layer, topology->layer[e], position, at, (*variations)[k]) +
                             theta * gradient.d_theta + tau * gradient.d_tau);
    }
}

template <class Element>
template <class StressRate>
void Solver<Element>::Work::set_tangent(int q, const Stress& total, const StressRate& whole_rate) {
    const auto& law = *energies.at(q);
    const auto state = law.at(total);
    PreparedPoint<N>& p = prepared_points[prepared_point(active[q / Element::gauss], q % Element::gauss)];
    modulus[q] = state.modulus;
    p.unit = law.tangent_unit(state, total);
    p.compliance = law.tangent_compliance(state);
    set_unit_stiffness(q);
    for (int k = 0; k < count(); ++k) {
        auto rate = law.tangent_rate(state, total, whole_rate(k), k);
        modulus_rate[static_cast<Eigen::Index>(q) * count() + k] = rate.modulus;
        p.unit_rate[k] = std::move(rate.unit);
    }
}

template <class Element>
void Solver<Element>::Work::settle(PathState<Element>& now, PathState<Element>& change) const {
    for (int q = 0; !energies.empty() && q < points(); ++q) {
        if (energies.at(q) == nullptr) {
            continue;
        }
        const int e = active[q / Element::gauss];
        const auto& at = point(e, q % Element::gauss);
        const Vector ue = model->gather(e, now.u.data());
        const auto answer = energies.answer(q, Element::strain(at, ue));
        const Stress stress = answer.whole - initial[q];
        change.stress.col(q) += stress - now.stress.col(q);
        now.stress.col(q) = stress;
        for (int k = 0; k < count(); ++k) {
            const Eigen::Index qk = static_cast<Eigen::Index>(q) * count() + k;
            Stress strain_rate = Element::strain(at, model->gather(e, now.du.col(k).data()));
            if (const Motion<Element>* motion = motion_of(k)) {
                strain_rate += Element::strain(motion->points[e * Element::gauss + q % Element::gauss], ue);
            }
            const Stress rate = energies.whole_rate(q, answer, strain_rate, k) - initial_rate[qk];
            change.d_stress.col(qk) += rate - now.d_stress.col(qk);
            now.d_stress.col(qk) = rate;
        }
    }
}

template <class Element>
void Solver<Element>::Work::set_modulus(int q, const Stress& stress, const double* d_stress) {
    const int e = active[q / Element::gauss];
    const LayerMaterial& layer = layer_of(e);
    const Stress total = initial[q] + stress;
    const auto whole_rate = [&](int k) {
        return Stress(initial_rate[static_cast<std::size_t>(q) * count() + k] +
                      Eigen::Map<const Stress>(d_stress + static_cast<std::ptrdiff_t>(N) * k));
    };
    if (energies.at(q) != nullptr) {
        set_tangent(q, total, whole_rate);
        return;
    }
    const auto at = mechanics::invariants<N>(total);
    const auto m = layer.law->modulus(layer.parameters, at);
    modulus[q] = m.value;
    if (prepared_of(e).turns_with_stress) {
        turn(q, total, at, whole_rate);
    }
    if (count() > 0) {
        const Stress gradient = modulus_gradient<N>(m, at, total);
        for (int k = 0; k < count(); ++k) {
            modulus_rate[static_cast<Eigen::Index>(q) * count() + k] =
                gradient.dot(whole_rate(k)) + explicit_modulus_rate(layer, topology->layer[e], at, m, k);
        }
    }
}

template <class Element>
void Solver<Element>::Work::catch_up() {
    if (behind_end) {
        set_moduli(path.now.stress, path.now.d_stress);
        assemble(modulus);
    }
    behind_end = false;
}

template <class Element>
void Solver<Element>::Work::set_moduli(const Stresses& stress, const Stresses& d_stress) {
    modulus.resize(points());
    modulus_rate.resize(static_cast<Eigen::Index>(points()) * count());
    for (int q = 0; q < points(); ++q) {
        set_modulus(q, stress.col(q), d_stress.data() + static_cast<std::ptrdiff_t>(N) * q * count());
    }
}

template <class Element>
void Solver<Element>::Work::set_stress(const Eigen::VectorXd& u, Stresses& stress, Stresses& d_stress,
                                       Eigen::MatrixXd& right, const std::vector<double>& factors) const {
    for (std::size_t a = 0; a < active.size(); ++a) {
        const int e = active[a];
        const auto& p = prepared_of(e);
        const double factor = factors.empty() ? 1.0 : factors[static_cast<std::size_t>(topology->layer[e])];
        const Vector ue = model->gather(e, u.data());
        std::array<Stress, Element::gauss> strain;
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = static_cast<int>(a) * Element::gauss + g;
            strain[g] = Element::strain(point(e, g), ue);
            stress.col(q) = modulus[q] * (unit(e, g) * strain[g]);
        }
        for (int k = 0; k < count(); ++k) {
            Vector force = Vector::Zero();
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                const Eigen::Index qk = static_cast<Eigen::Index>(q) * count() + k;
                Stress d = (modulus_rate[qk] / modulus[q]) * stress.col(q);
                if (p.turns[k]) {
                    d += modulus[q] * (unit_rate(e, g, k) * strain[g]);
                }
                if (const Motion<Element>* motion = motion_of(k)) {
                    d += subtract_motion(*motion, e, g, ue, stress.col(q), modulus[q] * unit(e, g), force, factor);
                }
                d_stress.col(qk) = d;
                Element::add_force(point(e, g), d, -factor * point(e, g).weight, force);
            }
            model->scatter_add(e, force, right.col(k).data());
        }
    }
}

template <class Element>
void Solver<Element>::Work::add_stress_rates(const Eigen::MatrixXd& du, Stresses& d_stress) const {
    for (std::size_t a = 0; a < active.size(); ++a) {
        const int e = active[a];
        for (int k = 0; k < count(); ++k) {
            const Vector de = model->gather(e, du.col(k).data());
            for (int g = 0; g < Element::gauss; ++g) {
                const int q = static_cast<int>(a) * Element::gauss + g;
                d_stress.col(static_cast<Eigen::Index>(q) * count() + k) +=
                    modulus[q] * (unit(e, g) * Element::strain(point(e, g), de));
            }
        }
    }
}

template <class Element>
void Solver<Element>::Work::subtract_force(const Stresses& stress, Eigen::Index stride, Eigen::Index offset,
                                           double* force, int layer) const {
    for (std::size_t a = 0; a < active.size(); ++a) {
        if (layer >= 0 && topology->layer[active[a]] != layer) {
            continue;
        }
        Vector own = Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& at = point(active[a], g);
            const auto q = static_cast<Eigen::Index>(a) * Element::gauss + g;
            Element::add_force(at, stress.col(q * stride + offset), -at.weight, own);
        }
        model->scatter_add(active[a], own, force);
    }
}

template <class Element>
void Solver<Element>::Work::subtract_force_motion(int k, const Stresses& stress, double* right) const {
    const Motion<Element>* motion = motion_of(k);
    for (std::size_t a = 0; motion != nullptr && a < active.size(); ++a) {
        const int e = active[a];
        Vector own = Vector::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto q = static_cast<Eigen::Index>(a) * Element::gauss + g;
            subtract_motion(*motion, e, g, Vector::Zero(), stress.col(q), mechanics::Stiffness<N>::Zero(), own);
        }
        model->scatter_add(e, own, right);
    }
}

template struct Solver<AxisymmetricQ8>::Work;
template struct Solver<Hex20>::Work;

} // namespace pave::fe

#include "base/units.h"
#include "fe/inert.h"
#include "fe/rates.h"
#include "fe/solver_work.h"

#include <cmath>

namespace pave::fe {
namespace {

// Of every column.
void solve(SupernodalFactor<double>& factor, Rates& x) {
    constexpr int together = 8;
    Block<together> block(x.rows(), together);
    for (Eigen::Index first = 0; first < x.cols(); first += together) {
        const Eigen::Index count = std::min<Eigen::Index>(together, x.cols() - first);
        block.setZero();
        block.leftCols(count) = x.middleCols(first, count);
        factor.solve<together>(block);
        x.middleCols(first, count) = block.leftCols(count);
    }
}

// The matrices of M a + C v + K u = f, as values on the pattern of the stiffness: M = inertia * mass,
// C = inertia * (delay * K + dashpots). Empty: zero.
struct Matrices {
    std::vector<double> stiffness, dashpots, mass;
};

// Makes them, and their rates, of what a solver worked on last. Modulus: of every Gauss point of the model.
template <class Element, class Work>
class Dynamics {
public:
    Dynamics(const Work& work, const Eigen::VectorXd& modulus, bool absorbs)
        : w_(work),
          modulus_(modulus),
          absorbs_(absorbs),
          entries_(w_.topology->lower.row.size()) {
        for (const auto& x : w_.model->coordinates) {
            wall_ = std::max(wall_, x.row(0).maxCoeff());
        }
    }

    Matrices matrices() const {
        Matrices m{w_.values, std::vector<double>(entries_, 0.0), std::vector<double>(entries_, 0.0)};
        for (int e = 0; e < w_.model->elements(); ++e) {
            add_mass(*w_.model, e, density(e), m.mass);
            if (is_at_wall(e)) {
                add_dashpots(e, std::sqrt(density(e) * shear(e)), m.dashpots);
            }
        }
        return m;
    }

    // modulus: by variation number k, at every Gauss point.
    Matrices rates(int k, const Eigen::VectorXd& modulus_rate) const {
        Matrices m;
        const Variation& v = (*w_.variations)[k];
        if (v.kind == Variation::Kind::spring) {
            for (const auto& entry : w_.model->springs[v.index].entries) {
                at(m.stiffness)[entry.place] += entry.value;
            }
        }
        for (int e = 0; e < w_.model->elements(); ++e) {
            const bool turns = w_.prepared_of(e).turns[k];
            const auto own = modulus_rate.template segment<Element::gauss>(e * Element::gauss);
            if (turns || !own.isZero(0.0)) {
                add_stiffness(e, k, own, at(m.stiffness));
            }
            const bool heavier = v.kind == Variation::Kind::unit_weight && v.layer == w_.topology->layer[e];
            const double density_rate = heavier ? 1.0 / unit::gravity : 0.0;
            if (heavier) {
                add_mass(*w_.model, e, density_rate, at(m.mass));
            }
            if (is_at_wall(e) && (turns || heavier || !own.isZero(0.0))) {
                double shear_rate = 0.0;
                for (int g = 0; g < Element::gauss; ++g) {
                    shear_rate += stiffness_rate(e, g, k, own[g])(3, 3) / Element::gauss;
                }
                const double rate =
                    (density_rate * shear(e) + density(e) * shear_rate) / (2.0 * std::sqrt(density(e) * shear(e)));
                add_dashpots(e, rate, at(m.dashpots));
            }
        }
        return m;
    }

    // The mean of 1/Vs over the layers from the surface down to the bottom of one of them, of that which makes it
    // largest [s/m].
    double slowest() const {
        const std::vector<LayerMaterial>& layers = *w_.layers;
        std::vector<double> volume(layers.size(), 0.0);
        std::vector<double> slowness(layers.size(), 0.0);
        for (int e = 0; e < w_.model->elements(); ++e) {
            const auto layer = static_cast<std::size_t>(w_.topology->layer[e]);
            double own = 0.0;
            for (int g = 0; g < Element::gauss; ++g) {
                own += w_.point(e, g).weight;
            }
            volume[layer] += own;
            slowness[layer] += own * std::sqrt(density(e) / shear(e));
        }
        double most = 0.0;
        double depth = 0.0;
        double time = 0.0; // from the surface down
        for (std::size_t l = 0; l < layers.size(); ++l) {
            depth += layers[l].thickness;
            time += layers[l].thickness * slowness[l] / volume[l];
            most = std::max(most, time / depth);
        }
        return most;
    }

    // d(E C) at a point
    mechanics::Stiffness<Element::voigt> stiffness_rate(int e, int g, int k, double modulus_rate) const {
        return modulus_rate * w_.unit(e, g) + modulus_[e * Element::gauss + g] * w_.unit_rate(e, g, k);
    }

private:
    std::vector<double>& at(std::vector<double>& values) const {
        values.resize(entries_, 0.0);
        return values;
    }
    double density(int e) const { return w_.layer_of(e).unit_weight / unit::gravity; }
    // The shear modulus on average over the element.
    double shear(int e) const {
        double sum = 0.0;
        for (int g = 0; g < Element::gauss; ++g) {
            sum += modulus_[e * Element::gauss + g] * w_.unit(e, g)(3, 3) / Element::gauss;
        }
        return sum;
    }
    bool is_at_wall(int e) const {
        return Element::dim == 2 && absorbs_ && w_.model->coordinates[e].row(0).maxCoeff() >= wall_;
    }

    void add_dashpots(int e, double impedance, std::vector<double>& to) const {
        if constexpr (Element::dim == 2) {
            const typename Element::Position vertical(0.0, impedance);
            integrate_side(*w_.model, e, 0, [&](const auto& shape, const auto&, double area) {
                add_inert<Element>(*w_.topology, e, shape, area * vertical, to);
            });
        }
    }
    template <class ModulusRates>
    void add_stiffness(int e, int k, const ModulusRates& modulus_rate, std::vector<double>& to) const {
        ElementMatrix<Element> sum = ElementMatrix<Element>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& point = w_.point(e, g);
            sum += point_matrix<Element>(point, stiffness_rate(e, g, k, modulus_rate[g]), point, point.weight);
        }
        add_to_lower(
            *w_.topology, e, [&](int a, int b) { return sum(a, b); }, to);
    }

    const Work& w_;
    const Eigen::VectorXd& modulus_;
    bool absorbs_;
    std::size_t entries_;
    double wall_ = 0.0; // where it stands: the farthest coordinate
};

} // namespace

template <class Element>
Outcome<InertialCourse> Solver<Element>::inertial(const Solution<Element>& end, const Eigen::VectorXd& load,
                                                  const History& history, const Inertia& inertia,
                                                  const std::vector<Functional<Element>>& readings) {
    Work& w = *work_;
    w.catch_up();
    const int count = w.count();
    const Pattern& lower = w.topology->lower;
    const auto n = static_cast<Eigen::Index>(readings.size());
    Eigen::VectorXd active_modulus(w.points());
    Eigen::MatrixXd modulus_rate = Eigen::MatrixXd::Zero(end.modulus.size(), count);
    for (int e = 0; e < w.model->elements(); ++e) {
        if (!w.prepared_of(e).stress_dependent) {
            for (int k = 0; k < count; ++k) {
                modulus_rate.col(k)
                    .template segment<Element::gauss>(e * Element::gauss)
                    .setConstant(w.prepared_of(e).modulus_rate[k]);
            }
        }
    }
    for (int q = 0; q < w.points(); ++q) {
        const int e = w.active[q / Element::gauss];
        const int at_model = e * Element::gauss + q % Element::gauss;
        active_modulus[q] = end.modulus[at_model];
        const LayerMaterial& layer = w.layer_of(e);
        if (layer.law->energy() != nullptr) { // as the load path left it, C and all
            for (int k = 0; k < count; ++k) {
                modulus_rate(at_model, k) = w.modulus_rate[static_cast<Eigen::Index>(q) * count + k];
            }
            continue;
        }
        const typename Element::Stress total = w.initial[q] + end.stress.col(at_model);
        const auto at = mechanics::invariants<Element::voigt>(total);
        const auto here = layer.law->modulus(layer.parameters, at);
        const auto gradient = modulus_gradient<Element::voigt>(here, at, total);
        for (int k = 0; k < count; ++k) {
            modulus_rate(at_model, k) =
                gradient.dot(w.initial_rate[static_cast<std::size_t>(q) * count + k] +
                             end.d_stress.col(static_cast<Eigen::Index>(at_model) * count + k)) +
                w.explicit_modulus_rate(layer, w.topology->layer[e], at, here, k);
        }
    }
    w.assemble(active_modulus);
    const Dynamics<Element, Work> dynamics(w, end.modulus, inertia.absorbs);
    const Matrices matrices = dynamics.matrices();
    std::vector<Matrices> matrix_rates;
    matrix_rates.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
        matrix_rates.push_back(dynamics.rates(k, modulus_rate.col(k)));
    }
    // Readings as weights on the displacement, and the rates of those weights.
    std::vector<Weights> weights;
    weights.reserve(readings.size());
    std::vector<std::vector<Weights>> weight_rates(readings.size());
    for (std::size_t i = 0; i < readings.size(); ++i) {
        weights.push_back(readings[i].on_displacement);
        weight_rates[i].resize(static_cast<std::size_t>(count));
        for (const auto& [q, weight, direction] : readings[i].on_stress) { // stress = E C strain
            const int e = q / Element::gauss;
            const auto add = [&, q = q, weight = weight](const typename Element::Stress& by, Weights& to) {
                typename Element::Vector on_element = Element::Vector::Zero();
                Element::add_force(w.model->points[q], by, weight, on_element);
                for (int a = 0; a < Element::dofs; ++a) {
                    if (const int unknown = w.topology->unknowns[e][a]; unknown >= 0 && on_element[a] != 0.0) {
                        to.emplace_back(unknown, on_element[a]);
                    }
                }
            };
            add(end.modulus[q] * (w.unit(e, q % Element::gauss) * direction), weights.back());
            for (int k = 0; k < count; ++k) {
                const double rate = modulus_rate(q, k);
                if (rate != 0.0 || w.prepared_of(e).turns[k]) {
                    add(dynamics.stiffness_rate(e, q % Element::gauss, k, rate) * direction,
                        weight_rates[i][static_cast<std::size_t>(k)]);
                }
            }
        }
    }
    const auto read = [&](const Eigen::VectorXd& u, const Rates& du, double factor, auto&& values,
                          Eigen::MatrixXd& to) {
        to.setZero(n, count);
        for (Eigen::Index i = 0; i < n; ++i) {
            values[i] = factor * weighted(weights[static_cast<std::size_t>(i)], u.data());
            for (const auto& [unknown, weight] : weights[static_cast<std::size_t>(i)]) {
                to.row(i) += (factor * weight) * du.row(unknown);
            }
            for (int k = 0; k < count; ++k) {
                to(i, k) +=
                    factor * weighted(weight_rates[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)], u.data());
            }
        }
    };

    const double step = history.step;
    const double delay = inertia.delay;
    const std::vector<double>& stiffness = matrices.stiffness;
    std::vector<double> damping(stiffness.size()); // at inertia 1
    std::vector<double> effective = stiffness;
    for (std::size_t k = 0; k < effective.size(); ++k) {
        damping[k] = delay * stiffness[k] + matrices.dashpots[k];
        effective[k] += inertia.factor * (2.0 / step * damping[k] + 4.0 / (step * step) * matrices.mass[k]);
    }
    const Failure not_definite{Status::failed,
                               "the section has lost its stiffness at the end of the load path: no pulse "
                               "can be followed there"};
    Eigen::MatrixXd load_rate;
    w.set_load_rates(load, load_rate);
    // right(:, k) -= d(M) a + d(C) v + d(K) u by variation k
    const auto subtract_rates = [&](const Eigen::VectorXd& u, const Eigen::VectorXd& v, const Eigen::VectorXd& a,
                                    Rates& right) {
        const Eigen::VectorXd delayed = u + inertia.factor * delay * v;
        Eigen::VectorXd force(u.size());
        for (int k = 0; k < count; ++k) {
            const Matrices& rates = matrix_rates[static_cast<std::size_t>(k)];
            const bool is_inertia = (*w.variations)[k].kind == Variation::Kind::inertia;
            if (!is_inertia && rates.stiffness.empty() && rates.dashpots.empty() && rates.mass.empty()) {
                continue;
            }
            force.setZero();
            if (!rates.dashpots.empty()) {
                add_product(lower, rates.dashpots, inertia.factor, v, force);
            }
            if (!rates.mass.empty()) {
                add_product(lower, rates.mass, inertia.factor, a, force);
            }
            if (!rates.stiffness.empty()) {
                add_product(lower, rates.stiffness, 1.0, delayed, force);
            }
            if (is_inertia) {
                add_product(lower, damping, 1.0, v, force);
                add_product(lower, matrices.mass, 1.0, a, force);
            }
            right.col(k) -= force;
        }
    };

    SupernodalFactor<double> factor(lower, w.topology->analysis->structure());
    if (!factor.factorize(stiffness, true)) {
        return not_definite;
    }
    Block<1> at_rest = load;
    factor.solve<1>(at_rest);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(load.size());
    Eigen::VectorXd v = u;
    Eigen::VectorXd acceleration = u;
    Rates du = Rates::Zero(load.size(), count);
    Rates dv = du;
    Rates d_acceleration = du;
    Rates d_at_rest = load_rate;
    if (count > 0) {
        subtract_rates(at_rest, v, v, d_at_rest);
        solve(factor, d_at_rest);
    }
    if (!factor.factorize(effective, true)) {
        return not_definite;
    }
    const double wait = inertia.reach * dynamics.slowest() * std::sqrt(inertia.factor);
    const std::size_t acting = history.factors.size();
    const auto steps = 2 * acting + static_cast<std::size_t>(std::ceil(2.0 * wait / step));
    InertialCourse result;
    result.moving = Course(n, steps, count, true);
    Course& course = result.moving;
    Rates next_rate;
    for (std::size_t i = 0; i < steps; ++i) {
        const double acts = i < acting ? history.factors[i] : 0.0;
        Block<1> next = acts * load;
        add_product(lower, matrices.mass, inertia.factor, 4.0 / (step * step) * u + 4.0 / step * v + acceleration,
                    next);
        add_product(lower, damping, inertia.factor, 2.0 / step * u + v, next);
        factor.solve<1>(next);
        const Eigen::VectorXd change = next - u;
        acceleration = 4.0 / (step * step) * change - 4.0 / step * v - acceleration;
        v = 2.0 / step * change - v;
        u = next;
        if (count > 0) {
            next_rate = acts * load_rate;
            add_product(lower, matrices.mass,
                        Rates(inertia.factor * (4.0 / (step * step) * du + 4.0 / step * dv + d_acceleration)),
                        next_rate);
            add_product(lower, damping, Rates(inertia.factor * (2.0 / step * du + dv)), next_rate);
            subtract_rates(u, v, acceleration, next_rate);
            solve(factor, next_rate);
            du = next_rate - du; // the change
            d_acceleration = 4.0 / (step * step) * du - 4.0 / step * dv - d_acceleration;
            dv = 2.0 / step * du - dv;
            du.swap(next_rate);
        }
        const auto at = static_cast<Eigen::Index>(i);
        read(u, du, 1.0, course.values.col(at), course.d_values[i]);
        read(v, dv, step, course.slopes.col(at), course.d_slopes[i]);
    }
    Eigen::VectorXd rest(n);
    Eigen::MatrixXd rest_rate;
    read(at_rest, d_at_rest, 1.0, rest, rest_rate);
    result.at_rest = Course(rest, rest_rate);
    return result;
}

template Outcome<InertialCourse> Solver<AxisymmetricQ8>::inertial(const Solution<AxisymmetricQ8>&,
                                                                  const Eigen::VectorXd&, const History&,
                                                                  const Inertia&,
                                                                  const std::vector<Functional<AxisymmetricQ8>>&);
template Outcome<InertialCourse> Solver<Hex20>::inertial(const Solution<Hex20>&, const Eigen::VectorXd&, const History&,
                                                         const Inertia&, const std::vector<Functional<Hex20>>&);

} // namespace pave::fe

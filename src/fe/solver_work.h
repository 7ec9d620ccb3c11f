// Shared by both integrations: the layers prepared for one run, assembly, and the closing figures. Private to fe/.
#pragma once

#include "fe/energy_points.h"
#include "fe/load_path.h"
#include "fe/solver.h"
#include "fe/symmetric_system.h"

#include <algorithm>

namespace pave::fe {

// A layer prepared for one run.
template <int N>
struct PreparedLayer {
    bool stress_dependent = false;
    double modulus = 0.0;               // of a linear layer [Pa]
    mechanics::Stiffness<N> unit;       // C
    mechanics::Stiffness<N> compliance; // C^-1
    // For every variation: dE/dp of a linear layer, and dC/dp (zero when `turns` is false).
    std::vector<double> modulus_rate;
    std::vector<mechanics::Stiffness<N>> unit_rate;
    std::vector<bool> turns;
    bool turns_with_stress = false; // C is that of the moment at every point
};

// A Gauss point of a layer with fields, or whose C follows the stress: then what set_moduli made of it.
template <int N>
struct PreparedPoint {
    mechanics::Stiffness<N> unit;       // C
    mechanics::Stiffness<N> compliance; // C^-1
    std::vector<mechanics::Stiffness<N>> unit_rate;
};

// The state along a load path, or its rate: displacement, load stress of the points of the active elements (a column
// a point), and both by variation.
template <class Element>
struct PathState {
    Eigen::VectorXd u;
    Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> stress;
    Eigen::MatrixXd du;
    Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> d_stress;

    void set_zero(int unknowns, int points, int count) {
        u.setZero(unknowns);
        stress.setZero(Element::voigt, points);
        du.setZero(unknowns, count);
        d_stress.setZero(Element::voigt, static_cast<Eigen::Index>(points) * count);
    }
    void add(double factor, const PathState& rate) {
        u += factor * rate.u;
        stress += factor * rate.stress;
        du += factor * rate.du;
        d_stress += factor * rate.d_stress;
    }
    void set_sum(const PathState& from, std::span<const double> factors, std::span<const PathState* const> rates) {
        *this = from;
        for (std::size_t j = 0; j < rates.size(); ++j) {
            add(factors[j], *rates[j]);
        }
    }
};

// y += factor K x, with the values of K on the pattern of its lower triangle.
inline void add_product(const Pattern& lower, const std::vector<double>& values, double factor,
                        const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Ref<Eigen::VectorXd> y) {
    for (int j = 0; j < lower.size; ++j) {
        double row = y[j]; // kept here: no waiting for it to be written
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            const int i = lower.row[k];
            const double value = factor * values[k];
            if (i != j) {
                y[i] += value * x[j];
            }
            row += value * x[i];
        }
        y[j] = row;
    }
}

// The displacement that the stress of each linear layer answers to, and its derivatives: that of the nodes, or of a
// layer that relaxes what is left of it.
struct Felt {
    std::vector<const Eigen::VectorXd*> u;
    std::vector<const Eigen::MatrixXd*> du;
};

template <class Element>
struct Solver<Element>::Work {
    static constexpr int N = Element::voigt;
    static constexpr int lower_entries = Topology<Element>::lower_entries;
    using Stress = typename Element::Stress;
    using Vector = typename Element::Vector;

    explicit Work(const Model<Element>& m)
        : topology(m.topology),
          model(&m),
          system(topology->lower, *topology->analysis),
          values(topology->lower.row.size()),
          linear(values) {}

    std::shared_ptr<const Topology<Element>> topology;
    const Model<Element>* model;
    // In two dimensions a factorisation costs little; in three, conjugate gradients cost less.
    SymmetricSystem<std::conditional_t<Element::dim == 2, double, float>> system;
    std::vector<double> values; // the matrix of the moment
    std::vector<double> linear; // its part from linear layers

    // Unsymmetric matrix of the secant tangent, made when first needed.
    Pattern full;
    std::vector<std::array<int, Element::dofs * Element::dofs>> full_scatter; // local (i, j) column by column
    std::unique_ptr<SparseLu> lu;
    std::vector<double> full_values;

    // One run.
    const std::vector<LayerMaterial>* layers = nullptr;
    const std::vector<Variation>* variations = nullptr;
    const std::vector<double>* springs = nullptr; // stiffness of each spring of the model
    const std::vector<Motion<Element>>* motions = nullptr;
    std::vector<PreparedLayer<N>> prepared;
    // Of the Gauss points of the model, where some layer has fields: index in prepared_points, or -1.
    std::vector<int> prepared_point_of;
    std::vector<PreparedPoint<N>> prepared_points;
    std::vector<int> active;          // stress-dependent elements
    std::vector<int> active_number;   // of every element, its place among them; -1: none
    std::vector<Stress> initial;      // initial stress at the points of the active elements, tension positive
    std::vector<Stress> initial_rate; // the same by variation: [point * variations + k]
    // B^T C B times the weight, lower triangle row by row, one column a point of an active element.
    Eigen::Matrix<double, lower_entries, Eigen::Dynamic> unit_stiffness;
    EnergyPoints<Element> energies; // of the points of the active elements whose law has one

    // Kept between runs: of each layer, for which C and as which kind (linear: its matrix for a modulus of 1;
    // stress-dependent: its columns of unit_stiffness) what is held was made. They are made in one way only, so that
    // having them changes no bit of a run.
    struct Held {
        bool valid = false;
        bool stress_dependent = false;
        std::vector<mechanics::Stiffness<N>> units; // the layer's own, then those of its points where it has fields
        std::vector<double> values;
    };
    std::vector<Held> held;

    // Buffers of a load path, kept so that runs do not allocate.
    LoadPath<PathState<Element>> path;
    bool behind_end = false; // moduli and values are still those of the path's last rate, before its end
    Eigen::VectorXd modulus;
    Eigen::VectorXd modulus_rate;

    int points() const { return static_cast<int>(active.size()) * Element::gauss; }
    int count() const { return static_cast<int>(variations->size()); }
    const LayerMaterial& layer_of(int element) const { return (*layers)[topology->layer[element]]; }
    const PreparedLayer<N>& prepared_of(int element) const { return prepared[topology->layer[element]]; }

    int prepared_point(int e, int g) const {
        return prepared_point_of.empty() ? -1 : prepared_point_of[e * Element::gauss + g];
    }
    // C, its inverse and its derivative at a Gauss point.
    const mechanics::Stiffness<N>& unit(int e, int g) const {
        const int q = prepared_point(e, g);
        return q < 0 ? prepared_of(e).unit : prepared_points[q].unit;
    }
    const mechanics::Stiffness<N>& compliance(int e, int g) const {
        const int q = prepared_point(e, g);
        return q < 0 ? prepared_of(e).compliance : prepared_points[q].compliance;
    }
    const mechanics::Stiffness<N>& unit_rate(int e, int g, int k) const {
        const int q = prepared_point(e, g);
        return q < 0 ? prepared_of(e).unit_rate[k] : prepared_points[q].unit_rate[k];
    }

    static mechanics::Stiffness<N> cut(const mechanics::Stiffness<6>& c) { return c.template topLeftCorner<N, N>(); }

    // at_once: no tangent of a law with an energy is requested here.
    void prepare(const std::vector<LayerMaterial>& run_layers, const std::vector<Variation>& run_variations,
                 const SolverSettings& settings, const std::vector<double>& run_springs,
                 const std::vector<Motion<Element>>& run_motions, bool at_once = false) {
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
                        motion != nullptr
                            ? layer_of(e).template initial_stress_of_weight<N>(
                                  motion->vertical_stress[static_cast<std::size_t>(e) * Element::gauss + g])
                            : initial_stress_rate<N>(*layers, topology->layer[e], z, (*variations)[k]);
                }
            }
        }
        energies.prepare(*this);
    }

    // C where it varies within a layer.
    void prepare_points() {
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
                        point.unit_rate.push_back(
                            cut(local_stiffness_rate(layer_of(e), topology->layer[e], at, {}, v)));
                        p.turns[k] = p.turns[k] || !point.unit_rate.back().isZero(0.0);
                    }
                }
                prepared_point_of[e * Element::gauss + g] = static_cast<int>(prepared_points.size());
                prepared_points.push_back(std::move(point));
            }
        }
    }

    // The parts of the stiffness of a layer for a modulus of 1; nothing, where set_moduli makes it.
    std::vector<mechanics::Stiffness<N>> units_of(std::size_t l) const {
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

    // Brings `active` and what is held of each layer up to date.
    void hold() {
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
    // Of number q of the points of the active elements, for C there.
    void set_unit_stiffness(int q) {
        const auto k = point_stiffness(active[q / Element::gauss], q % Element::gauss);
        double* column = unit_stiffness.col(q).data();
        for (int i = 0; i < Element::dofs; ++i) {
            for (int j = 0; j <= i; ++j) {
                *column++ = k(i, j);
            }
        }
    }

    const typename Element::Point& point(int element, int g) const {
        return model->points[element * Element::gauss + g];
    }

    // How the mesh moves with variation k; nullptr: it does not.
    const Motion<Element>* motion_of(int k) const {
        const Variation& v = (*variations)[k];
        return v.kind == Variation::Kind::motion ? &(*motions)[v.index] : nullptr;
    }
    // force -= d(B)^T stress weight + B^T stress d(weight): what a moving point adds to the internal force at held
    // stress. Returns what it adds to the stress at held displacement, stiffness d(B) u. factor: on the force.
    Stress subtract_motion(const Motion<Element>& motion, int e, int g, const Vector& ue, const Stress& stress,
                           const mechanics::Stiffness<N>& stiffness, Vector& force, double factor = 1.0) const {
        const auto& rate = motion.points[static_cast<std::size_t>(e) * Element::gauss + g];
        Stress turned = stiffness * Element::strain(rate, ue);
        Element::add_force(rate, stress, -factor * point(e, g).weight, force);
        Element::add_force(point(e, g), stress, -factor * rate.weight, force);
        return turned;
    }

    // B^T C B weight
    Eigen::Matrix<double, Element::dofs, Element::dofs> point_stiffness(int e, int g) const {
        const auto b = Element::strain_operator(point(e, g));
        const typename Element::Operator cb = point(e, g).weight * (unit(e, g) * b);
        return b.transpose() * cb;
    }

    // The element's stiffness for a modulus of 1, added to the values of its layer.
    void add_element(int e, Held& h) const {
        Eigen::Matrix<double, Element::dofs, Element::dofs> k = point_stiffness(e, 0);
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

    // linear := springs and linear layers, each with a share of its modulus.
    void assemble_linear(const std::vector<double>& shares) {
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

    // values := stiffness with these moduli at the points of the active elements.
    void assemble(const Eigen::VectorXd& modulus) {
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

    // d(E C)/dp_k at a point of a linear layer.
    mechanics::Stiffness<N> linear_stiffness_rate(int e, int g, int k) const {
        const PreparedLayer<N>& p = prepared_of(e);
        return p.modulus_rate[k] * unit(e, g) + p.modulus * unit_rate(e, g, k);
    }
    // right -= (dK/dp_k) u over the linear layers and the springs. felt: by each layer, u unless it relaxes.
    void subtract_linear_rate(int k, const Eigen::VectorXd& u, const std::vector<const Eigen::VectorXd*>& felt,
                              double* right) const {
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
    // The same of every variation, right(:, k), where no layer relaxes.
    void subtract_linear_rates(const Eigen::VectorXd& u, Eigen::MatrixXd& right) const {
        const std::vector<const Eigen::VectorXd*> felt(prepared.size(), &u);
        for (int k = 0; k < count(); ++k) {
            subtract_linear_rate(k, u, felt, right.col(k).data());
        }
    }
    Felt felt_by_all(const Eigen::VectorXd& u, const Eigen::MatrixXd& du) const {
        return {std::vector<const Eigen::VectorXd*>(prepared.size(), &u),
                std::vector<const Eigen::MatrixXd*>(prepared.size(), &du)};
    }

    // force -= (dK/dp) felt over the linear layers when the mesh moves.
    void subtract_linear_motion(const Motion<Element>& motion, const std::vector<const Eigen::VectorXd*>& felt,
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

    // Pattern and scatter of the full, unsymmetric matrix.
    void prepare_full() {
        if (lu != nullptr) {
            return;
        }
        const Pattern& lower = topology->lower;
        std::vector<std::vector<int>> columns(lower.size);
        for (int j = 0; j < lower.size; ++j) {
            for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
                columns[j].push_back(lower.row[k]);
                if (lower.row[k] != j) {
                    columns[lower.row[k]].push_back(j);
                }
            }
        }
        full.size = lower.size;
        full.column_start.assign(1, 0);
        for (auto& rows : columns) {
            std::sort(rows.begin(), rows.end());
            full.row.insert(full.row.end(), rows.begin(), rows.end());
            full.column_start.push_back(static_cast<int>(full.row.size()));
        }
        full_scatter.resize(model->elements());
        for (int e = 0; e < model->elements(); ++e) {
            for (int b = 0; b < Element::dofs; ++b) {
                for (int a = 0; a < Element::dofs; ++a) {
                    const int i = topology->unknowns[e][a];
                    const int j = topology->unknowns[e][b];
                    int& place = full_scatter[e][b * Element::dofs + a];
                    place = -1;
                    if (i >= 0 && j >= 0) {
                        const auto first = full.row.begin() + full.column_start[j];
                        const auto last = full.row.begin() + full.column_start[j + 1];
                        place = static_cast<int>(std::lower_bound(first, last, i) - full.row.begin());
                    }
                }
            }
        }
        full_values.resize(full.row.size());
        lu = std::make_unique<SparseLu>(full);
    }

    // full_values := the linear layers.
    void start_full() {
        const Pattern& lower = topology->lower;
        std::vector<int> next(full.column_start.begin(), full.column_start.end() - 1);
        // Rows of a column of the full matrix: first those above the diagonal, in the order in which the columns of
        // the lower triangle that hold them are met, then the column of the lower triangle itself.
        for (int j = 0; j < lower.size; ++j) {
            for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
                full_values[next[j]++] = linear[k];
                if (lower.row[k] != j) {
                    full_values[next[lower.row[k]]++] = linear[k];
                }
            }
        }
    }

    void add_full(int e, const Eigen::Matrix<double, Element::dofs, Element::dofs>& k) {
        for (int entry = 0; entry < Element::dofs * Element::dofs; ++entry) {
            if (const int place = full_scatter[e][entry]; place >= 0) {
                full_values[place] += k.data()[entry];
            }
        }
    }

    // force -= internal force of the linear layers at displacement x.
    void subtract_linear_force(const Eigen::VectorXd& x, Eigen::VectorXd& force) const {
        add_product(topology->lower, linear, -1.0, x, force);
    }

    static std::string describe_fold(double reached_by_load, double reached_by_smoothing) {
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

    // Stresses of the linear layers, residual, shares. `stress` of active elements is there already.
    void finish(const Eigen::VectorXd& load, Solution<Element>& solution) const {
        finish(load, felt_by_all(solution.displacement, solution.d_displacement), solution);
    }
    void finish(const Eigen::VectorXd& load, const Felt& felt, Solution<Element>& solution) const {
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

    Solution<Element> empty_solution() const {
        Solution<Element> s;
        const int total = model->elements() * Element::gauss;
        s.displacement = Eigen::VectorXd::Zero(model->free_unknowns());
        s.stress.resize(Eigen::NoChange, total);
        s.modulus.resize(total);
        s.d_displacement = Eigen::MatrixXd::Zero(model->free_unknowns(), count());
        s.d_stress.resize(Eigen::NoChange, static_cast<Eigen::Index>(total) * count());
        return s;
    }

    // C and its rates at a point whose C follows the stress; stress_rate: of the whole stress by variation k.
    template <class StressRate>
    void turn(int q, const Stress& total, mechanics::Invariants at, const StressRate& stress_rate) {
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

    // Of a law with an energy: modulus, C and their rates such that E C is the tangent stiffness.
    template <class StressRate>
    void set_tangent(int q, const Stress& total, const StressRate& whole_rate) {
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
    // After a step of time: stress where the law has an energy := that of the strain reached, whatever way led there,
    // with its rates; the change in the step likewise.
    void settle(PathState<Element>& now, PathState<Element>& change) const {
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

    // modulus, and modulus_rate by every variation, at number q of the points of the active elements where the load
    // stress is this; C and its rates where it follows the stress. d_stress(k): its rate by variation k.
    template <class StressRate>
    void set_modulus(int q, const Stress& stress, const StressRate& d_stress) {
        const int e = active[q / Element::gauss];
        const LayerMaterial& layer = layer_of(e);
        const Stress total = initial[q] + stress;
        const auto whole_rate = [&](int k) {
            return Stress(initial_rate[static_cast<std::size_t>(q) * count() + k] + d_stress(k));
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
    // Moduli and values as they are at the end of the load path.
    void catch_up() {
        if (behind_end) {
            set_moduli(path.now.stress, path.now.d_stress);
            assemble(modulus);
        }
        behind_end = false;
    }
    // The same at all of them.
    template <class Stresses>
    void set_moduli(const Stresses& stress, const Stresses& d_stress) {
        modulus.resize(points());
        modulus_rate.resize(static_cast<Eigen::Index>(points()) * count());
        for (int q = 0; q < points(); ++q) {
            set_modulus(q, stress.col(q),
                        [&](int k) { return d_stress.col(static_cast<Eigen::Index>(q) * count() + k); });
        }
    }
    // With these moduli: stress := that of the displacement u at the points of the active elements, d_stress := its
    // rates at held u, right(:, k) -= their force, times the factor of the layer where there are factors.
    template <class Stresses>
    void set_stress(const Eigen::VectorXd& u, Stresses& stress, Stresses& d_stress, Eigen::MatrixXd& right,
                    const std::vector<double>& factors = {}) const {
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
    // d_stress += that of the rates du of the displacement.
    template <class Stresses>
    void add_stress_rates(const Eigen::MatrixXd& du, Stresses& d_stress) const {
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
    // force -= that of stress at the points of the active elements.
    // layer: of that one alone; negative: of all.
    template <class Stresses, class Force>
    void subtract_force(const Stresses& stress, Eigen::Index stride, Eigen::Index offset, Force&& force,
                        int layer = -1) const {
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
            model->scatter_add(active[a], own, force.data());
        }
    }
    // right -= what the force of held stress at the points of the active elements changes by as the mesh moves with
    // variation k.
    template <class Stresses>
    void subtract_force_motion(int k, const Stresses& stress, double* right) const {
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
    // Stresses, moduli and rates of the points of the active elements to where the solution has them.
    template <class Stresses>
    void store(const Stresses& stress, const Stresses& d_stress, Solution<Element>& solution) const {
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

    // All readings at an instant of a course.
    void read_all(const std::vector<Functional<Element>>& readings, const PathState<Element>& now, const Felt& by,
                  std::size_t instant, Course& course) const {
        for (std::size_t r = 0; r < readings.size(); ++r) {
            const auto row = static_cast<Eigen::Index>(r);
            read(readings[r], now, by, course.values(row, static_cast<Eigen::Index>(instant)),
                 course.d_values[instant].row(row));
        }
    }
    // An instant of a course under its load. Sets the moduli to those there.
    Solution<Element> solution_at(const PathState<Element>& now, const Felt& by, const Eigen::VectorXd& load) {
        Solution<Element> solution = empty_solution();
        solution.displacement = now.u;
        solution.d_displacement = now.du;
        set_moduli(now.stress, now.d_stress);
        store(now.stress, now.d_stress, solution);
        finish(load, by, solution);
        return solution;
    }

    // A reading and its rates where linear layers answer to `by`.
    template <class Rates>
    void read(const Functional<Element>& f, const PathState<Element>& now, const Felt& by, double& value,
              Rates&& rates) const {
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

    // right(:, k) = d(load)/dp_k.
    void set_load_rates(const Eigen::VectorXd& load, Eigen::MatrixXd& right) const {
        right.setZero(load.size(), count());
        for (int k = 0; k < count(); ++k) {
            const Variation& v = (*variations)[k];
            if (v.kind == Variation::Kind::load_factor) {
                right.col(k) = load;
            } else if (v.kind == Variation::Kind::pressure_shape) {
                right.col(k) = v.load_rate;
            } else if (const Motion<Element>* motion = motion_of(k)) {
                right.col(k) = motion->load;
            }
        }
    }

    // dE/dp_k explicitly (parameters of the law) at a point of an active element.
    double explicit_modulus_rate(const LayerMaterial& layer, int layer_index, mechanics::Invariants at,
                                 const material::Modulus& here, int k) const {
        const Variation& v = (*variations)[k];
        return v.kind == Variation::Kind::law_parameter && v.layer == layer_index
                   ? layer.law->modulus_derivative(layer.parameters, at, here, v.index)
                   : 0.0;
    }
};

} // namespace pave::fe

// Shared by both integrations: the layers prepared for one run, assembly, and the closing figures. Private to fe/.
#pragma once

#include "fe/element_matrix.h"
#include "fe/energy_points.h"
#include "fe/full_matrix.h"
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
    using Stresses = Eigen::Matrix<double, N, Eigen::Dynamic>; // a column a point, or a point and variation

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
    std::vector<double> values;                // the matrix of the moment
    std::vector<double> linear;                // its part from linear layers
    std::unique_ptr<FullMatrix<Element>> full; // of the secant law's tangent, made when first needed

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
                 const std::vector<Motion<Element>>& run_motions, bool at_once = false);

    // C where it varies within a layer.
    void prepare_points();

    // The parts of the stiffness of a layer for a modulus of 1; nothing, where set_moduli makes it.
    std::vector<mechanics::Stiffness<N>> units_of(std::size_t l) const;

    // Brings `active` and what is held of each layer up to date.
    void hold();
    // Of number q of the points of the active elements, for C there.
    void set_unit_stiffness(int q);

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
                           const mechanics::Stiffness<N>& stiffness, Vector& force, double factor = 1.0) const;

    // B^T C B weight
    ElementMatrix<Element> point_stiffness(int e, int g) const;

    // The element's stiffness for a modulus of 1, added to the values of its layer.
    void add_element(int e, Held& h) const;

    // linear := springs and linear layers, each with a share of its modulus.
    void assemble_linear(const std::vector<double>& shares);

    // values := stiffness with these moduli at the points of the active elements.
    void assemble(const Eigen::VectorXd& modulus);

    // d(E C)/dp_k at a point of a linear layer.
    mechanics::Stiffness<N> linear_stiffness_rate(int e, int g, int k) const {
        const PreparedLayer<N>& p = prepared_of(e);
        return p.modulus_rate[k] * unit(e, g) + p.modulus * unit_rate(e, g, k);
    }
    // right -= (dK/dp_k) u over the linear layers and the springs. felt: by each layer, u unless it relaxes.
    void subtract_linear_rate(int k, const Eigen::VectorXd& u, const std::vector<const Eigen::VectorXd*>& felt,
                              double* right) const;
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
                                double* right) const;

    // force -= internal force of the linear layers at displacement x.
    void subtract_linear_force(const Eigen::VectorXd& x, Eigen::VectorXd& force) const {
        add_product(topology->lower, linear, -1.0, x, force);
    }

    // Stresses of the linear layers, residual, shares. `stress` of active elements is there already.
    void finish(const Eigen::VectorXd& load, Solution<Element>& solution) const {
        finish(load, felt_by_all(solution.displacement, solution.d_displacement), solution);
    }
    void finish(const Eigen::VectorXd& load, const Felt& felt, Solution<Element>& solution) const;

    Solution<Element> empty_solution() const;

    // C and its rates at a point whose C follows the stress; stress_rate: of the whole stress by variation k.
    template <class StressRate>
    void turn(int q, const Stress& total, mechanics::Invariants at, const StressRate& stress_rate);

    // Of a law with an energy: modulus, C and their rates such that E C is the tangent stiffness.
    template <class StressRate>
    void set_tangent(int q, const Stress& total, const StressRate& whole_rate);
    // After a step of time: stress where the law has an energy := that of the strain reached, whatever way led there,
    // with its rates; the change in the step likewise.
    void settle(PathState<Element>& now, PathState<Element>& change) const;

    // modulus, and modulus_rate by every variation, at number q of the points of the active elements where the load
    // stress is this; C and its rates where it follows the stress. d_stress: its rates, one after the other.
    void set_modulus(int q, const Stress& stress, const double* d_stress);
    // Moduli and values as they are at the end of the load path.
    void catch_up();
    // The same at all of them.
    void set_moduli(const Stresses& stress, const Stresses& d_stress);
    // With these moduli: stress := that of the displacement u at the points of the active elements, d_stress := its
    // rates at held u, right(:, k) -= their force, times the factor of the layer where there are factors.
    void set_stress(const Eigen::VectorXd& u, Stresses& stress, Stresses& d_stress, Eigen::MatrixXd& right,
                    const std::vector<double>& factors = {}) const;
    // d_stress += that of the rates du of the displacement.
    void add_stress_rates(const Eigen::MatrixXd& du, Stresses& d_stress) const;
    // force -= that of stress at the points of the active elements.
    // layer: of that one alone; negative: of all.
    void subtract_force(const Stresses& stress, Eigen::Index stride, Eigen::Index offset, double* force,
                        int layer = -1) const;
    // right -= what the force of held stress at the points of the active elements changes by as the mesh moves with
    // variation k.
    void subtract_force_motion(int k, const Stresses& stress, double* right) const;
    // Stresses, moduli and rates of the points of the active elements to where the solution has them.
    void store(const Stresses& stress, const Stresses& d_stress, Solution<Element>& solution) const;

    // All readings at an instant of a course.
    void read_all(const std::vector<Functional<Element>>& readings, const PathState<Element>& now, const Felt& by,
                  std::size_t instant, Course& course) const;
    // An instant of a course under its load. Sets the moduli to those there.
    Solution<Element> solution_at(const PathState<Element>& now, const Felt& by, const Eigen::VectorXd& load);

    // A reading and its rates where linear layers answer to `by`.
    void read(const Functional<Element>& f, const PathState<Element>& now, const Felt& by, double& value,
              Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> rates) const;

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

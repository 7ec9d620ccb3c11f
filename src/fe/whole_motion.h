// The equation of motion of all unknowns: what a march in time asks of it. Private to fe/.
#pragma once

#include "fe/boundary.h"
#include "fe/memory.h"
#include "fe/rates.h"
#include "fe/solver_work.h"

namespace pave::fe {

// to += factor * values; empty values: zero.
inline void add(double factor, const std::vector<double>& values, std::vector<double>& to) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        to[i] += factor * values[i];
    }
}

// A matrix of few entries.
inline Spring sparse(const Pattern& lower, const std::vector<double>& values) {
    Spring matrix;
    for (int j = 0; j < lower.size && !values.empty(); ++j) {
        for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
            if (values[static_cast<std::size_t>(k)] != 0.0) {
                matrix.entries.push_back({lower.row[k], j, k, values[static_cast<std::size_t>(k)]});
            }
        }
    }
    return matrix;
}

// Of a prepared run, w.modulus as before the load: mass, open sides, and their rates by every variation.
template <class Element, class Work>
class InertMatrices {
public:
    explicit InertMatrices(const Work& w)
        : w_(w),
          sides(OpenSides<Element, Work>(w, *w.model).matrices()),
          mass(mass_of(*w.model, nullptr)) {
        for (int k = 0; k < w.count(); ++k) {
            side_rates.push_back(sides_rate(k));
            mass_rates.push_back(mass_rate(k));
        }
    }

private:
    // Mass of every layer, or of one as if its unit weight were 1.
    std::vector<double> mass_of(const Model<Element>& model, const Variation* by) const {
        std::vector<double> mass(w_.topology->lower.row.size(), 0.0);
        for (int e = 0; e < model.elements(); ++e) {
            if (by == nullptr) {
                add_mass(model, e, w_.layer_of(e).unit_weight / unit::gravity, mass);
            } else if (by->layer == w_.topology->layer[e]) {
                add_mass(model, e, 1.0 / unit::gravity, mass);
            }
        }
        return mass;
    }
    // By a variation; empty: none.
    std::vector<double> mass_rate(int k) const {
        const Variation& v = (*w_.variations)[static_cast<std::size_t>(k)];
        if (v.kind == Variation::Kind::unit_weight) {
            return mass_of(*w_.model, &v);
        }
        std::vector<double> rate;
        if (const auto* motion = w_.motion_of(k)) {
            rate.assign(w_.topology->lower.row.size(), 0.0);
            for (const auto& [weight, there] : motion->beside) {
                add(weight, mass_of(there, nullptr), rate);
            }
        }
        return rate;
    }
    Sides sides_rate(int k) const {
        Sides rate = OpenSides<Element, Work>(w_, *w_.model).rates(k);
        if (const auto* motion = w_.motion_of(k)) {
            rate.dashpots.resize(w_.topology->lower.row.size(), 0.0);
            rate.springs.resize(w_.topology->lower.row.size(), 0.0);
            for (const auto& [weight, there] : motion->beside) {
                const Sides at = OpenSides<Element, Work>(w_, there).matrices();
                add(weight, at.dashpots, rate.dashpots);
                add(weight, at.springs, rate.springs);
            }
        }
        return rate;
    }

    const Work& w_;

public:
    Sides sides;
    std::vector<double> mass;
    std::vector<Sides> side_rates;
    std::vector<std::vector<double>> mass_rates; // empty: none
};

// factors: of each layer, what K + 2/h C is of its stiffness; shares: what F is. step: h.
template <class Element, class Work>
class WholeMotion {
public:
    using Stresses = Eigen::Matrix<double, Element::voigt, Eigen::Dynamic>;

    WholeMotion(Work& w, const std::vector<Functional<Element>>& readings, const Eigen::VectorXd& load,
                const std::vector<double>& factors, const std::vector<double>& shares, double step)
        : w_(w),
          lower_(w.topology->lower),
          readings_(readings),
          load_(load),
          factors_(factors) {
        const InertMatrices<Element, Work> inert(w);
        dashpots_ = sparse(lower_, inert.sides.dashpots);
        mass_ = inert.mass;
        mass_rates_ = inert.mass_rates;
        for (const Sides& rates : inert.side_rates) {
            spring_rates_.push_back(sparse(lower_, rates.springs));
            dashpot_rates_.push_back(sparse(lower_, rates.dashpots));
        }
        w.assemble_linear(shares);
        add(1.0, inert.sides.springs, w.linear);
        lasting_ = w.linear;
        w.assemble_linear(factors);
        add(1.0, inert.sides.springs, w.linear);
        add(2.0 / step, inert.sides.dashpots, w.linear);
        add(4.0 / (step * step), mass_, w.linear);
        w.set_load_rates(load, load_rates_);
    }

    Eigen::Index unknowns() const { return lower_.size; }
    int points() const { return w_.points(); } // of stress-dependent layers
    const Eigen::VectorXd& load() const { return load_; }
    const Eigen::MatrixXd& load_rates() const { return load_rates_; }

    // y += factor * matrix * x of the mass, of what F answers to displacement by, of the dashpots of the sides, of the
    // stiffness of one linear layer.
    void add_mass(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        add_product(lower_, mass_, factor, x, y);
    }
    void add_lasting(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        add_product(lower_, lasting_, factor, x, y);
    }
    void add_dashpots(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        dashpots_.add_product(x.data(), factor, y.data());
    }
    void add_layer(std::size_t layer, double factor, const Eigen::Ref<const Eigen::VectorXd>& x,
                   Eigen::Ref<Eigen::VectorXd> y) const {
        add_product(lower_, w_.held[layer].values, factor * w_.prepared[layer].modulus, x, y);
    }
    // right += mass_factor M dv - lasting du, by all variations.
    void add_history_rates(double mass_factor, const Rates& dv, const Eigen::MatrixXd& du, Eigen::MatrixXd& right) {
        rows_.setZero(dv.rows(), dv.cols());
        add_product(lower_, mass_, Rates(mass_factor * dv), rows_);
        add_product(lower_, lasting_, Rates(-du), rows_);
        right += rows_;
    }
    // Of the matrices themselves, by variation k.
    template <class Vector>
    void add_mass_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        if (const auto& rate = mass_rates_[static_cast<std::size_t>(k)]; !rate.empty()) {
            add_product(lower_, rate, factor, x, y);
        }
    }
    template <class Vector>
    void add_spring_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        spring_rates_[static_cast<std::size_t>(k)].add_product(x.data(), factor, y.data());
    }
    template <class Vector>
    void add_dashpot_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        dashpot_rates_[static_cast<std::size_t>(k)].add_product(x.data(), factor, y.data());
    }
    // right -= d(stiffness of linear layers) by variation k, of what each layer feels.
    template <class Vector>
    void subtract_linear_rate(int k, const Eigen::VectorXd& u, const std::vector<const Eigen::VectorXd*>& felt,
                              Vector&& right) const {
        w_.subtract_linear_rate(k, u, felt, right.data());
    }

    void set_moduli(const Stresses& stress, const Stresses& d_stress) { w_.set_moduli(stress, d_stress); }
    // At the moduli at hand. False: it is not definite.
    bool set_matrix() {
        if (points() > 0 || !has_matrix_) {
            Eigen::VectorXd acting = w_.modulus;
            for (int q = 0; q < points(); ++q) {
                acting[q] *= factors_[static_cast<std::size_t>(w_.topology->layer[w_.active[q / Element::gauss]])];
            }
            w_.assemble(acting);
            has_matrix_ = w_.system.set_matrix(w_.values);
        }
        return has_matrix_;
    }
    template <class Right>
    bool solve(Right& right) {
        return w_.system.solve(right, {});
    }
    // force -= that of stress in stress-dependent layers, or in one of them.
    void subtract_force(const Stresses& stress, Eigen::Index stride, Eigen::Index offset,
                        Eigen::Ref<Eigen::VectorXd> force, int layer = -1) const {
        w_.subtract_force(stress, stride, offset, force.data(), layer);
    }
    template <class Vector>
    void subtract_force_motion(int k, const Stresses& stress, Vector&& right) const {
        w_.subtract_force_motion(k, stress, right.data());
    }
    void set_stress(const Eigen::VectorXd& u, Stresses& stress, Stresses& d_stress, Eigen::MatrixXd& right) const {
        w_.set_stress(u, stress, d_stress, right, factors_);
    }
    void add_stress_rates(const Eigen::MatrixXd& du, Stresses& d_stress) const { w_.add_stress_rates(du, d_stress); }
    void settle(PathState<Element>& now, PathState<Element>& change) const { w_.settle(now, change); }
    void read_all(const PathState<Element>& now, const Felt& by, std::size_t instant, Course& course) const {
        w_.read_all(readings_, now, by, instant, course);
    }
    Felt felt_by_all(const PathState<Element>& now) const { return w_.felt_by_all(now.u, now.du); }

private:
    Work& w_;
    const Pattern& lower_;
    const std::vector<Functional<Element>>& readings_;
    const Eigen::VectorXd& load_;
    const std::vector<double>& factors_;
    Eigen::MatrixXd load_rates_;
    std::vector<double> mass_, lasting_;
    Spring dashpots_;
    std::vector<Spring> spring_rates_, dashpot_rates_;
    std::vector<std::vector<double>> mass_rates_;
    Rates rows_;
    bool has_matrix_ = false;
};

} // namespace pave::fe

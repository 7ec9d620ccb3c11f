// The equation of motion projected on a subspace: what a march in time asks of it, at the cost of small matrices.
// Private to fe/.
#pragma once

#include "fe/subspace.h"
#include "fe/whole_motion.h"

#include <Eigen/Cholesky>
#include <map>

namespace pave::fe {

// Projections are made for the mesh where it stands, at every run: modes are fields on its nodes, which move with it.
// Linear layers, mass and open sides enter as they are; stress-dependent layers are integrated at the points of the
// subspace (empirical cubature: Farhat et al. 2014, doi 10.1002/nme.4668), each of which keeps its own stress.
template <class Element, class Work>
class ReducedMotion {
public:
    static constexpr int N = Element::voigt;
    using Stress = typename Element::Stress;
    using Stresses = Eigen::Matrix<double, N, Eigen::Dynamic>;

    ReducedMotion(Work& w, const Subspace& subspace, const std::vector<Functional<Element>>& readings,
                  const Eigen::VectorXd& load, const std::vector<double>& factors, const std::vector<double>& shares,
                  double step)
        : w_(w),
          modes_(subspace.modes),
          factors_(factors) {
        gather_points(subspace, readings);
        const InertMatrices<Element, Work> inert(w);
        mass_ = projected(inert.mass);
        dashpots_ = projected(inert.sides.dashpots);
        const Eigen::MatrixXd springs = projected(inert.sides.springs);
        for (int k = 0; k < count(); ++k) {
            const auto at = static_cast<std::size_t>(k);
            mass_rates_.push_back(projected(inert.mass_rates[at]));
            spring_rates_.push_back(projected(inert.side_rates[at].springs));
            dashpot_rates_.push_back(projected(inert.side_rates[at].dashpots));
        }
        linear_ = springs + 2.0 / step * dashpots_ + 4.0 / (step * step) * mass_;
        lasting_ = springs;
        layers_.resize(w.prepared.size());
        for (std::size_t l = 0; l < layers_.size(); ++l) {
            if (!w.prepared[l].stress_dependent) {
                layers_[l] = w.prepared[l].modulus * projected(w.held[l].values);
                linear_ += factors[l] * layers_[l];
                lasting_ += shares[l] * layers_[l];
            }
        }
        for (int k = 0; k < count(); ++k) {
            add_linear_rates(k);
        }
        load_ = modes_.transpose() * load;
        Eigen::MatrixXd load_rates;
        w.set_load_rates(load, load_rates);
        load_rates_ = modes_.transpose() * load_rates;
        for (const auto& f : readings) {
            readings_.push_back(projected(f));
        }
    }

    Eigen::Index unknowns() const { return modes_.cols(); }
    int points() const { return static_cast<int>(points_.size()); }
    const Eigen::VectorXd& load() const { return load_; }
    const Eigen::MatrixXd& load_rates() const { return load_rates_; }

    void add_mass(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        y.noalias() += factor * (mass_ * x);
    }
    void add_lasting(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        y.noalias() += factor * (lasting_ * x);
    }
    void add_dashpots(double factor, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
        y.noalias() += factor * (dashpots_ * x);
    }
    void add_layer(std::size_t layer, double factor, const Eigen::Ref<const Eigen::VectorXd>& x,
                   Eigen::Ref<Eigen::VectorXd> y) const {
        y.noalias() += factor * (layers_[layer] * x);
    }
    void add_history_rates(double mass_factor, const Rates& dv, const Eigen::MatrixXd& du, Eigen::MatrixXd& right) {
        right.noalias() += mass_factor * (mass_ * dv);
        right.noalias() -= lasting_ * du;
    }
    template <class Vector>
    void add_mass_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        add(mass_rates_, k, factor, x, y);
    }
    template <class Vector>
    void add_spring_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        add(spring_rates_, k, factor, x, y);
    }
    template <class Vector>
    void add_dashpot_rate(int k, double factor, const Eigen::VectorXd& x, Vector&& y) const {
        add(dashpot_rates_, k, factor, x, y);
    }
    template <class Vector>
    void subtract_linear_rate(int k, const Eigen::VectorXd&, const std::vector<const Eigen::VectorXd*>& felt,
                              Vector&& right) const {
        for (const auto& [layer, rate] : linear_rates_[static_cast<std::size_t>(k)]) {
            right.noalias() -= rate * *felt[layer];
        }
    }

    void set_moduli(const Stresses& stress, const Stresses& d_stress) {
        for (Eigen::Index s = 0; s < points(); ++s) {
            w_.set_modulus(points_[static_cast<std::size_t>(s)].number, stress.col(s),
                           d_stress.data() + N * s * count());
        }
    }
    bool set_matrix() {
        if (points() == 0 && has_matrix_) {
            return true;
        }
        matrix_ = linear_;
        scaled_ = metric_;
        for (Eigen::Index s = 0; s < cubature_; ++s) {
            const Point& p = points_[static_cast<std::size_t>(s)];
            scaled_.template middleRows<N>(N * s) *= std::sqrt(factors_[p.layer] * p.weight * w_.modulus[p.number]);
        }
        if (cubature_ > 0) {
            matrix_.template selfadjointView<Eigen::Lower>().rankUpdate(scaled_.transpose());
        }
        factor_.compute(matrix_);
        has_matrix_ = factor_.info() == Eigen::Success;
        return has_matrix_;
    }
    template <class Right>
    bool solve(Right& right) {
        factor_.solveInPlace(right);
        return right.allFinite();
    }
    void subtract_force(const Stresses& stress, Eigen::Index stride, Eigen::Index offset,
                        Eigen::Ref<Eigen::VectorXd> force, int layer = -1) const {
        Eigen::VectorXd weighed(N * cubature_);
        for (Eigen::Index s = 0; s < cubature_; ++s) {
            const Point& p = points_[static_cast<std::size_t>(s)];
            const bool acts = layer < 0 || p.layer == static_cast<std::size_t>(layer);
            weighed.template segment<N>(N * s) = (acts ? p.weight : 0.0) * stress.col(s * stride + offset);
        }
        force.noalias() -= strains_.topRows(N * cubature_).transpose() * weighed;
    }
    template <class Vector>
    void subtract_force_motion(int k, const Stresses& stress, Vector&& right) const {
        if (w_.motion_of(k) != nullptr) {
            subtract_moved_force(k, stress, {}, right);
        }
    }
    void set_stress(const Eigen::VectorXd& u, Stresses& stress, Stresses& d_stress, Eigen::MatrixXd& right) const {
        const Eigen::VectorXd strain = strains_ * u;
        for (Eigen::Index s = 0; s < points(); ++s) {
            stress.col(s) = stress_of(s, strain);
        }
        Eigen::VectorXd weighed(N * cubature_);
        for (int k = 0; k < count(); ++k) {
            const bool moves = w_.motion_of(k) != nullptr;
            Eigen::VectorXd turned;
            if (moves) {
                turned = strain_rates_[static_cast<std::size_t>(k)] * u;
            }
            for (Eigen::Index s = 0; s < points(); ++s) {
                const Point& p = points_[static_cast<std::size_t>(s)];
                Stress d = stress.col(s);
                d *= w_.modulus_rate[static_cast<Eigen::Index>(p.number) * count() + k] / w_.modulus[p.number];
                if (w_.prepared[p.layer].turns[static_cast<std::size_t>(k)]) {
                    const Stress own = strain.template segment<N>(N * s);
                    d += w_.modulus[p.number] * Stress(w_.unit_rate(p.element, p.gauss, k) * own);
                }
                if (moves) {
                    d += stress_of(s, turned);
                }
                d_stress.col(s * count() + k) = d;
                if (s < cubature_) {
                    weighed.template segment<N>(N * s) = factors_[p.layer] * p.weight * d;
                }
            }
            right.col(k).noalias() -= strains_.topRows(N * cubature_).transpose() * weighed;
            if (moves) {
                subtract_moved_force(k, stress, factors_, right.col(k));
            }
        }
    }
    void add_stress_rates(const Eigen::MatrixXd& du, Stresses& d_stress) const {
        const Eigen::MatrixXd strain = strains_ * du;
        for (Eigen::Index s = 0; s < points(); ++s) {
            const mechanics::Stiffness<N> d = stiffness(s);
            for (int k = 0; k < count(); ++k) {
                d_stress.col(s * count() + k) += d * strain.template block<N, 1>(N * s, k);
            }
        }
    }
    // Sections of laws with an energy have no reduced model.
    void settle(PathState<Element>&, PathState<Element>&) const {}
    void read_all(const PathState<Element>& now, const Felt& by, std::size_t instant, Course& course) const {
        for (std::size_t r = 0; r < readings_.size(); ++r) {
            const Reading& f = readings_[r];
            const auto row = static_cast<Eigen::Index>(r);
            double& value = course.values(row, static_cast<Eigen::Index>(instant));
            Eigen::RowVectorXd rates = f.on_u * now.du;
            value = f.on_u.dot(now.u);
            for (const auto& [layer, on_felt, rates_on_felt] : f.on_layers) {
                value += on_felt.dot(*by.u[layer]);
                rates.noalias() += on_felt * *by.du[layer];
                rates.noalias() += (rates_on_felt * *by.u[layer]).transpose();
            }
            for (const auto& [s, weight] : f.on_stress) {
                value += weight.dot(now.stress.col(s));
                rates.noalias() += weight.transpose() * now.d_stress.middleCols(s * count(), count());
            }
            course.d_values[instant].row(row) = rates;
        }
    }
    Felt felt_by_all(const PathState<Element>& now) const { return w_.felt_by_all(now.u, now.du); }

private:
    struct Point {
        int number = 0; // of the points of the active elements
        int element = 0, gauss = 0;
        std::size_t layer = 0;
        double weight = 0.0; // in the cubature, m3; 0: the stress there is read
        double share = 0.0;  // the same, of its own
    };
    struct Reading {
        Eigen::RowVectorXd on_u;
        struct OnLayer { // that is linear
            std::size_t layer;
            Eigen::RowVectorXd on_felt;
            Eigen::MatrixXd rates_on_felt; // a row a variation
        };
        std::vector<OnLayer> on_layers;
        std::vector<std::pair<Eigen::Index, Stress>> on_stress; // point, weight
    };

    int count() const { return w_.count(); }

    // V^T K V of values on the pattern of the stiffness; empty: empty.
    Eigen::MatrixXd projected(const std::vector<double>& values) const {
        if (values.empty()) {
            return {};
        }
        const Pattern& lower = w_.topology->lower;
        Rates image = Rates::Zero(lower.size, modes_.cols());
        for (int j = 0; j < lower.size; ++j) {
            for (int k = lower.column_start[j]; k < lower.column_start[j + 1]; ++k) {
                const double value = values[static_cast<std::size_t>(k)];
                if (value == 0.0) {
                    continue;
                }
                image.row(j) += value * modes_.row(lower.row[k]);
                if (lower.row[k] != j) {
                    image.row(lower.row[k]) += value * modes_.row(j);
                }
            }
        }
        return modes_.transpose() * image;
    }

    // B of a Gauss point on the modes.
    Eigen::MatrixXd strains(int element, const typename Element::Point& point) const {
        Eigen::MatrixXd own(Element::dofs, modes_.cols());
        for (int i = 0; i < Element::dofs; ++i) {
            const int unknown = w_.topology->unknowns[element][i];
            if (unknown >= 0) {
                own.row(i) = modes_.row(unknown);
            } else {
                own.row(i).setZero();
            }
        }
        return Eigen::MatrixXd(Element::strain_operator(point)) * own;
    }

    void gather_points(const Subspace& subspace, const std::vector<Functional<Element>>& readings) {
        const auto add_point = [&](int gauss, double share) {
            const int e = gauss / Element::gauss;
            if (!w_.prepared_of(e).stress_dependent) {
                return;
            }
            const int g = gauss % Element::gauss;
            points_.push_back({.number = w_.active_number[static_cast<std::size_t>(e)] * Element::gauss + g,
                               .element = e,
                               .gauss = g,
                               .layer = static_cast<std::size_t>(w_.topology->layer[e]),
                               .weight = share * w_.point(e, g).weight,
                               .share = share});
        };
        for (const auto& p : subspace.points) {
            add_point(p.gauss, p.share);
        }
        cubature_ = static_cast<Eigen::Index>(points_.size());
        for (const auto& f : readings) {
            for (const auto& at : f.on_stress) {
                const bool follows = w_.prepared_of(at.point / Element::gauss).stress_dependent;
                if (follows && followed_.try_emplace(at.point, static_cast<Eigen::Index>(points_.size())).second) {
                    add_point(at.point, 0.0);
                }
            }
        }
        const auto rows = N * static_cast<Eigen::Index>(points_.size());
        strains_.resize(rows, modes_.cols());
        metric_.resize(N * cubature_, modes_.cols());
        strain_rates_.resize(static_cast<std::size_t>(count()));
        for (int k = 0; k < count(); ++k) {
            if (w_.motion_of(k) != nullptr) {
                strain_rates_[static_cast<std::size_t>(k)].resize(rows, modes_.cols());
            }
        }
        for (Eigen::Index s = 0; s < points(); ++s) {
            const Point& p = points_[static_cast<std::size_t>(s)];
            const Eigen::MatrixXd b = strains(p.element, w_.point(p.element, p.gauss));
            strains_.middleRows(N * s, N) = b;
            if (s < cubature_) {
                const Eigen::LLT<Eigen::MatrixXd> root(Eigen::MatrixXd(w_.unit(p.element, p.gauss)));
                metric_.middleRows(N * s, N) = Eigen::MatrixXd(root.matrixU()) * b;
            }
            for (int k = 0; k < count(); ++k) {
                if (const auto* motion = w_.motion_of(k)) {
                    strain_rates_[static_cast<std::size_t>(k)].middleRows(N * s, N) =
                        strains(p.element, rate_of(*motion, p));
                }
            }
        }
    }
    static const typename Element::Point& rate_of(const Motion<Element>& motion, const Point& p) {
        return motion.points[static_cast<std::size_t>(p.element) * Element::gauss + static_cast<std::size_t>(p.gauss)];
    }

    mechanics::Stiffness<N> stiffness(Eigen::Index s) const {
        const Point& p = points_[static_cast<std::size_t>(s)];
        return w_.modulus[p.number] * w_.unit(p.element, p.gauss);
    }

    // That of strains of all points at one of them.
    Stress stress_of(Eigen::Index s, const Eigen::VectorXd& strains) const {
        const Stress own = strains.template segment<N>(N * s);
        return stiffness(s) * own;
    }

    // right -= what moving points add to the force of this stress. factors: of every layer; empty: 1.
    void subtract_moved_force(int k, const Stresses& stress, const std::vector<double>& factors,
                              Eigen::Ref<Eigen::VectorXd> right) const {
        Eigen::VectorXd here(N * cubature_);
        Eigen::VectorXd moved(N * cubature_);
        for (Eigen::Index s = 0; s < cubature_; ++s) {
            const Point& p = points_[static_cast<std::size_t>(s)];
            const double factor = factors.empty() ? 1.0 : factors[p.layer];
            moved.template segment<N>(N * s) = factor * p.weight * stress.col(s);
            here.template segment<N>(N * s) = factor * p.share * rate_of(*w_.motion_of(k), p).weight * stress.col(s);
        }
        right.noalias() -= strain_rates_[static_cast<std::size_t>(k)].topRows(N * cubature_).transpose() * moved;
        right.noalias() -= strains_.topRows(N * cubature_).transpose() * here;
    }

    // d(stiffness) of every linear layer that variation k changes.
    void add_linear_rates(int k) {
        auto& list = linear_rates_.emplace_back();
        const Variation& v = (*w_.variations)[static_cast<std::size_t>(k)];
        const Motion<Element>* motion = w_.motion_of(k);
        for (std::size_t l = 0; l < layers_.size(); ++l) {
            const auto& p = w_.prepared[l];
            const bool own = (v.kind == Variation::Kind::law_parameter || v.kind == Variation::Kind::field) &&
                             v.layer == static_cast<int>(l);
            if (p.stress_dependent || (!own && motion == nullptr)) {
                continue;
            }
            const auto at = static_cast<std::size_t>(k);
            if (own && !p.turns[at]) {
                list.emplace_back(l, p.modulus_rate[at] / p.modulus * layers_[l]);
                continue;
            }
            std::vector<double> rate(w_.topology->lower.row.size(), 0.0);
            for (int e = 0; e < w_.model->elements(); ++e) {
                if (w_.topology->layer[e] == static_cast<int>(l)) {
                    const auto dk = own ? stiffness_rate(e, k) : moved_stiffness(e, *motion);
                    add_to_lower(
                        *w_.topology, e, [&](int a, int b) { return dk(a, b); }, rate);
                }
            }
            list.emplace_back(l, projected(rate));
        }
    }
    ElementMatrix<Element> stiffness_rate(int e, int k) const {
        ElementMatrix<Element> sum = ElementMatrix<Element>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& point = w_.point(e, g);
            sum += point_matrix<Element>(point, w_.linear_stiffness_rate(e, g, k), point, point.weight);
        }
        return sum;
    }
    ElementMatrix<Element> moved_stiffness(int e, const Motion<Element>& motion) const {
        ElementMatrix<Element> sum = ElementMatrix<Element>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const auto& point = w_.point(e, g);
            const auto& rate = motion.points[static_cast<std::size_t>(e) * Element::gauss + g];
            const mechanics::Stiffness<N> d = w_.prepared_of(e).modulus * w_.unit(e, g);
            const ElementMatrix<Element> half = point_matrix<Element>(point, d, rate, point.weight);
            sum += half;
            sum += half.transpose();
            sum += point_matrix<Element>(point, d, point, rate.weight);
        }
        return sum;
    }

    Reading projected(const Functional<Element>& f) const {
        Reading r;
        r.on_u = Eigen::RowVectorXd::Zero(modes_.cols());
        for (const auto& [unknown, weight] : f.on_displacement) {
            r.on_u += weight * modes_.row(unknown);
        }
        for (const auto& [gauss, weight, direction] : f.on_stress) {
            const int e = gauss / Element::gauss;
            const int g = gauss % Element::gauss;
            if (w_.prepared_of(e).stress_dependent) {
                r.on_stress.emplace_back(followed_.at(gauss), weight * direction);
                continue;
            }
            const auto layer = static_cast<std::size_t>(w_.topology->layer[e]);
            const Eigen::MatrixXd b = strains(e, w_.point(e, g));
            const mechanics::Stiffness<N> d = w_.prepared_of(e).modulus * w_.unit(e, g);
            const auto across = [&](const mechanics::Stiffness<N>& stiffness, const Eigen::MatrixXd& strain) {
                const Eigen::VectorXd on_strain = weight * (stiffness * direction); // symmetric
                return Eigen::RowVectorXd(on_strain.transpose() * strain);
            };
            Eigen::MatrixXd rates(count(), modes_.cols());
            for (int k = 0; k < count(); ++k) {
                rates.row(k) = across(w_.linear_stiffness_rate(e, g, k), b);
                if (const Motion<Element>* motion = w_.motion_of(k)) {
                    rates.row(k) += across(d, strains(e, motion->points[static_cast<std::size_t>(gauss)]));
                }
            }
            r.on_layers.push_back({layer, across(d, b), std::move(rates)});
        }
        return r;
    }

    static void add(const std::vector<Eigen::MatrixXd>& rates, int k, double factor, const Eigen::VectorXd& x,
                    Eigen::Ref<Eigen::VectorXd> y) {
        if (const auto& rate = rates[static_cast<std::size_t>(k)]; rate.size() > 0) {
            y.noalias() += factor * (rate * x);
        }
    }

    Work& w_;
    Rates modes_; // a row an unknown
    const std::vector<double>& factors_;
    std::vector<Point> points_;                 // those of the cubature first
    Eigen::Index cubature_ = 0;                 // so many
    std::map<int, Eigen::Index> followed_;      // by the Gauss point of the model
    Eigen::MatrixXd strains_;                   // N rows a point
    Eigen::MatrixXd metric_;                    // the same of the cubature in the metric of C
    std::vector<Eigen::MatrixXd> strain_rates_; // by every variation that moves the mesh
    Eigen::MatrixXd mass_, dashpots_, lasting_, linear_;
    std::vector<Eigen::MatrixXd> layers_; // stiffness of the linear ones
    std::vector<Eigen::MatrixXd> mass_rates_, spring_rates_, dashpot_rates_;
    std::vector<std::vector<std::pair<std::size_t, Eigen::MatrixXd>>> linear_rates_; // of each variation, by layer
    Eigen::VectorXd load_;
    Eigen::MatrixXd load_rates_;
    std::vector<Reading> readings_;
    Eigen::MatrixXd scaled_, matrix_;
    Eigen::LLT<Eigen::MatrixXd> factor_;
    bool has_matrix_ = false;
};

} // namespace pave::fe

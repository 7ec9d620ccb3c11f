// What holds the open sides of an axisymmetric mesh in motion. Private to fe/.
#pragma once

#include "base/units.h"
#include "fe/inert.h"
#include "fe/solver_work.h"
#include "layered/dual.h"

namespace pave::fe {

// Values on the pattern of the stiffness; empty: zero.
struct Sides {
    std::vector<double> dashpots, springs;
};

// Of an element beside an open side, on average.
template <class Real>
struct Elasticity {
    Real density;  // kg/m3
    Real outward;  // D1111 [Pa]
    Real downward; // D3333 [Pa]
    Real shear;    // D1313 [Pa]
};

// Dashpots per area: sqrt(density D), of D1111 or D3333 across the side and D1313 along it. They take plane waves that
// meet the side squarely. Springs per area at the distance R from the origin, with n the distance of the side from the
// axis or the surface: 2 G n / R^2 outwards, what holds a widening cylinder or sphere about the origin within a factor
// of two; downwards, where the bottom is open, the ratio of traction to displacement in Boussinesq's solution (1885) of
// a point force on a half-space, 6 G z^2 n / R^4 / (z^2/R^2 + 2 (1 - nu)). A load that acts slowly then finds about the
// section without end.
template <class Work>
class OpenSides {
public:
    // model: where the mesh stands, or another of its places, with the moduli at hand.
    OpenSides(const Work& work, const Model<AxisymmetricQ8>& model) : w_(work), model_(model) {
        for (const auto& x : model_.coordinates) {
            wall_ = std::max(wall_, x.row(0).maxCoeff());
            bottom_ = std::max(bottom_, x.row(1).maxCoeff());
        }
    }

    // At the moduli at hand.
    Sides matrices() const {
        Sides sides = zero();
        each_side([&](int e, bool is_wall) {
            add_side(
                e, is_wall, mean(e), [](double value) { return value; }, sides);
        });
        return sides;
    }
    // By variation number k; empty where it changes nothing.
    Sides rates(int k) const {
        Sides sides;
        each_side([&](int e, bool is_wall) {
            const auto elasticity = mean_and_rate(e, k);
            if (elasticity.density.d[0] != 0.0 || elasticity.outward.d[0] != 0.0 || elasticity.downward.d[0] != 0.0 ||
                elasticity.shear.d[0] != 0.0) {
                if (sides.dashpots.empty()) {
                    sides = zero();
                }
                add_side(
                    e, is_wall, elasticity, [](const Real& value) { return value.d[0]; }, sides);
            }
        });
        return sides;
    }

private:
    using Element = AxisymmetricQ8;
    using Real = layered::Dual<1>;

    Sides zero() const {
        const std::vector<double> none(w_.topology->lower.row.size(), 0.0);
        return {none, none};
    }

    template <class F>
    void each_side(F at) const {
        for (int e = 0; e < model_.elements(); ++e) {
            const auto& x = model_.coordinates[static_cast<std::size_t>(e)];
            if (w_.topology->wall_is_open && x.row(0).maxCoeff() >= wall_) {
                at(e, true);
            }
            if (w_.topology->bottom_is_open && x.row(1).maxCoeff() >= bottom_) {
                at(e, false);
            }
        }
    }

    // d(E C) by variation k, or E C itself.
    mechanics::Stiffness<4> stiffness(int e, int g, int k) const {
        const auto& p = w_.prepared_of(e);
        if (!p.stress_dependent) {
            return k < 0 ? mechanics::Stiffness<4>(p.modulus * w_.unit(e, g)) : w_.linear_stiffness_rate(e, g, k);
        }
        const Eigen::Index q = w_.active_number[static_cast<std::size_t>(e)] * Element::gauss + g;
        if (k < 0) {
            return w_.modulus[q] * w_.unit(e, g);
        }
        mechanics::Stiffness<4> rate = w_.modulus_rate[q * w_.count() + k] * w_.unit(e, g);
        if (p.turns[static_cast<std::size_t>(k)]) {
            rate += w_.modulus[q] * w_.unit_rate(e, g, k);
        }
        return rate;
    }
    mechanics::Stiffness<4> mean_stiffness(int e, int k) const {
        mechanics::Stiffness<4> sum = mechanics::Stiffness<4>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            sum += stiffness(e, g, k) / Element::gauss;
        }
        return sum;
    }
    Elasticity<double> mean(int e) const {
        const auto d = mean_stiffness(e, -1);
        return {w_.layer_of(e).unit_weight / unit::gravity, d(0, 0), d(2, 2), d(3, 3)};
    }
    Elasticity<Real> mean_and_rate(int e, int k) const {
        const Variation& v = (*w_.variations)[static_cast<std::size_t>(k)];
        const bool heavier = v.kind == Variation::Kind::unit_weight && v.layer == w_.topology->layer[e];
        const Elasticity<double> here = mean(e);
        const auto d = mean_stiffness(e, k);
        const auto real = [](double value, double rate) { return Real(value, Real::Rates::Constant(rate)); };
        return {real(here.density, heavier ? 1.0 / unit::gravity : 0.0), real(here.outward, d(0, 0)),
                real(here.downward, d(2, 2)), real(here.shear, d(3, 3))};
    }

    // part: the value or the rate of a number.
    template <class Number, class F>
    void add_side(int e, bool is_wall, const Elasticity<Number>& elasticity, F part, Sides& to) const {
        using std::sqrt;
        const Number shear = elasticity.shear;
        const Number along = sqrt(elasticity.density * shear);
        const Number across = sqrt(elasticity.density * (is_wall ? elasticity.outward : elasticity.downward));
        const Eigen::Vector2d impedance(part(is_wall ? across : along), part(is_wall ? along : across));
        const Number twice_one_less_nu = elasticity.downward / (elasticity.downward - shear);
        const auto at = [&](const auto& shape, const Element::Position& place, double area) {
            const double square = place.squaredNorm();
            const double depth = place[1] * place[1] / square;
            const double distance = is_wall ? place[0] : place[1];
            Eigen::Vector2d spring(part(2.0 * distance / square * shear), 0.0);
            if (w_.topology->bottom_is_open) {
                spring[1] = part(6.0 * depth * distance / square * (shear / (depth + twice_one_less_nu)));
            }
            add_inert<Element>(*w_.topology, e, shape, area * impedance, to.dashpots);
            add_inert<Element>(*w_.topology, e, shape, area * spring, to.springs);
        };
        is_wall ? integrate_outer_side(model_, e, at) : integrate_lower_side(model_, e, at);
    }

    const Work& w_;
    const Model<AxisymmetricQ8>& model_;
    double wall_ = 0.0, bottom_ = 0.0; // m, where they stand
};

} // namespace pave::fe

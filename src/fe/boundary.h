// Springs and dashpots at the open sides of a mesh in motion. Private to fe/.
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

// Dashpots per area: sqrt(density D), with D of strain across the side for displacement across it, of shear in its
// plane with that for displacement along it. They take plane waves that meet the side squarely. Springs per area at the
// distance R from the origin, with n the distance of the side from there along its axis: 2 G n / R^2 horizontally, what
// holds a widening cylinder or sphere about the origin within a factor of two; downwards, where the bottom is open, the
// ratio of traction to displacement in Boussinesq's solution (1885) of a point force on a half-space,
// 6 G z^2 n / R^4 / (z^2/R^2 + 2 (1 - nu)). A load that acts slowly then finds about the section without end.
template <class Element, class Work>
class OpenSides {
public:
    // model: where the mesh stands, or another of its places, with the moduli at hand.
    OpenSides(const Work& work, const Model<Element>& model) : w_(work), model_(model) {
        last_.setZero();
        for (const auto& x : model_.coordinates) {
            last_ = last_.cwiseMax(x.rowwise().maxCoeff());
        }
    }

    // At the moduli at hand.
    Sides matrices() const {
        Sides sides = zero();
        each_side([&](int e, int axis) {
            add_side(
                e, axis, mean(e), [](double value) { return value; }, sides);
        });
        return sides;
    }
    // By variation number k; empty where it changes nothing.
    Sides rates(int k) const {
        Sides sides;
        each_side([&](int e, int axis) {
            const Elasticity<Real> elasticity = mean_and_rate(e, k);
            const auto changes = [](const Real& value) { return value.d[0] != 0.0; };
            if (changes(elasticity.density) || std::ranges::any_of(elasticity.diagonal, changes)) {
                if (sides.dashpots.empty()) {
                    sides = zero();
                }
                add_side(
                    e, axis, elasticity, [](const Real& value) { return value.d[0]; }, sides);
            }
        });
        return sides;
    }

private:
    using Real = layered::Dual<1>;
    using Stiffness = mechanics::Stiffness<Element::voigt>;

    // Of an element beside an open side, on average.
    template <class Number>
    struct Elasticity {
        Number density;                              // kg/m3
        std::array<Number, Element::voigt> diagonal; // of the stiffness [Pa]
    };
    // Which of them answers displacement along one axis that changes along another.
    static int component(int displacement, int axis) {
        if constexpr (Element::dim == 2) {
            constexpr int of[2][2] = {{0, 3}, {3, 2}};
            return of[displacement][axis];
        } else {
            constexpr int of[3][3] = {{0, 5, 3}, {5, 1, 4}, {3, 4, 2}}; // as mechanics/voigt.h has them
            return of[displacement][axis];
        }
    }
    static constexpr int vertical = 2, vertical_shear = 3;

    Sides zero() const {
        const std::vector<double> none(w_.topology->lower.row.size(), 0.0);
        return {none, none};
    }

    template <class F>
    void each_side(F at) const {
        for (int e = 0; e < model_.elements(); ++e) {
            const auto& x = model_.coordinates[static_cast<std::size_t>(e)];
            for (int axis = 0; axis < Element::dim; ++axis) {
                const bool is_open = axis == Element::down ? w_.topology->bottom_is_open : w_.topology->wall_is_open;
                if (is_open && x.row(axis).maxCoeff() >= last_[axis]) {
                    at(e, axis);
                }
            }
        }
    }

    // d(E C) by variation k, or E C itself.
    Stiffness stiffness(int e, int g, int k) const {
        const auto& p = w_.prepared_of(e);
        if (!p.stress_dependent) {
            return k < 0 ? Stiffness(p.modulus * w_.unit(e, g)) : w_.linear_stiffness_rate(e, g, k);
        }
        const Eigen::Index q = w_.active_number[static_cast<std::size_t>(e)] * Element::gauss + g;
        if (k < 0) {
            return w_.modulus[q] * w_.unit(e, g);
        }
        Stiffness rate = w_.modulus_rate[q * w_.count() + k] * w_.unit(e, g);
        if (p.turns[static_cast<std::size_t>(k)]) {
            rate += w_.modulus[q] * w_.unit_rate(e, g, k);
        }
        return rate;
    }
    Stiffness mean_stiffness(int e, int k) const {
        Stiffness sum = Stiffness::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            sum += stiffness(e, g, k) / Element::gauss;
        }
        return sum;
    }
    Elasticity<double> mean(int e) const {
        Elasticity<double> elasticity{w_.layer_of(e).unit_weight / unit::gravity, {}};
        const Stiffness d = mean_stiffness(e, -1);
        for (int i = 0; i < Element::voigt; ++i) {
            elasticity.diagonal[static_cast<std::size_t>(i)] = d(i, i);
        }
        return elasticity;
    }
    Elasticity<Real> mean_and_rate(int e, int k) const {
        const Variation& v = (*w_.variations)[static_cast<std::size_t>(k)];
        const bool heavier = v.kind == Variation::Kind::unit_weight && v.layer == w_.topology->layer[e];
        const Elasticity<double> here = mean(e);
        const Stiffness d = mean_stiffness(e, k);
        const auto real = [](double value, double rate) { return Real(value, Real::Rates::Constant(rate)); };
        Elasticity<Real> elasticity{real(here.density, heavier ? 1.0 / unit::gravity : 0.0), {}};
        for (std::size_t i = 0; i < Element::voigt; ++i) {
            const auto at = static_cast<Eigen::Index>(i);
            elasticity.diagonal[i] = real(here.diagonal[i], d(at, at));
        }
        return elasticity;
    }

    // part: the value or the rate of a number.
    template <class Number, class F>
    void add_side(int e, int axis, const Elasticity<Number>& elasticity, F part, Sides& to) const {
        using std::sqrt;
        using Directions = Eigen::Matrix<double, Element::dim, 1>;
        const auto& of = elasticity.diagonal;
        Directions impedance;
        for (int d = 0; d < Element::dim; ++d) {
            impedance[d] = part(sqrt(elasticity.density * of[static_cast<std::size_t>(component(d, axis))]));
        }
        const Number shear = of[vertical_shear];
        const Number twice_one_less_nu = of[vertical] / (of[vertical] - shear);
        integrate_side(model_, e, axis, [&](const auto& shape, const auto& place, double area) {
            const double square = place.squaredNorm();
            const double depth = place[Element::down] * place[Element::down] / square;
            Directions spring = Directions::Constant(part(2.0 * place[axis] / square * shear));
            spring[Element::down] =
                w_.topology->bottom_is_open
                    ? part(6.0 * depth * place[axis] / square * (shear / (depth + twice_one_less_nu)))
                    : 0.0;
            add_inert<Element>(*w_.topology, e, shape, area * impedance, to.dashpots);
            add_inert<Element>(*w_.topology, e, shape, area * spring, to.springs);
        });
    }

    const Work& w_;
    const Model<Element>& model_;
    typename Element::Position last_; // m, where the sides stand
};

} // namespace pave::fe

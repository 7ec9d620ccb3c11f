// Matrices of shape times shape: of mass, and of dashpots and springs on the sides of a mesh. Private to fe/.
#pragma once

#include "fe/gauss_rule.h"
#include "fe/model.h"

namespace pave::fe {

// Calls at(position, weight) for the product rule of three points a direction.
template <class Element, class F>
void integrate(F at) {
    int all = 1;
    for (int d = 0; d < Element::dim; ++d) {
        all *= 3;
    }
    for (int q = 0; q < all; ++q) {
        typename Element::Position position;
        double weight = 1.0;
        for (int d = 0, rest = q; d < Element::dim; ++d, rest /= 3) {
            position[d] = three_points[rest % 3].first;
            weight *= three_points[rest % 3].second;
        }
        at(position, weight);
    }
}

// Adds value(i, j), i >= j local unknowns of an element, to a matrix on the pattern of the stiffness.
template <class Element, class F>
void add_to_lower(const Topology<Element>& topology, int e, const F& value, std::vector<double>& to) {
    const auto& places = topology.scatter[static_cast<std::size_t>(e)];
    for (int a = 0, entry = 0; a < Element::dofs; ++a) {
        for (int b = 0; b <= a; ++b, ++entry) {
            if (places[entry] >= 0) {
                to[static_cast<std::size_t>(places[entry])] += value(a, b);
            }
        }
    }
}

// The same of shape shape^T, times a factor for the displacements in each direction.
template <class Element>
void add_inert(const Topology<Element>& topology, int e, const Eigen::Matrix<double, Element::nodes, 1>& shape,
               const Eigen::Matrix<double, Element::dim, 1>& factors, std::vector<double>& to) {
    add_to_lower(
        topology, e,
        [&](int a, int b) {
            const bool coupled = a % Element::dim == b % Element::dim;
            return coupled ? factors[a % Element::dim] * shape[a / Element::dim] * shape[b / Element::dim] : 0.0;
        },
        to);
}

// density [kg/m3]: of the element.
template <class Element>
void add_mass(const Model<Element>& model, int e, double density, std::vector<double>& to) {
    const auto& x = model.coordinates[static_cast<std::size_t>(e)];
    integrate<Element>([&](const typename Element::Position& position, double weight) {
        const double mass = density * weight * Element::point(x, position).weight;
        add_inert<Element>(*model.topology, e, Element::shape(position),
                           Eigen::Matrix<double, Element::dim, 1>::Constant(mass), to);
    });
}

// Calls at(shape, place, area) for points on the outer side of an element, the one away from the axis, and on its
// lower side.
template <class F>
void integrate_outer_side(const Model<AxisymmetricQ8>& model, int e, F at) {
    const auto& x = model.coordinates[static_cast<std::size_t>(e)];
    const double radius = x.row(0).maxCoeff();
    for (const auto& [eta, weight] : three_points) {
        const auto shape = AxisymmetricQ8::shape({1.0, eta});
        const double area = 2.0 * std::numbers::pi * radius * weight * (x(1, 3) - x(1, 0)) / 2.0;
        at(shape, AxisymmetricQ8::Position(radius, x.row(1).dot(shape)), area);
    }
}
template <class F>
void integrate_lower_side(const Model<AxisymmetricQ8>& model, int e, F at) {
    const auto& x = model.coordinates[static_cast<std::size_t>(e)];
    for (const auto& [xi, weight] : three_points) {
        const auto shape = AxisymmetricQ8::shape({xi, 1.0});
        const double radius = x.row(0).dot(shape);
        const double area = 2.0 * std::numbers::pi * radius * weight * (x(0, 1) - x(0, 0)) / 2.0;
        at(shape, AxisymmetricQ8::Position(radius, x.row(1).maxCoeff()), area);
    }
}

} // namespace pave::fe

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

// Calls at(shape, place, area) for points on the side of an element, a box, that is away from the origin along an axis
// of the mesh.
template <class Element, class F>
void integrate_side(const Model<Element>& model, int e, int axis, F at) {
    const auto& x = model.coordinates[static_cast<std::size_t>(e)];
    const Eigen::Matrix<double, Element::dim, 1> last = x.rowwise().maxCoeff();
    const Eigen::Matrix<double, Element::dim, 1> half = (last - x.rowwise().minCoeff()) / 2.0;
    integrate<Element>([&](typename Element::Position position, double weight) {
        // All points across the side are one.
        if (position[axis] != three_points[0].first) {
            return;
        }
        double area = weight / three_points[0].second;
        position[axis] = 1.0;
        const auto shape = Element::shape(position);
        typename Element::Position place = x * shape;
        place[axis] = last[axis];
        for (int d = 0; d < Element::dim; ++d) {
            area *= d == axis ? 1.0 : half[d];
        }
        if constexpr (Element::dim == 2) {
            area *= 2.0 * std::numbers::pi * place[0];
        }
        at(shape, place, area);
    });
}

} // namespace pave::fe

// The ground after a forward run: displacement, strain, stress and stiffness all over the mesh of a load.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace pave::fe {

struct LayerMaterial;
template <class Element>
struct Model;
template <class Element>
struct Solution;

} // namespace pave::fe

namespace pave::pavement {

// Columns belong to the nodes of one element after the other (elements share none: moduli and strains jump between
// layers), in the order of the element's local nodes. x, y, z (down); tension positive; strains carry engineering
// shear. An axisymmetric model is the half plane y = 0, x > 0.
struct Fields {
    int nodes = 0;          // of an element: 8, a quadrilateral, or 20, a hexahedron
    std::vector<int> layer; // of each element; those without end are left out
    Eigen::Matrix3Xd position;
    Eigen::Matrix3Xd displacement;                   // m
    Eigen::Matrix<double, 6, Eigen::Dynamic> strain; // of the load
    Eigen::Matrix<double, 6, Eigen::Dynamic> stress; // of the load [Pa]
    Eigen::VectorXd theta, tau; // of the total stress, initial and of the load [Pa], compression positive
    Eigen::VectorXd horizontal_modulus, vertical_modulus; // E1, E3 at that stress [Pa]
};

// Strain and stress come from the Gauss points of the element, linear in each direction; the rest follows from them.
template <class Element>
Fields fields_of(const fe::Model<Element>& model, const std::vector<fe::LayerMaterial>& layers,
                 const fe::Solution<Element>& solution);

} // namespace pave::pavement

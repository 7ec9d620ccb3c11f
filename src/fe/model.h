// A finite element model: mesh, free unknowns, Gauss points and the pattern of its matrices. Immutable.
#pragma once

#include "fe/axisymmetric_q8.h"
#include "fe/hex20.h"
#include "fe/sparse_solver.h"
#include "mesh/axisymmetric.h"
#include "mesh/solid.h"

#include <memory>
#include <vector>

namespace pave::fe {

// The topology of a mesh: it stays when the nodes move.
template <class Element>
struct Topology {
    static constexpr int lower_entries = Element::dofs * (Element::dofs + 1) / 2;

    int free_unknowns = 0;
    int layers = 0;
    std::vector<std::array<int, Element::dofs>> unknowns; // of each element: free number or -1 (held at zero)
    std::vector<int> layer;                               // of each element
    std::vector<unsigned> endless; // of each element, a bit a direction: without end along it; empty: none is
    bool wall_is_open = false;     // as of the mesh
    bool bottom_is_open = false;
    std::vector<std::vector<int>> coupled; // unknowns that springs couple, as elements couple theirs
    Pattern lower;
    // Place of local entry (i, j), i >= j, row by row, in lower; -1 when i or j is held.
    std::vector<std::array<int, lower_entries>> scatter;
    std::shared_ptr<const CholeskyAnalysis> analysis; // of lower
    std::vector<bool>
        linear; // of each layer: its stiffness is taken not to change along a load path; springs' never do

    int elements() const { return static_cast<int>(layer.size()); }
    // Fills lower, scatter and analysis from the rest.
    void build_pattern();
    // Whether that rest is the same.
    bool is_like(const Topology& other) const;
};

// Springs on the unknowns: the lower triangle of the matrix of a stiffness of 1 [Pa/m].
struct Spring {
    struct Entry {
        int row, column;
        int place; // in Topology::lower
        double value;
    };
    std::vector<Entry> entries;

    // y += factor * S x
    void add_product(const double* x, double factor, double* y) const {
        for (const Entry& entry : entries) {
            y[entry.row] += factor * entry.value * x[entry.column];
            if (entry.row != entry.column) {
                y[entry.column] += factor * entry.value * x[entry.row];
            }
        }
    }
};

// The parts of a model besides the bonded section, in the order of Model::springs.
struct Springs {
    // Layers that may slip on the layer below: the horizontal displacements of the two faces are unknowns of their own,
    // tied by the integral of |difference|^2 over the interface; the vertical ones are shared.
    std::vector<int> slipping_layers{};
    // Axisymmetric: under a plate of this radius on the surface [m] (0: none), the integral of (w - mean w)^2.
    double plate_radius = 0.0;

    bool operator==(const Springs&) const = default;
};

template <class Element>
struct Model {
    std::shared_ptr<const Topology<Element>> topology;
    std::vector<typename Element::Coordinates> coordinates; // of each element
    std::vector<typename Element::Point> points;            // Element::gauss of each element
    std::vector<double> depth;                              // of each Gauss point [m]
    std::vector<Spring> springs;

    int elements() const { return topology->elements(); }
    int free_unknowns() const { return topology->free_unknowns; }

    typename Element::Vector gather(int element, const double* u) const {
        typename Element::Vector v;
        for (int i = 0; i < Element::dofs; ++i) {
            const int k = topology->unknowns[element][i];
            v[i] = k >= 0 ? u[k] : 0.0;
        }
        return v;
    }
    void scatter_add(int element, const typename Element::Vector& v, double* u) const {
        for (int i = 0; i < Element::dofs; ++i) {
            if (const int k = topology->unknowns[element][i]; k >= 0) {
                u[k] += v[i];
            }
        }
    }
};

// x, y, z of a Gauss point; r for x in an axisymmetric model [m].
template <class Element>
Eigen::Vector3d position_of(const Model<Element>& model, int element, int gauss);

// Strain at a Gauss point of displacement fields, a column a field.
template <class Element>
Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> strains(const Model<Element>& model, int point,
                                                              const Eigen::MatrixXd& fields) {
    Eigen::Matrix<double, Element::voigt, Eigen::Dynamic> strain(Element::voigt, fields.cols());
    for (Eigen::Index i = 0; i < fields.cols(); ++i) {
        strain.col(i) = Element::strain(model.points[static_cast<std::size_t>(point)],
                                        model.gather(point / Element::gauss, fields.col(i).data()));
    }
    return strain;
}

// u_r = 0 on the axis and the smooth wall, u = 0 on the rough rigid floor unless they are open; of an endless mesh u =
// 0 at infinity, where displacements of its last elements fall off as a/x + b/x^2 with the distance x from the origin:
// mapped infinite elements (O. C. Zienkiewicz, C. Emson and P. Bettess, "A novel boundary infinite element", 1983).
// linear: of each layer, whether it is linear elastic. It is used to order the unknowns; a run may have it otherwise.
Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const std::vector<bool>& linear,
                                 const Springs& springs = {});
// u_x = 0 on x = 0 and on the smooth wall, u_y likewise, u = 0 on the floor, unless they are open.
Model<Hex20> make_model(const mesh::SolidMesh& mesh, const std::vector<bool>& linear, const Springs& springs = {});

// A mesh of the same structure as that of `like`, with which it shares the topology; springs: likewise.
Model<AxisymmetricQ8> make_model(const mesh::AxisymmetricMesh& mesh, const Model<AxisymmetricQ8>& like,
                                 const Springs& springs = {});
Model<Hex20> make_model(const mesh::SolidMesh& mesh, const Model<Hex20>& like, const Springs& springs = {});

} // namespace pave::fe

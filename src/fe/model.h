// A finite element model: mesh, free unknowns, Gauss points and the pattern of its matrices. Immutable.
#pragma once

#include "fe/axisymmetric_q8.h"
#include "mesh/axisymmetric.h"

#include <vector>

namespace pave::fe {

// Lower triangle (or full matrix) of a square sparse matrix by columns, rows sorted.
struct Pattern {
    int size = 0;
    std::vector<int> column_start; // size + 1
    std::vector<int> row;
};

template <class Element>
struct Model {
    static constexpr int lower_entries = Element::dofs * (Element::dofs + 1) / 2;

    int free_unknowns = 0;
    int layers = 0;
    std::vector<typename Element::Coordinates> coordinates; // of each element
    std::vector<std::array<int, Element::dofs>> unknowns;   // of each element: free number or -1 (held at zero)
    std::vector<int> layer;                                 // of each element
    std::vector<typename Element::Point> points;            // Element::gauss of each element
    std::vector<double> depth;                              // of each Gauss point [m]
    Pattern lower;
    // Place of local entry (i, j), i >= j, row by row, in lower; -1 when i or j is held.
    std::vector<std::array<int, lower_entries>> scatter;

    int elements() const { return static_cast<int>(layer.size()); }

    typename Element::Vector gather(int element, const double* u) const {
        typename Element::Vector v;
        for (int i = 0; i < Element::dofs; ++i) {
            const int k = unknowns[element][i];
            v[i] = k >= 0 ? u[k] : 0.0;
        }
        return v;
    }
    void scatter_add(int element, const typename Element::Vector& v, double* u) const {
        for (int i = 0; i < Element::dofs; ++i) {
            if (const int k = unknowns[element][i]; k >= 0) {
                u[k] += v[i];
            }
        }
    }
};

// u_r = 0 on the axis and on the smooth wall, u = 0 on the floor (rigid, rough).
Model<AxisymmetricQ8> axisymmetric_model(const mesh::AxisymmetricMesh& mesh);

// Fills lower and scatter from unknowns.
template <class Element>
void build_pattern(Model<Element>& model);

} // namespace pave::fe

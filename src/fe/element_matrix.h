// The matrix of an element, compiled once: with all its numbers known when it is compiled, it is dear to compile.
#pragma once

#include "fe/axisymmetric_q8.h"
#include "fe/hex20.h"

namespace pave::fe {

template <class Element>
using ElementMatrix = Eigen::Matrix<double, Element::dofs, Element::dofs>;

// weight B(left)' d B(right) at a Gauss point, B the strain operator: with left = right the stiffness of that point.
template <class Element>
ElementMatrix<Element> point_matrix(const typename Element::Point& left, const mechanics::Stiffness<Element::voigt>& d,
                                    const typename Element::Point& right, double weight);

} // namespace pave::fe

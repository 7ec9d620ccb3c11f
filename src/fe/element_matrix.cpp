#include "fe/element_matrix.h"

namespace pave::fe {

template <class Element>
ElementMatrix<Element> point_matrix(const typename Element::Point& left, const mechanics::Stiffness<Element::voigt>& d,
                                    const typename Element::Point& right, double weight) {
    const typename Element::Operator db = weight * (d * Element::strain_operator(right));
    return Element::strain_operator(left).transpose() * db;
}

template ElementMatrix<AxisymmetricQ8> point_matrix<AxisymmetricQ8>(const AxisymmetricQ8::Point&,
                                                                    const mechanics::Stiffness<4>&,
                                                                    const AxisymmetricQ8::Point&, double);
template ElementMatrix<Hex20> point_matrix<Hex20>(const Hex20::Point&, const mechanics::Stiffness<6>&,
                                                  const Hex20::Point&, double);

} // namespace pave::fe

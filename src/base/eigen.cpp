#include "base/eigen.h"

namespace Eigen {

template class ColPivHouseholderQR<MatrixXd>;
template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
template class FullPivLU<MatrixXd>;
template void FullPivLU<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
template class HouseholderQR<MatrixXd>;
template void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
template class JacobiSVD<MatrixXd>;
template class LDLT<MatrixXd>;
template LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
template class LLT<MatrixXd>;
template LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
template class PartialPivLU<MatrixXd>;
template class SelfAdjointEigenSolver<MatrixXd>;
template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, int);

#if !EIGEN_VERSION_AT_LEAST(3, 4, 90)
namespace internal {

template struct gebp_kernel<double, double, Index, Right<ColMajor>, Blocking::mr, Blocking::nr, false, false>;
template struct gemm_pack_lhs<double, Index, Read<ColMajor>, Blocking::mr, Blocking::LhsProgress,
                              Blocking::LhsPacket4Packing, ColMajor>;
template struct gemm_pack_lhs<double, Index, Read<RowMajor>, Blocking::mr, Blocking::LhsProgress,
                              Blocking::LhsPacket4Packing, RowMajor>;
template struct gemm_pack_rhs<double, Index, Read<ColMajor>, Blocking::nr, ColMajor>;
template struct gemm_pack_rhs<double, Index, Read<RowMajor>, Blocking::nr, RowMajor>;
template struct general_matrix_vector_product<Index, double, Read<ColMajor>, ColMajor, false, double, Read<RowMajor>,
                                              false>;
template struct general_matrix_vector_product<Index, double, Read<ColMajor>, ColMajor, false, double, Read<ColMajor>,
                                              false>;
template struct general_matrix_vector_product<Index, double, Read<RowMajor>, RowMajor, false, double, Read<ColMajor>,
                                              false>;
template struct general_matrix_vector_product<Index, double, Read<RowMajor>, RowMajor, false, double, Read<RowMajor>,
                                              false>;
template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;
template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;
template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;

} // namespace internal
#endif

} // namespace Eigen

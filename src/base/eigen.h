// Eigen's decompositions and products of real matrices of any size, compiled once (eigen.cpp) and not in every source
// that uses them: they are most of what such a source takes to compile. Part of the precompiled headers; no source need
// include it, and one that does without compiles them itself.
//
// They must be called with matrices, not expressions: `LLT<MatrixXd>(MatrixXd(a + b))`.
#pragma once

#include <Eigen/Dense>

#ifndef PAVE_COMPILED_ELSEWHERE // eigen.cpp compiles what the others are told of
#define PAVE_COMPILED_ELSEWHERE extern
#endif

namespace Eigen {

PAVE_COMPILED_ELSEWHERE template class ColPivHouseholderQR<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
PAVE_COMPILED_ELSEWHERE template void ColPivHouseholderQR<MatrixXd>::_solve_impl(const MatrixXd&, MatrixXd&) const;
PAVE_COMPILED_ELSEWHERE template class FullPivLU<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template void FullPivLU<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
PAVE_COMPILED_ELSEWHERE template class HouseholderQR<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template void HouseholderQR<MatrixXd>::_solve_impl(const VectorXd&, VectorXd&) const;
PAVE_COMPILED_ELSEWHERE template class JacobiSVD<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template class LDLT<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template LDLT<MatrixXd>& LDLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
PAVE_COMPILED_ELSEWHERE template class LLT<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
PAVE_COMPILED_ELSEWHERE template class PartialPivLU<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template class SelfAdjointEigenSolver<MatrixXd>;
PAVE_COMPILED_ELSEWHERE template SelfAdjointEigenSolver<MatrixXd>&
SelfAdjointEigenSolver<MatrixXd>::compute(const EigenBase<MatrixXd>&, int);

#if !EIGEN_VERSION_AT_LEAST(3, 4, 90) // what products are made of, which is Eigen's own business
namespace internal {

using Blocking = gebp_traits<double, double>;
template <int Order>
using Right = blas_data_mapper<double, Index, Order, Unaligned, 1>;
template <int Order>
using Read = const_blas_data_mapper<double, Index, Order>;

PAVE_COMPILED_ELSEWHERE template struct gebp_kernel<double, double, Index, Right<ColMajor>, Blocking::mr, Blocking::nr,
                                                    false, false>;
PAVE_COMPILED_ELSEWHERE template struct gemm_pack_lhs<double, Index, Read<ColMajor>, Blocking::mr,
                                                      Blocking::LhsProgress, Blocking::LhsPacket4Packing, ColMajor>;
PAVE_COMPILED_ELSEWHERE template struct gemm_pack_lhs<double, Index, Read<RowMajor>, Blocking::mr,
                                                      Blocking::LhsProgress, Blocking::LhsPacket4Packing, RowMajor>;
PAVE_COMPILED_ELSEWHERE template struct gemm_pack_rhs<double, Index, Read<ColMajor>, Blocking::nr, ColMajor>;
PAVE_COMPILED_ELSEWHERE template struct gemm_pack_rhs<double, Index, Read<RowMajor>, Blocking::nr, RowMajor>;
PAVE_COMPILED_ELSEWHERE template struct general_matrix_vector_product<Index, double, Read<ColMajor>, ColMajor, false,
                                                                      double, Read<RowMajor>, false>;
PAVE_COMPILED_ELSEWHERE template struct general_matrix_vector_product<Index, double, Read<ColMajor>, ColMajor, false,
                                                                      double, Read<ColMajor>, false>;
PAVE_COMPILED_ELSEWHERE template struct general_matrix_vector_product<Index, double, Read<RowMajor>, RowMajor, false,
                                                                      double, Read<ColMajor>, false>;
PAVE_COMPILED_ELSEWHERE template struct general_matrix_vector_product<Index, double, Read<RowMajor>, RowMajor, false,
                                                                      double, Read<RowMajor>, false>;
PAVE_COMPILED_ELSEWHERE template struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor,
                                                                ColMajor, 1>;
PAVE_COMPILED_ELSEWHERE template struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor,
                                                                ColMajor, 1>;
PAVE_COMPILED_ELSEWHERE template struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false,
                                                                ColMajor>;
PAVE_COMPILED_ELSEWHERE template struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false,
                                                                RowMajor>;

} // namespace internal
#endif

} // namespace Eigen

#pragma once

#include <Eigen/Dense>

/// Eigen's decompositions of matrices of doubles, compiled once in dense.cpp: instantiating one anew takes the compiler
/// longer than most files take as a whole.
namespace Eigen {

extern template class JacobiSVD<MatrixXd>;
extern template class PartialPivLU<MatrixXd>;
extern template class HouseholderQR<MatrixXd>;
extern template class ColPivHouseholderQR<MatrixXd>;
extern template class CompleteOrthogonalDecomposition<MatrixXd>;
extern template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute<MatrixXd>(
    const EigenBase<MatrixXd>&, int);
extern template LLT<MatrixXd>& LLT<MatrixXd>::compute<MatrixXd>(const EigenBase<MatrixXd>&);
extern template void LLT<MatrixXd>::_solve_impl_transposed<true, MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
extern template void LLT<MatrixXd>::_solve_impl_transposed<true, VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
extern template LDLT<MatrixXd>& LDLT<MatrixXd>::compute<MatrixXd>(const EigenBase<MatrixXd>&);
extern template void LDLT<MatrixXd>::_solve_impl_transposed<true, MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
extern template void LDLT<MatrixXd>::_solve_impl_transposed<true, VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
extern template void HouseholderQR<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
extern template void HouseholderQR<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
extern template void ColPivHouseholderQR<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
extern template void ColPivHouseholderQR<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
extern template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&,
                                                                                                MatrixXd&) const;
extern template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&,
                                                                                                VectorXd&) const;
extern template Index internal::llt_inplace<double, Lower>::blocked<MatrixXd>(MatrixXd&);

}  // namespace Eigen

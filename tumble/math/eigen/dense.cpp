#include "tumble/math/eigen/dense.hpp"

namespace Eigen {

template class JacobiSVD<MatrixXd>;
template class PartialPivLU<MatrixXd>;
template class HouseholderQR<MatrixXd>;
template class ColPivHouseholderQR<MatrixXd>;
template class CompleteOrthogonalDecomposition<MatrixXd>;
template SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute<MatrixXd>(
    const EigenBase<MatrixXd>&, int);
template LLT<MatrixXd>& LLT<MatrixXd>::compute<MatrixXd>(const EigenBase<MatrixXd>&);
template void LLT<MatrixXd>::_solve_impl_transposed<true, MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
template void LLT<MatrixXd>::_solve_impl_transposed<true, VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
template LDLT<MatrixXd>& LDLT<MatrixXd>::compute<MatrixXd>(const EigenBase<MatrixXd>&);
template void LDLT<MatrixXd>::_solve_impl_transposed<true, MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
template void LDLT<MatrixXd>::_solve_impl_transposed<true, VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
template void HouseholderQR<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
template void HouseholderQR<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
template void ColPivHouseholderQR<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&, MatrixXd&) const;
template void ColPivHouseholderQR<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&, VectorXd&) const;
template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl<MatrixXd, MatrixXd>(const MatrixXd&,
                                                                                         MatrixXd&) const;
template void CompleteOrthogonalDecomposition<MatrixXd>::_solve_impl<VectorXd, VectorXd>(const VectorXd&,
                                                                                         VectorXd&) const;
template Index internal::llt_inplace<double, Lower>::blocked<MatrixXd>(MatrixXd&);

}  // namespace Eigen

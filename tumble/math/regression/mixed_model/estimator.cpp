#include "tumble/math/regression/mixed_model/estimator.hpp"

#include <Eigen/Dense>
#include <limits>

#include "tumble/units/error.hpp"

namespace tumble::mixed_model {

Estimator estimator(const MatrixXd& design, const MatrixXd& covariance) {
  Estimator out{{}, Eigen::LLT<MatrixXd>(covariance), {}, 1.0};
  if (out.root.info() != Eigen::Success) throw Error(Error::Kind::internal, "mixed model: covariance not positive");
  const Index p = design.cols();
  MatrixXd white = out.root.matrixL().solve(design);
  const VectorXd scale = white.colwise().norm();
  white = white * scale.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<MatrixXd> qr(white);
  const MatrixXd q = qr.householderQ() * MatrixXd::Identity(white.rows(), p);
  const MatrixXd r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const VectorXd s = Eigen::JacobiSVD<MatrixXd>(r).singularValues();
  out.inner = out.root.matrixU().solve(q);
  out.gain = scale.cwiseInverse().asDiagonal() * r.triangularView<Eigen::Upper>().solve(out.inner.transpose());
  out.condition = s[p - 1] > 0.0 ? s[0] / s[p - 1] : std::numeric_limits<double>::infinity();
  return out;
}

}  // namespace tumble::mixed_model

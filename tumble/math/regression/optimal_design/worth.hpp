#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "tumble/math/regression/optimal_design.hpp"

/// Criteria of designs, fast enough to try many designs.
namespace tumble::optimal_design {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A visit to a point, its effort in quanta.
struct Visit {
  std::size_t point;
  long quanta;
};
using Visits = std::vector<Visit>;

/// Criterion of a design, and the matrices that show how one more visit would change it.
struct State {
  double value = std::numeric_limits<double>::infinity();
  MatrixXd covariance;
  MatrixXd nothing;  ///< D: inverse of the block of no interest; empty without
};

/// A problem in scaled parameters. It must outlive this.
class Worth {
 public:
  explicit Worth(const DesignProblem& problem);

  State state(const Visits& visits) const;
  /// The criterion of the visits [1].
  double value(const Visits& visits) const { return state(visits).value; }
  /// Square root of the information of a visit.
  MatrixXd root(std::size_t point, long quanta) const;
  /// Decrease of the criterion [1] by a visit whose information is u u'; u [p x k].
  double gain(const State& state, const MatrixXd& u) const;
  /// Parameters of interest.
  std::size_t interest() const { return problem_.parameters - nuisance_.size(); }

 private:
  void scale();
  State state(MatrixXd information) const;

  const DesignProblem& problem_;
  std::vector<MatrixXd> rows_;         ///< X in scaled parameters
  std::vector<MatrixXd> disturbance_;  ///< N N'
  MatrixXd prior_;                     ///< with the ridge
  VectorXd weights_;                   ///< in scaled parameters
  std::vector<Index> nuisance_;
};

}  // namespace tumble::optimal_design

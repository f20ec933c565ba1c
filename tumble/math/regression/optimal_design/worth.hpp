#pragma once

#include <limits>
#include <vector>

#include "tumble/math/regression/optimal_design.hpp"

/// What designs are worth, fast enough to try many.
namespace tumble::optimal_design {

/// A visit to a point, its effort in quanta.
struct Visit {
  std::size_t point;
  long quanta;
};
using Visits = std::vector<Visit>;

/// What a design is worth, and what is needed to see what one more visit would change.
struct State {
  double value = std::numeric_limits<double>::infinity();
  Matrix covariance;
  Matrix nothing;  ///< D: inverse of the block of no interest; empty without
};

/// A problem in scaled parameters. It must outlive this.
class Worth {
 public:
  explicit Worth(const DesignProblem& problem);

  State state(const Visits& visits) const;
  /// The criterion of the visits [1].
  double value(const Visits& visits) const { return state(visits).value; }
  /// Square root of the information of a visit.
  Matrix root(std::size_t point, long quanta) const;
  /// Decrease of the criterion [1] by a visit whose information is u u'; u [p x k].
  double gain(const State& state, const Matrix& u) const;
  /// Parameters of interest.
  std::size_t interest() const { return problem_.parameters - nuisance_.size(); }

 private:
  void scale();
  State state(const Matrix& information) const;

  const DesignProblem& problem_;
  std::vector<Matrix> columns_;      ///< X' in scaled parameters
  std::vector<Matrix> disturbance_;  ///< N N'
  Matrix prior_;                     ///< with the ridge
  std::vector<double> weights_;      ///< in scaled parameters
  std::vector<std::size_t> nuisance_;
};

}  // namespace tumble::optimal_design

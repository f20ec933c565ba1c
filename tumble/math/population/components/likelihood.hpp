#pragma once

#include <memory>
#include <vector>

#include "tumble/math/population/components.hpp"

/// The restricted likelihood of many results at given variances: exact and dense for few, sparse for many.
namespace tumble::components {

/// The model at given variances [u^2], one a factor, then "repeat" (8.7).
struct AtVariances {
  double log_likelihood = 0.0, mean = 0.0, mean_variance = 0.0;
  std::vector<double> score;    ///< derivative of the log likelihood with each variance
  Matrix information;           ///< expected where dense, average where sparse; of the variances
  std::vector<double> weights;  ///< V^-1 1 [n]
};

/// Known quantities of the results: all that the likelihood needs except the variances.
struct Model {
  std::vector<double> values;                    ///< [n]
  std::vector<double> own;                       ///< [n] u^2
  Matrix shared;                                 ///< [n x k]
  std::vector<std::vector<std::size_t>> levels;  ///< of each factor, from 0
  std::vector<std::size_t> counts;               ///< of levels
};
Model model_of(const ManyResults& results);

/// From this many results the sparse form is used [1].
inline constexpr std::size_t many = 500;

/// Variances [u^2]. Work grows as n^3.
AtVariances dense_at(const Model& model, const std::vector<double>& variances);

/// Work grows as n: V = W^-1 + U U', of which U has one entry a factor and result, is inverted by Woodbury's identity
/// with the sparse factor of I + U' W U.
class SparseLikelihood {
 public:
  /// `scale` [u^2]: a variance far below it counts as zero.
  SparseLikelihood(const Model& model, double scale);
  ~SparseLikelihood();
  SparseLikelihood(SparseLikelihood&&) noexcept;

  /// Variances [u^2], one a factor, then "repeat".
  AtVariances at(const std::vector<double>& variances);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace tumble::components

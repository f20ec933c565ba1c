#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/math/regression/mixed_model.hpp"

/// Parameters as functions of quantities that were fitted in groups, with covariance and budget from the groups'.
namespace tumble::dtg_centrifuge {

/// Quantities of one fit; different groups share no noise.
struct Group {
  std::size_t size = 0;
  std::vector<SourceCovariance> sources;
  /// Degrees of freedom of the variance of a linear function of the quantities.
  std::function<double(const std::vector<double>& function)> degrees_of_freedom;
};

class Ledger {
 public:
  /// Returns the number of the group.
  std::size_t add(Group group);

  /// Derivatives of a parameter by the quantities of some groups.
  using Gradient = std::vector<std::pair<std::size_t, std::vector<double>>>;

  void add(Parameter parameter, Gradient gradient);

  /// Variance [SI^2] of a function of the quantities, all sources together, and its degrees of freedom [1].
  double variance(const Gradient& gradient) const;
  double degrees_of_freedom(const Gradient& gradient) const;

  /// Parameters, covariance and budget; sources of one name are one line.
  void settle(Estimate& estimate) const;

 private:
  std::vector<Group> groups_;
  std::vector<Parameter> parameters_;
  std::vector<Gradient> gradients_;
};

}  // namespace tumble::dtg_centrifuge

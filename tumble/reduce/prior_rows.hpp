#pragma once

#include <vector>

#include "tumble/core/estimate.hpp"

namespace tumble::prior_rows {

/// Whether the uncertainty of a parameter is that of a normal distribution: value and sd are finite, and its interval
/// is symmetric.
bool is_normal(const Estimate& estimate, std::size_t i);

/// A parameter of a result as a sum of those of a population.
struct Row {
  bool known = false;           ///< it is the population's parameter of its name, plus a sum of others
  std::vector<double> weights;  ///< [p] of the population's parameters; without `known` of the terms contained alone
};

/// A parameter of a result as a weighted sum of parameters of a population. Terms that it contains and the population
/// does not have must be contained in the population's parameter too.
Row row_of(const Parameter& parameter, const std::vector<Parameter>& population);

/// Terms contained in a parameter that have other names than these, as one text: "0.75 x second_order_coefficient".
std::string unresolved(const Parameter& parameter, const std::vector<std::string>& names);

}  // namespace tumble::prior_rows

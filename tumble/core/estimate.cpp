#include "tumble/core/estimate.hpp"

#include <cmath>

namespace tumble {

double Contribution::variance(std::size_t parameter) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < factor.columns; ++c) sum += factor(parameter, c) * factor(parameter, c);
  return sum;
}

double standard_uncertainty(const Estimate& estimate, std::size_t index) {
  return std::sqrt(estimate.covariance(index, index));
}

const Parameter* find_parameter(const Estimate& estimate, std::string_view name) {
  for (const Parameter& parameter : estimate.parameters)
    if (parameter.name == name) return &parameter;
  return nullptr;
}

const Table* find_table(const Estimate& estimate, std::string_view name) {
  for (const Table& table : estimate.tables)
    if (table.name == name) return &table;
  return nullptr;
}

}  // namespace tumble

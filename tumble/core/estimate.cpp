#include "tumble/core/estimate.hpp"

#include <cmath>

namespace tumble {

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

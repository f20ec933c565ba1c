#include "tumble/core/estimate.hpp"

#include <algorithm>
#include <cmath>

namespace tumble {
namespace {

const FindingValue* find_value(const Finding& finding, std::string_view name) {
  const auto value = std::ranges::find(finding.values, name, &FindingValue::name);
  return value == finding.values.end() ? nullptr : &*value;
}

}  // namespace

double Contribution::variance(std::size_t parameter) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < factor.columns; ++c) sum += factor(parameter, c) * factor(parameter, c);
  return sum;
}

double standard_uncertainty(const Estimate& estimate, std::size_t index) {
  return std::sqrt(estimate.covariance(index, index));
}

const Estimate& judged(const Estimate& estimate) {
  const auto& prior = estimate.prior;
  return prior && prior->verdicts && prior->with_prior ? *prior->with_prior : estimate;
}

const Parameter* find_parameter(const Estimate& estimate, std::string_view name) {
  for (const Parameter& parameter : estimate.parameters)
    if (parameter.name == name) return &parameter;
  return nullptr;
}

std::optional<UpperLimit> find_upper_limit(const Estimate& estimate, std::string_view name) {
  if (find_parameter(estimate, name) != nullptr) return {};
  for (const Finding& finding : estimate.findings) {
    if (std::ranges::find(finding.hidden, name, &HiddenParameter::name) == finding.hidden.end()) continue;
    const auto* limit = find_value(finding, "limit");
    if (limit != nullptr && std::holds_alternative<double>(limit->value))
      return UpperLimit{std::get<double>(limit->value), limit->unit};
  }
  return {};
}

const Table* find_table(const Estimate& estimate, std::string_view name) {
  for (const Table& table : estimate.tables)
    if (table.name == name) return &table;
  return nullptr;
}

}  // namespace tumble

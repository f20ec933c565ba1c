#include "tumble/report/parameter_rows.hpp"

#include <cmath>

#include "tumble/report/figure/ticks.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/report.hpp"
#include "tumble/report/rounding.hpp"

namespace tumble {
namespace {

void write_value(double value, double sd, ParameterRow& row) {
  const auto rounding = rounding_for(value, sd);
  row.rounded = rounding.significant;
  row.exponent = rounding.significant ? rounding.exponent : 0;
  if (row.exponent != 0) row.power = "× " + figure::power_of_ten(row.exponent);
  row.text = with_uncertainty(value, sd);
  if (rounding.significant) {
    row.value = split_at_point(mantissa(value, rounding));
    row.sd = split_at_point(mantissa(sd, rounding));
    return;
  }
  const auto halves = value_and_sd(value, sd);
  row.value = split_at_point(halves.value);
  row.sd = split_at_point(halves.sd);
}

void write_interval(const Estimate& estimate, std::size_t i, double value, double sd, ParameterRow& row) {
  const auto interval = interval95(estimate, i);
  const auto& unit = estimate.parameters[i].unit;
  const double lower = unit.from_si(interval.lower), upper = unit.from_si(interval.upper);
  if (std::isnan(lower)) return;
  const auto rounding = rounding_for(value, sd);
  row.lower = split_at_point(mantissa(lower, rounding));
  row.upper = split_at_point(mantissa(upper, rounding));
}

}  // namespace

SplitNumber split_at_point(const std::string& number) {
  const auto point = number.find('.');
  if (point == std::string::npos) return {number, ""};
  return {number.substr(0, point), number.substr(point)};
}

ParameterRow parameter_row(const Estimate& estimate, std::size_t index) {
  const auto& parameter = estimate.parameters[index];
  const auto [value, sd] = shown(estimate, index);
  ParameterRow row;
  row.name = parameter.name;
  row.readable = readable_name(parameter.name);
  row.symbol = parameter.symbol;
  row.description = parameter.description;
  row.unit = parameter.unit.text();
  write_value(value, sd, row);
  write_interval(estimate, index, value, sd, row);
  const double freedom = parameter.degrees_of_freedom;
  row.degrees_of_freedom = std::isinf(freedom) ? "∞" : general(freedom, 3);
  return row;
}

std::vector<ParameterRow> parameter_rows(const Estimate& estimate) {
  std::vector<ParameterRow> rows;
  for (std::size_t i = 0; i < estimate.parameters.size(); ++i) rows.push_back(parameter_row(estimate, i));
  return rows;
}

}  // namespace tumble

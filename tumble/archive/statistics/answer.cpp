#include "tumble/archive/statistics/answer.hpp"

#include <cmath>

#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/core/budget.hpp"
#include "tumble/math/square.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::statistics {

namespace {

constexpr double normal_quantile_95 = 1.959963984540054;  ///< two-sided

}  // namespace

Estimate answer_of(const std::string& name, const std::string& title, const ArchivedSelection& what) {
  Estimate estimate;
  estimate.method = name;
  estimate.title = title;
  estimate.instrument_model = what.unit.serial.empty() ? what.model : what.unit.model;
  estimate.instrument_serial = what.unit.serial;
  estimate.provenance.settings["parameter"] = what.parameter;
  return estimate;
}

void state(Estimate& estimate, const std::vector<Stated>& numbers) {
  std::vector<double> variances;
  for (const auto& one : numbers) {
    Parameter parameter;
    parameter.name = one.name, parameter.symbol = one.name, parameter.description = one.description;
    parameter.unit = one.unit, parameter.value = one.value;
    parameter.lower = one.lower, parameter.upper = one.upper;
    estimate.parameters.push_back(parameter);
    const double half = 0.5 * (one.upper - one.lower) / normal_quantile_95;
    const double sd = std::isfinite(one.sd) ? one.sd : half;
    variances.push_back(std::isfinite(sd) ? square(sd) : 0.0);
  }
  estimate.budget = {independent_errors("scatter of the results", variances)};
  estimate.covariance = covariance_of(estimate.budget, numbers.size());
}

Table::Column column(const std::string& name, const Unit& unit) { return {name, unit}; }

Curve curve_over_time(const std::string& name, const std::string& figure, std::int64_t first_day,
                      const std::string& quantity, const Unit& unit) {
  Curve curve;
  curve.name = name, curve.figure = figure;
  curve.x = {"time since " + date_of(first_day), Unit::parse("day"), {}};
  curve.y = {quantity, unit, {}};
  return curve;
}

void add_point(Curve& curve, std::int64_t first_day, double moment, double value) {
  curve.x.values.push_back(moment - static_cast<double>(first_day) * 24.0 * hour);
  curve.y.values.push_back(value);
}

void add_band(Curve& curve, double lower, double upper) {
  curve.lower.push_back(lower);
  curve.upper.push_back(upper);
}

Table links_table(const Unit& unit) {
  Table links{"links", "units and results by their points in the figures", {}, {}, true};
  links.columns = {column("curve"), column("time", Unit::parse("day")), column("value", unit), column("unit"),
                   column("result")};
  return links;
}

void add_link(const Curve& curve, const std::string& unit, std::int64_t result, Table& links) {
  links.rows.push_back({curve.name, curve.x.values.back(), curve.y.values.back(), unit,
                        result == 0 ? std::string() : std::to_string(result)});
}

}  // namespace tumble::statistics

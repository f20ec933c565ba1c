#include "tumble/archive/statistics/answer.hpp"

#include <cmath>

#include "tumble/archive/statistics/occasions.hpp"
#include "tumble/core/budget.hpp"
#include "tumble/core/columns.hpp"
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

Curve curve_over_time(const std::string& name, const std::string& figure, std::int64_t first_day,
                      const std::string& quantity, const Unit& unit) {
  return {.name = name,
          .figure = figure,
          .x = {"time since " + date_of(first_day), Unit::parse("day")},
          .y = {quantity, unit}};
}

double since(std::int64_t first_day, double moment) { return moment - static_cast<double>(first_day) * 24.0 * hour; }

Table links_table(const std::vector<Link>& links, const Unit& unit) {
  const auto result = [](const Link& link) { return link.result == 0 ? std::string() : std::to_string(link.result); };
  return for_programs(tabulate("links", "units and results by their points in the figures", links,
                               {{"curve", &Link::curve},
                                {"time", "day", &Link::time},
                                {"value", unit, &Link::value},
                                {"unit", &Link::unit},
                                {"result", result}}));
}

Link link_of(const Curve& curve, const std::string& unit, std::int64_t result) {
  return {curve.name, curve.x.values.back(), curve.y.values.back(), unit, result};
}

}  // namespace tumble::statistics

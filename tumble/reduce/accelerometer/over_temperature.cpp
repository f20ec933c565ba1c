#include "tumble/reduce/accelerometer/over_temperature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tumble/reduce/output_model.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::accelerometer {
namespace {

constexpr double zero_celsius = 273.15;  ///< [K]
constexpr double beyond_gravity = 1.05;  ///< of the positions: gravity is below 9.84 m/s^2, and the axis may shake

/// c [T^j] in [degC^j] between the temperatures of a test, times `size` on both sides of zero where it multiplies y.
void add_power(TermRanges& ranges, const std::string& name, int power_of_t, bool by_output, double low, double high) {
  const Regressor warm = power(from(Input::temperature, zero_celsius), power_of_t);
  ranges.terms.push_back({name, "", "", "", by_output ? -warm * Input::specific_force_x : warm});
  const double a = std::pow(low - zero_celsius, power_of_t), b = std::pow(high - zero_celsius, power_of_t);
  const double size = beyond_gravity * standard_gravity * std::max(std::abs(a), std::abs(b));
  const bool crosses = power_of_t == 2 && low < zero_celsius && high > zero_celsius;
  ranges.least.push_back(by_output ? -size : crosses ? 0.0 : std::min(a, b));
  ranges.greatest.push_back(by_output ? size : std::max(a, b));
}

/// Terms that stay in: neither is in (3.4) as the source compensates, and nothing says what acts across the axis.
/// Specific force is anywhere within 1 g.
void add_remaining(const Estimate& estimate, OutputModel& model) {
  const double g = standard_gravity;
  for (const auto& [name, regressor, size] :
       {std::tuple{"second_order_coefficient", power(Input::specific_force_x, 2), g * g},
        std::tuple{"misalignment", Regressor(Input::specific_force_y), g}})
    if (const auto parameter = parameter_index(estimate, name))
      model.terms.push_back({.term = name,
                             .parameter = parameter,
                             .regressor = regressor.products(),
                             .least = -size,
                             .greatest = size,
                             .remains = true});
}

}  // namespace

OutputModel over_temperature(const Estimate& estimate, double low, double high) {
  TermRanges ranges;
  if (!parameter_index(estimate, "b_0")) add_power(ranges, "bias", 0, false, low, high);
  if (!parameter_index(estimate, "c_0")) add_power(ranges, "scale_factor_error", 0, true, low, high);
  for (int j = 0; j < 3; ++j) {
    add_power(ranges, fmt::format("b_{}", j), j, false, low, high);
    add_power(ranges, fmt::format("c_{}", j), j, true, low, high);
  }
  OutputModel model = output_model(estimate, "accelerometer", Input::specific_force_x, "g", ranges);
  model.by_output = true;
  add_remaining(estimate, model);
  const double most = beyond_gravity * standard_gravity;
  model.covered = {{{{Input::specific_force_x, 1.0}}, -most, most}, {{{Input::temperature, 1.0}}, low, high}};
  model.in_region = true;
  return model;
}

}  // namespace tumble::accelerometer

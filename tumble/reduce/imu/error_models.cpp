#include "tumble/reduce/imu/error_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tumble/reduce/output_model.hpp"

namespace tumble::imu {
namespace {

/// A sample at the edge of the test shows noise: of MEMS gyros 0.1 deg/s, of MEMS accelerometers 20 mg.
const double rate_noise = si(0.1, "deg/s"), force_noise = si(0.02, "g");

Input first_of(Kind kind) { return kind == Kind::gyro ? Input::rate_x : Input::specific_force_x; }

std::vector<Term> terms_of(const std::string& role) {
  const Model& model = find_model("imu");
  const auto outputs = model.outputs(defaults(model.constants()));
  return std::ranges::find(outputs, role, &Output::channel)->terms;
}

OutputModel model_of(const Estimate& estimate, const RangeOf& range, Kind kind, std::size_t axis) {
  const std::string role = role_of(kind, axis);
  const bool counted = parameter_index(estimate, role + "_scale_factor").has_value();
  TermRanges ranges{terms_of(role), {}, {}};
  std::erase_if(ranges.terms, [&](const Term& term) {
    return !parameter_index(estimate, term.name) || (counted && term.name == role + "_bias");
  });
  for (const Term& term : ranges.terms) {
    const auto [least, greatest] = range(term, kind);
    ranges.least.push_back(least);
    ranges.greatest.push_back(greatest);
  }
  OutputModel model =
      output_model(estimate, role, along(first_of(kind), axis), kind == Kind::gyro ? "deg/s" : "m/s^2", ranges);
  if (!counted) return model;
  set_scale(estimate, role + "_scale_factor", model);
  model.offset = parameter_index(estimate, role + "_bias");
  return model;
}

/// One row of u = R^-1 (...): R_i u = R_ii u_i + sum_j c_j u_j with R_ii = +-sqrt(1 - sum_j c_j^2), which no parameter
/// states. About the estimate R_ii - 1 = C - sum_j (c_j/R_ii) c_j, so that each c_j multiplies u_j - (c_j/R_ii) u_i and
/// C is a term of its own: the value and its first derivatives are those of the row.
void add_direction(const Estimate& estimate, const std::string& role, Input first, std::size_t axis, double sign,
                   const Vector3& range, OutputModel& model) {
  std::vector<std::size_t> parameters;
  double squares = 0.0;
  for (std::size_t j = 0; j < 3; ++j)
    if (j != axis) {
      parameters.push_back(*parameter_index(estimate, fmt::format("{}_misalignment_{}", role, letters[j])));
      squares += std::pow(estimate.parameters[parameters.back()].value, 2);
    }
  const double own = sign * std::sqrt(std::max(1.0 - squares, 0.0));
  for (std::size_t k = 0; k < 2; ++k) {
    const Parameter& parameter = estimate.parameters[parameters[k]];
    const std::size_t j = (k == 0) ? (axis == 0 ? 1 : 0) : (axis == 2 ? 1 : 2);
    const Regressor across = along(first, j), turned = (parameter.value / own) * Regressor(along(first, axis));
    model.terms.push_back({parameter.name, parameters[k], (across - turned).products(), -range[j], range[j]});
  }
  const double rest = own - 1.0 + squares / own;
  model.terms.push_back({"direction_cosine", std::nullopt, (rest * Regressor(along(first, axis))).products(),
                         -std::abs(rest) * range[axis], std::abs(rest) * range[axis]});
}

}  // namespace

OutputModel directed_model(const Estimate& estimate, Kind kind, std::size_t axis, double sign, const Vector3& rate,
                           const Vector3& force) {
  const bool gyro = kind == Kind::gyro;
  const std::string role = role_of(kind, axis);
  OutputModel model = output_model(estimate, role, along(first_of(kind), axis), gyro ? "deg/s" : "m/s^2", {});
  set_scale(estimate, role + "_scale_factor", model);
  model.offset = parameter_index(estimate, role + "_bias");
  add_direction(estimate, role, first_of(kind), axis, sign, gyro ? rate : force, model);
  for (std::size_t j = 0; gyro && j < 3; ++j) {
    const std::string name = fmt::format("{}_acceleration_sensitivity_{}", role, letters[j]);
    model.terms.push_back({.term = name,
                           .parameter = parameter_index(estimate, name),
                           .regressor = Regressor(along(Input::specific_force_x, j)).products(),
                           .least = -force[j],
                           .greatest = force[j],
                           .per_output = true});
  }
  set_covered(rate, force, model);
  return model;
}

std::vector<OutputModel> models_of(const Estimate& estimate, const RangeOf& range) {
  std::vector<OutputModel> models;
  for (const Kind kind : kinds)
    if (parameter_index(estimate, role_of(kind, 0) + "_bias"))
      for (std::size_t axis = 0; axis < 3; ++axis) models.push_back(model_of(estimate, range, kind, axis));
  return models;
}

void set_covered(const Vector3& rate, const Vector3& force, OutputModel& model) {
  model.covered.clear();
  model.in_region = norm(rate) > 0.0 || norm(force) > 0.0;
  for (const auto& [first, limit, noise] :
       {std::tuple{Input::rate_x, rate, rate_noise}, {Input::specific_force_x, force, force_noise}})
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (limit[axis] > 0.0) model.covered.push_back({{{along(first, axis), 1.0}}, -limit[axis], limit[axis], noise});
}

}  // namespace tumble::imu

#include "tumble/reduce/accelerometer/scale_factor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/core/columns.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer {
namespace {

constexpr double least_scale = 1e-6;  ///< [1] of the given scale factor: the output does not show the specific force

constexpr const char* error_name = "scale_factor_error";

/// Index of the column dK_1 among those used. Throws where the positions do not show it.
std::size_t error_column(const linear::Solution& solution) {
  const auto column = std::ranges::find(solution.columns, error_name, &Term::name);
  if (column == solution.columns.end())
    throw Error(Error::Kind::bad_data,
                "the positions do not show the scale factor: the input axis must feel two specific forces at least; "
                "add positions with it up and down");
  return static_cast<std::size_t>(column - solution.columns.begin());
}

/// 1 + dK_1 of a first solution. Throws for an output that does not follow the specific force.
double error_factor(const linear::Solution& solution) {
  const double factor = 1.0 + solution.fit.parameters[error_column(solution)];
  if (!std::isfinite(factor))
    throw Error(Error::Kind::bad_data, "the fit of the positions gives no finite scale factor");
  if (std::abs(factor) < least_scale)
    throw Error(Error::Kind::bad_data,
                "the output does not follow the specific force along the input axis: is this the accelerometer's "
                "channel, and did the rig move as the plan says?");
  return factor;
}

/// A first guess of K_1: the greatest output over 1 g.
double rough_scale_factor(const Channel& channel, const Output& output) {
  double most = 0.0;
  for (const double v : channel.values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most > 0.0 ? most * output.per_second / standard_gravity : 1.0;
}

void set_scale(double scale_factor, const Output& output, linear::Problem& problem) {
  problem.scale = output.per_second / scale_factor;
  problem.pulse = output.pulses ? 1.0 / std::abs(scale_factor) : 0.0;
}

/// g in the unit of a coefficient: its exponent of 1/g.
int per_g(const Unit& unit) {
  const auto is = [&](const char* text) { return unit.dimension() == Unit::parse(text).dimension(); };
  if (is("g")) return -1;
  if (is("1/g^2")) return 2;
  return is("1/g") || is("pulse/s/g") || is("mA/g") || is("V/g") ? 1 : 0;
}

}  // namespace

void normalise(linear::Solution& solution, double nominal, const Output& output) {
  const std::size_t p = solution.columns.size(), at = error_column(solution);
  auto& fit = solution.fit;
  const double factor = 1.0 + fit.parameters[at];
  Matrix jacobian(p, p);
  for (std::size_t j = 0; j < p; ++j) {
    jacobian(j, j) = 1.0 / factor;
    jacobian(j, at) = j == at ? nominal : -fit.parameters[j] / (factor * factor);
  }
  for (std::size_t j = 0; j < p; ++j) fit.parameters[j] = j == at ? nominal * factor : fit.parameters[j] / factor;
  fit.covariance = sandwich(jacobian, fit.covariance);
  for (auto& source : fit.sources) {
    source.covariance = sandwich(jacobian, source.covariance);
    if (!source.shifts.empty()) source.shifts = jacobian * source.shifts;
  }
  for (auto& sensitivity : fit.component_sensitivity) sensitivity = sandwich(jacobian, sensitivity);
  solution.columns[at].name = "scale_factor";
  solution.columns[at].symbol = "K_1";
  solution.columns[at].unit = output.scale_factor.text();
  solution.columns[at].description = "scale factor, per standard g";
}

Evidence at_one_rate(const Evidence& evidence) {
  Evidence out = evidence;
  if (out.recordings.empty()) return out;
  const double first = output_of(require_channel(evidence, evidence.recordings.front(), "accelerometer")).per_second;
  for (std::size_t r = 1; r < out.recordings.size(); ++r) {
    const Channel& channel = require_channel(evidence, evidence.recordings[r], "accelerometer");
    const Output output = output_of(channel);
    if (!output.pulses || output.per_second == first) continue;
    for (auto& other : out.recordings[r].channels)
      if (other.name == channel.name)
        for (double& v : other.values) v *= output.per_second / first;
  }
  return out;
}

Normalised identify(const Evidence& evidence, linear::Problem problem, const Refine& refine) {
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), "accelerometer");
  const Output output = output_of(channel);
  problem.role = "accelerometer";
  double scale_factor = rough_scale_factor(channel, output);
  set_scale(scale_factor, output, problem);
  const auto first = linear::identify(evidence, problem);
  scale_factor *= error_factor(first);
  if (refine) refine(first, problem);
  set_scale(scale_factor, output, problem);
  auto solution = linear::identify(evidence, problem);
  const double estimate = scale_factor * error_factor(solution);
  normalise(solution, scale_factor, output);
  return {std::move(problem), std::move(solution), output, estimate};
}

Normalised predict(const Plan& plan, linear::Problem problem, const Refine& refine) {
  const auto truth = linear::truth_of(plan, "accelerometer");
  const Output output = output_of(plan.truth, plan.sample_rate);
  const double nominal = scale_factor_of(plan.truth);
  problem.role = "accelerometer";
  problem.pulse = output.pulses ? 1.0 / std::abs(nominal) : 0.0;
  if (refine) refine(linear::predict(plan, problem, truth), problem);
  auto solution = linear::predict(plan, problem, truth);
  const double estimate = nominal * error_factor(solution);
  normalise(solution, nominal, output);
  return {std::move(problem), std::move(solution), output, estimate};
}

namespace {

/// Scale, pulse and the uncertainty of a scale factor that is known.
double set_known_scale(const Settings& settings, const Output& output, linear::Problem& problem) {
  const double sd = settings.number("scale_factor_sd");
  const bool wanted = output.scale_factor != Unit();
  const auto given = given_scale_factor(settings, output);
  if (wanted && !given)
    throw Error(Error::Kind::bad_input, "[settings] scale_factor_sd without scale_factor: give both, or neither");
  const double scale_factor = given.value_or(1.0);
  set_scale(scale_factor, output, problem);
  if (sd > 0.0)
    problem.reading_errors.push_back({"scale factor", sd, [](const Felt&, double predicted) { return predicted; }});
  return scale_factor;
}

}  // namespace

Normalised identify_with_known_scale_factor(const Evidence& evidence, linear::Problem problem, const Refine& refine) {
  const Output output = output_of(require_channel(evidence, evidence.recordings.front(), "accelerometer"));
  const double scale_factor = set_known_scale(evidence.plan.settings, output, problem);
  if (refine) refine(linear::identify(evidence, problem), problem);
  auto solution = linear::identify(evidence, problem);
  return {std::move(problem), std::move(solution), output, scale_factor};
}

Normalised predict_with_known_scale_factor(const Plan& plan, linear::Problem problem, const Refine& refine) {
  const Output output = output_of(plan.truth, plan.sample_rate);
  const double scale_factor = set_known_scale(plan.settings, output, problem);
  problem.scale = 1.0;
  const auto truth = linear::truth_of(plan, "accelerometer");
  if (refine) refine(linear::predict(plan, problem, truth), problem);
  auto solution = linear::predict(plan, problem, truth);
  return {std::move(problem), std::move(solution), output, scale_factor};
}

Table in_local_g(const Estimate& estimate, double gravity) {
  const double r = gravity / standard_gravity;
  NumberedColumns columns{{"", [](std::size_t row) { return row == 0 ? "value" : "standard uncertainty"; }}};
  for (std::size_t j = 0; j < estimate.parameters.size(); ++j) {
    const auto& parameter = estimate.parameters[j];
    columns.emplace_back(
        parameter.name, parameter.unit, [&, j, factor = std::pow(r, per_g(parameter.unit))](std::size_t row) {
          return factor * (row == 0 ? estimate.parameters[j].value : standard_uncertainty(estimate, j));
        });
  }
  return tabulate("local_g", fmt::format("coefficients where g is the local gravity, {:.5f} m/s^2", gravity), 2,
                  columns);
}

}  // namespace tumble::accelerometer

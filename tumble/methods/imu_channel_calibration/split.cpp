#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tumble/core/attempt.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/methods/accelerometer_four_position/report.hpp"
#include "tumble/methods/imu_channel_calibration/calibration.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_channel_calibration {
namespace {

constexpr double least_ratio = 0.5;  ///< [1] of outputs and inputs: no scale factor is off by as much

/// Bias and scale factor error of one channel in the form of (3.4).
struct Alone {
  double value[2] = {0.0, 0.0};
  double degrees_of_freedom[2] = {0.0, 0.0};
  std::vector<ErrorLine> lines;  ///< of the two
  Findings findings;
};

/// Settings of the method of four positions by those of this method.
Settings settings_of_four(const Settings& own) {
  Settings settings = defaults(find_method("accelerometer_four_position").options());
  for (const char* name : {"settling", "averaging", "same_temperature"})
    settings.set_number(name, own.number(name), Unit::parse(name == std::string("same_temperature") ? "K" : "s"));
  settings.set_word("order", own.word("order"));
  if (own.has("accelerometer_scale_factor")) settings.set_word("scale_factor", own.word("accelerometer_scale_factor"));
  return settings;
}

Alone accelerometer_alone(Evidence evidence, double temperature) {
  evidence.plan.settings = settings_of_four(evidence.plan.settings);
  const auto bench = accelerometer_four_position::bench_of(evidence, "accelerometer");
  const auto reduced = accelerometer_four_position::reduce(
      bench, accelerometer_four_position::order_of(evidence.plan.settings, bench), false, 0.0, nullptr);
  const double low = bench.group_temperature.front(), high = bench.group_temperature.back();
  const double from = std::clamp(temperature, low, high);
  Alone out;
  Matrix weights(2, reduced.parameters.size());
  std::size_t k = 0;
  for (const auto quantity : {accelerometer_four_position::bias, accelerometer_four_position::scale_factor_error}) {
    const auto& polynomial = reduced.polynomial[quantity];
    const auto powers = accelerometer_four_position::powers(from, polynomial.count);
    for (std::size_t j = 0; j < polynomial.count; ++j) weights(k, polynomial.first + j) = powers[j];
    out.value[k] = accelerometer_four_position::at_temperature(reduced.parameters, polynomial, from);
    out.degrees_of_freedom[k] = accelerometer_four_position::freedom_of(reduced, row(weights, k));
    ++k;
  }
  out.lines = carried(weights, lines_of(reduced.sources));
  const double slack = evidence.plan.settings.number("same_temperature");
  if (temperature < low - slack || temperature > high + slack)
    out.findings.push_back({Finding::Severity::warning,
                            "tested_at_other_temperature",
                            {{"low", low, "degC"}, {"high", high, "degC"}, {"unit", temperature, "degC"}}});
  for (const auto& finding : bench.findings) out.findings.push_back(finding);
  return out;
}

/// Input of the model of the channel's own plan.
Regressor input_of(const Plan& plan, const std::string& channel) {
  if (!plan.instrument_model.empty()) {
    const Model& model = find_model(plan.instrument_model);
    const Settings constants = plan.truth.texts().empty() ? defaults(model.constants()) : plan.truth;
    for (const auto& output : model.outputs(constants))
      if (output.channel == channel && output.input) return output.input;
  }
  throw Error(Error::Kind::bad_input,
              say("{}: [instrument] model must be one with an output '{}': its input axis is needed", Name{plan.file},
                  channel));
}

/// y = w + b + k w: nabla = b/(1 + k), dK = 1/(1 + k) - 1.
Alone gyro_alone(const Evidence& evidence) {
  const Channel& channel = require_channel(evidence, evidence.recordings.front(), "gyro");
  linear::Problem problem;
  problem.role = "gyro";
  const Reading reading = reading_of(Kind::gyro, evidence.plan.settings, channel);
  problem.scale = reading.scale;
  problem.pulse = reading.pulse;
  problem.input = input_of(evidence.plan, channel.name);
  linear::set_options(evidence.plan.settings, problem, imu::prefix_of(Kind::gyro));
  problem.columns = {{"bias", "b", "deg/h", "bias", [](const Felt&) { return 1.0; }},
                     {"scale_factor_error", "k", "ppm", "scale factor error", problem.input}};
  const auto solution = linear::identify(evidence, problem);
  if (solution.columns.size() != 2)
    throw Error(Error::Kind::bad_data, "the schedule does not show bias and scale factor: rates of both signs do");
  const double b = solution.fit.parameters[0], s = 1.0 + solution.fit.parameters[1];
  Matrix slopes(2, 2);
  slopes(0, 0) = 1.0 / s, slopes(0, 1) = -b / (s * s), slopes(1, 1) = -1.0 / (s * s);
  Alone out{{b / s, 1.0 / s - 1.0}, {}, carried(slopes, lines_of(solution.fit.sources)), solution.findings};
  for (std::size_t k = 0; k < 2; ++k) out.degrees_of_freedom[k] = degrees_of_freedom(solution.fit, row(slopes, k));
  return out;
}

void add_channel(std::size_t axis, const Alone& alone, Calibration& out) {
  Matrix rows(terms, 2);
  for (std::size_t a = 0; a < 2; ++a) {
    out.value[index_of(axis, a)] = alone.value[a];
    out.degrees_of_freedom[index_of(axis, a)] = alone.degrees_of_freedom[a];
    rows(index_of(axis, a), a) = 1.0;
  }
  std::ranges::move(carried(rows, alone.lines), std::back_inserter(out.lines));
}

}  // namespace

Calibration split_of(Kind kind, const Sorted& sorted, double temperature) {
  Calibration out;
  out.value.assign(terms, 0.0);
  out.degrees_of_freedom.assign(terms, std::numeric_limits<double>::infinity());
  out.temperature = temperature;
  const double assembly = sorted.whole.plan.settings.number("assembly_sd");
  std::vector<double> assembled(terms, 0.0);
  Problems problems;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto role = role_of(kind, axis);
    const auto& evidence = sorted.alone.at(role);
    try {
      const Alone alone = kind == Kind::gyro ? gyro_alone(evidence) : accelerometer_alone(evidence, temperature);
      add_channel(axis, alone, out);
      if (const double ratio = 1.0 / (1.0 + alone.value[1]); !(ratio > least_ratio && ratio < 1.0 / least_ratio))
        out.findings.push_back(
            {Finding::Severity::error,
             "scale_mistaken",
             {{"sensors", Phrase{kind == Kind::gyro ? "gyros" : "accelerometers"}}, {"ratio", ratio}},
             role});
      for (auto finding : alone.findings) {
        finding.where = finding.where.empty() ? role : role + ", " + finding.where;
        out.findings.push_back(std::move(finding));
      }
    } catch (const Error& error) {
      if (error.kind == Error::Kind::internal) throw;
      for (const auto& problem : error.problems) problems.push_back(within(say("{} alone", Name{role}), problem));
    }
    for (const std::size_t which : {2u, 3u}) assembled[index_of(axis, which)] = assembly * assembly;
  }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  out.lines.push_back(from_variances("assembly", assembled));
  return out;
}

}  // namespace tumble::imu_channel_calibration

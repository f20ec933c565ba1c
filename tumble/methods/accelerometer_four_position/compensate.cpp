#include "tumble/methods/accelerometer_four_position/compensate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tumble/methods/accelerometer_four_position/counts.hpp"
#include "tumble/methods/accelerometer_four_position/design.hpp"
#include "tumble/reduce/compensation/outputs.hpp"
#include "tumble/units/constants.hpp"
#include "tumble/units/error.hpp"

namespace tumble::accelerometer_four_position {
namespace {

/// b_0, b_1, ... of a result, or the one value of a test at one temperature.
struct Coefficients {
  std::vector<std::size_t> bias, scale;  ///< indices of parameters, by power
};

Coefficients coefficients_of(const Estimate& estimate) {
  Coefficients out;
  const auto add = [&](const std::string& name, std::vector<std::size_t>& to) {
    for (std::size_t p = 0; p < estimate.parameters.size(); ++p)
      if (estimate.parameters[p].name == name) to.push_back(p);
  };
  for (const char* power : {"0", "1", "2"}) {
    add(std::string("b_") + power, out.bias);
    add(std::string("c_") + power, out.scale);
  }
  if (out.bias.empty()) add("bias", out.bias);
  if (out.scale.empty()) add("scale_factor_error", out.scale);
  std::vector<std::string> faults;
  if (out.bias.empty()) faults.push_back("the result has neither b_0 nor bias");
  if (out.scale.empty()) faults.push_back("the result has neither c_0 nor scale_factor_error");
  for (const auto& parameter : estimate.parameters)
    if (!std::isfinite(parameter.value))
      faults.push_back(fmt::format("the result's parameter '{}' has no value", parameter.name));
  const Table* range = find_table(estimate, "calibrated_range");
  if (!range || range->rows.size() != 1 || range->columns.size() != 2)
    faults.push_back("the result has no table calibrated_range, which states where the compensation holds");
  if (!faults.empty()) throw Error(Error::Kind::bad_file, faults);
  return out;
}

double scale_factor_of(const Estimate& estimate, const Channel& channel) {
  const auto output = accelerometer::output_of(channel);
  if (output.scale_factor == Unit()) return 1.0;
  const auto setting = estimate.provenance.settings.find("scale_factor");
  if (setting == estimate.provenance.settings.end() || setting->second.empty())
    throw Error(Error::Kind::bad_file, "the result's provenance lacks the setting 'scale_factor'");
  return parse_si(setting->second, output.scale_factor);
}

/// Channels of the recording by role.
struct Channels {
  std::size_t accelerometer = 0;
  const Channel* temperature = nullptr;
};

Channels channels_of(const Estimate& estimate, const Recording& recording, bool needs_temperature) {
  Problems problems;
  const auto accelerometer = compensation::output_of(estimate, recording, "accelerometer", problems);
  Channels out{0, channel_of(estimate, recording, "temperature")};
  if (needs_temperature && !out.temperature)
    problems.push_back("the recording has no channel for the role temperature, over which the result was fitted");
  compensation::require_dimension(out.temperature, "degC", problems);
  compensation::refuse(recording, problems);
  out.accelerometer = *accelerometer;
  return out;
}

/// The reading at or before a time, NaN before the first.
double reading_at(const Channel& channel, double time) {
  std::size_t i = index_at(channel, time);
  if (i < channel.values.size() && channel.time(i) <= time) return channel.values[i];
  return i > 0 ? channel.values[i - 1] : std::nan("");
}

double polynomial(const Estimate& estimate, const std::vector<std::size_t>& of, double celsius) {
  double sum = 0.0;
  for (std::size_t j = of.size(); j-- > 0;) sum = sum * celsius + estimate.parameters[of[j]].value;
  return sum;
}

/// Variance of y (1 + dK) - nabla for y without uncertainty.
double variance_of(const Estimate& estimate, const Coefficients& c, double y, double celsius) {
  std::vector<std::pair<std::size_t, double>> weights;
  for (std::size_t j = 0; j < c.bias.size(); ++j) weights.emplace_back(c.bias[j], -std::pow(celsius, j));
  for (std::size_t j = 0; j < c.scale.size(); ++j) weights.emplace_back(c.scale[j], y * std::pow(celsius, j));
  double sum = 0.0;
  for (const auto& [i, a] : weights)
    for (const auto& [j, b] : weights) sum += a * b * estimate.covariance(i, j);
  return sum < 0.0 ? 0.0 : sum;  // what is no number stays so
}

/// Variance [(m/s^2)^2] of the terms that stay in, K_2 a_i^2 and the misalignment: neither is in (3.4) as the source
/// compensates, and nothing says what acts across the axis. Specific force is anywhere within 1 g.
double staying_variance(const Estimate& estimate) {
  double sum = 0.0;
  for (const auto& [name, square] : {std::pair{"second_order_coefficient", std::pow(standard_gravity, 4)},
                                     std::pair{"misalignment", std::pow(standard_gravity, 2)}}) {
    const auto match = std::ranges::find(estimate.parameters, name, &Parameter::name);
    if (match == estimate.parameters.end()) continue;
    const auto p = static_cast<std::size_t>(match - estimate.parameters.begin());
    sum += (match->value * match->value + estimate.covariance(p, p)) * square / 3.0;
  }
  return sum;
}

/// Samples that have no temperature, or one outside of the calibrated range, and those beyond the positions in gravity.
struct Counts {
  std::size_t outside = 0, blank = 0, strong = 0;
};

void add_findings(const Counts& counts, std::size_t samples, const Table& range, const std::string& channel,
                  Findings& findings) {
  const double share = static_cast<double>(counts.outside) / static_cast<double>(samples);
  if (counts.outside > 0)
    findings.push_back({Finding::Severity::warning,
                        "outside_of_calibrated_temperatures",
                        {{"share", share, "%"},
                         {"low", std::get<double>(range.rows[0][0]), "degC"},
                         {"high", std::get<double>(range.rows[0][1]), "degC"},
                         {"channel", channel + ".extrapolated"}}});
  if (counts.strong > 0)
    findings.push_back({Finding::Severity::warning,
                        "beyond_gravity",
                        {{"share", static_cast<double>(counts.strong) / static_cast<double>(samples), "%"},
                         {"channel", channel + ".extrapolated"}},
                        channel,
                        {counts.strong, {}, {}}});
  if (counts.blank > 0)
    findings.push_back({Finding::Severity::warning, "no_temperature_at_sample", {}, channel, {counts.blank, {}, {}}});
}

}  // namespace

Compensation compensate(const Estimate& estimate, const Recording& recording, const Plan*) {
  const Coefficients c = coefficients_of(estimate);
  const bool over = c.bias.size() > 1 || c.scale.size() > 1;
  const Channels channels = channels_of(estimate, recording, over);
  const Table& range = *find_table(estimate, "calibrated_range");
  const double slack = 1.0, low = compensation::number_in(range, range.rows[0][0]),
               high = compensation::number_in(range, range.rows[0][1]), staying = staying_variance(estimate);
  Compensation out{recording, {}, {}};
  const Channel& raw = recording.channels[channels.accelerometer];
  const double reference = scale_factor_of(estimate, raw);
  Evidence evidence;
  evidence.recordings = {recording};
  evidence.plan.channels["accelerometer"] = {{raw.name, std::nullopt}};
  Channel& channel = out.recording.channels[channels.accelerometer];
  channel.values = per_second(evidence, "accelerometer", out.findings).recordings[0].channels[0].values;
  channel.kind = QuantityKind::specific_force;
  channel.unit = Unit::parse("g");
  auto [sd, outside] = compensation::trust_in(channel);
  Counts counts;
  for (std::size_t k = 0; k < channel.values.size(); ++k) {
    const double t = channels.temperature ? reading_at(*channels.temperature, raw.time(k)) : low;
    const double degrees = over ? celsius(t) : 0.0, y = channel.values[k] / reference;
    channel.values[k] = y * (1.0 + polynomial(estimate, c.scale, degrees)) - polynomial(estimate, c.bias, degrees);
    sd.values[k] =
        std::isnan(channel.values[k]) ? std::nan("") : std::sqrt(variance_of(estimate, c, y, degrees) + staying);
    const bool cold_or_hot = t < low - slack || t > high + slack;
    const bool strong = std::abs(channel.values[k]) > 1.05 * standard_gravity;
    outside.values[k] = std::isnan(channel.values[k]) ? std::nan("") : cold_or_hot || strong ? 1.0 : 0.0;
    counts.outside += cold_or_hot;
    counts.strong += strong;
    counts.blank += over && std::isnan(t) && !std::isnan(y);
  }
  add_findings(counts, channel.values.size(), range, raw.name, out.findings);
  out.recording.channels.push_back(std::move(sd));
  out.recording.channels.push_back(std::move(outside));
  return out;
}

}  // namespace tumble::accelerometer_four_position

#include "tumble/methods/north_finding/instrument.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tumble/earth/earth.hpp"
#include "tumble/math/linear_algebra.hpp"
#include "tumble/units/error.hpp"

namespace tumble::north_finding {
namespace {

bool like(const Unit& unit, const char* other) { return unit.dimension() == Unit::parse(other).dimension(); }

/// The scale factor's unit for an output in `unit`.
Unit scale_unit(Channel channel, const Recorded& recorded) {
  if (recorded.plain) return {};
  if (recorded.pulses) return Unit::parse(channel == gyro ? "pulse/arcsec" : "pulse/(m/s)");
  return Unit::parse(fmt::format("{}/({})", recorded.unit.text(), channel == gyro ? "deg/h" : "m/s^2"));
}

std::optional<double> given_scale(const Settings& settings, const char* option, const Unit& unit, Problems& problems) {
  if (!settings.has(option) || settings.word(option).empty()) return std::nullopt;
  try {
    const double value = parse_si(settings.word(option), unit);
    if (std::isfinite(value) && value > 0.0) return value;
    problems.push_back(say("[settings] {} must be above zero", option));
  } catch (const Error& error) {
    for (const auto& problem : error.problems) problems.push_back(say("[settings] {}: {}", option, problem));
  }
  return std::nullopt;
}

Prior single(const std::string& source, Quantity of, double sd) {
  Matrix covariance(1, 1);
  covariance(0, 0) = sd * sd;
  return {source, {of}, covariance};
}

void add_prior(Instrument& instrument, const std::string& source, Quantity of, double sd) {
  if (sd > 0.0) instrument.priors.push_back(single(source, of, sd));
}

void set_scale(const Plan& plan, const Records& records, Channel channel, const char* option, const char* sd,
               const char* source, Instrument& instrument, Problems& problems) {
  const Recorded& recorded = records[channel];
  if (!recorded.present) return;
  auto& value = instrument.state[scale_of(channel)];
  value = 1.0;
  instrument.scale_known[channel] = recorded.plain;
  if (!recorded.plain)
    if (const auto given = given_scale(plan.settings, option, scale_unit(channel, recorded), problems)) {
      value = *given;
      instrument.scale_known[channel] = true;
    }
  if (instrument.scale_known[channel])
    add_prior(instrument, source, scale_of(channel), plan.settings.number(sd) * value);
}

/// The parameter of a calibration that gives a quantity.
struct Name {
  Quantity quantity;
  Channel channel;
  const char* name;
};
constexpr Name names[] = {{gyro_scale, gyro, "gyro.scale_factor"},
                          {gyro_y, gyro, "gyro.misalignment_y"},
                          {gyro_z, gyro, "gyro.misalignment_z"},
                          {x_scale, accelerometer_x, "accelerometer_x.scale_factor"},
                          {x_bias, accelerometer_x, "accelerometer_x.bias"},
                          {x_y, accelerometer_x, "accelerometer_x.misalignment_y"},
                          {x_z, accelerometer_x, "accelerometer_x.misalignment_z"},
                          {y_scale, accelerometer_y, "accelerometer_y.scale_factor"},
                          {y_bias, accelerometer_y, "accelerometer_y.bias"},
                          {y_x, accelerometer_y, "accelerometer_y.misalignment_x"},
                          {y_z, accelerometer_y, "accelerometer_y.misalignment_z"}};

bool is_scale(Quantity quantity) { return quantity == gyro_scale || quantity == x_scale || quantity == y_scale; }

/// The quantities that the calibration gives, and the indices of their parameters in it.
struct Used {
  std::vector<Quantity> quantities;
  std::vector<std::size_t> index;
};

Used used_of(const Estimate& result, const Records& records, Instrument& instrument, Problems& problems) {
  Used used;
  for (const auto& name : names) {
    const Parameter* parameter = find_parameter(result, name.name);
    if (!parameter || !records[name.channel].present) continue;
    if (is_scale(name.quantity) && records[name.channel].plain) continue;  // the output is in SI already
    const Unit expected = is_scale(name.quantity) ? scale_unit(name.channel, records[name.channel])
                          : name.quantity == x_bias || name.quantity == y_bias ? Unit::parse("m/s^2")
                                                                               : Unit::parse("arcsec");
    if (!(parameter->unit.dimension() == expected.dimension())) {
      problems.push_back(say("the calibration has {} in {}; this test needs it in {}", name.name,
                             parameter->unit.text(), expected.text()));
      continue;
    }
    forget(instrument, name.quantity);
    instrument.state[name.quantity] = parameter->value;
    if (is_scale(name.quantity)) instrument.scale_known[name.channel] = true;
    if (name.quantity == bias_of(name.channel)) instrument.bias_known[name.channel] = true;
    used.quantities.push_back(name.quantity);
    used.index.push_back(static_cast<std::size_t>(parameter - result.parameters.data()));
  }
  return used;
}

void refuse(const Problems& problems) {
  if (!problems.empty()) throw Error(Error::Kind::bad_input, problems);
}

}  // namespace

Recorded recorded_as(Channel channel, const Unit& unit, double rate) {
  const bool is_gyro = channel == gyro;
  Recorded out;
  out.present = true;
  out.unit = unit;
  if (like(unit, "pulse")) return {true, Unit::parse("pulse/s"), false, rate, true};
  if (like(unit, "pulse/s")) return {true, unit, false, 1.0, false};
  if (like(unit, is_gyro ? "deg" : "m/s")) return {true, Unit::parse(is_gyro ? "deg/h" : "m/s^2"), true, rate, false};
  if (like(unit, is_gyro ? "deg/h" : "m/s^2")) return out;
  out.plain = false;
  for (const char* other : {"deg", "deg/h", "m/s", "m/s^2", "K", "s"})
    if (like(unit, other))
      throw Error(Error::Kind::bad_data,
                  say("the channel of {} is in {}: it must be {}, counts, a current or a voltage",
                      tumble::Name{role_of(channel)}, unit.text(),
                      is_gyro ? "an angular rate, an angle gained in each sample"
                              : "a specific force, a velocity gained in each sample"));
  return out;
}

void forget(Instrument& instrument, Quantity quantity) {
  for (auto& prior : instrument.priors) {
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < prior.of.size(); ++k)
      if (prior.of[k] != quantity) others.push_back(k);
    prior.covariance = chosen_columns(chosen_rows(prior.covariance, others), others);
    std::erase(prior.of, quantity);
  }
  std::erase_if(instrument.priors, [](const Prior& prior) { return prior.of.empty(); });
}

std::vector<Option> instrument_options() {
  return {text("gyro_scale_factor")
              .says("K of the gyro where it gives counts, a current or a voltage: \"0.44233 pulse/arcsec\", \"2 "
                    "mV/(deg/h)\"; absent, and without calibration: estimated with the azimuth"),
          quantity("gyro_scale_factor_sd", "ppm")
              .at_least(0)
              .otherwise("0 ppm")
              .says("standard uncertainty of the nominal scale factor of the gyro"),
          quantity("gyro_misalignment_sd", "arcsec")
              .at_least(0)
              .otherwise("0 arcsec")
              .says("standard uncertainty of gamma_y and of gamma_z, where no calibration gives them"),
          text("accelerometer_scale_factor").says("K of the accelerometers: \"2000 pulse/(m/s)\", \"100 mV/g\""),
          quantity("accelerometer_scale_factor_sd", "ppm")
              .at_least(0)
              .otherwise("0 ppm")
              .says("standard uncertainty of the scale factor of each accelerometer"),
          quantity("accelerometer_bias_sd", "ug")
              .at_least(0)
              .says("standard uncertainty of each bias; used only where the positions do not show the bias"),
          quantity("accelerometer_misalignment_sd", "arcsec")
              .at_least(0)
              .otherwise("0 arcsec")
              .says("standard uncertainty of each misalignment of an accelerometer"),
          quantity("latitude_sd", "arcsec")
              .at_least(0)
              .says("standard uncertainty of the latitude of the plan; absent: that of [site]")};
}

Instrument nominal_instrument(const Plan& plan, const Records& records) {
  Instrument out;
  Problems problems;
  out.state[latitude] = plan.site->latitude;
  out.state[gravity_here] = gravity(*plan.site);
  set_scale(plan, records, gyro, "gyro_scale_factor", "gyro_scale_factor_sd", "scale factor of the gyro", out,
            problems);
  for (const Channel channel : {accelerometer_x, accelerometer_y}) {
    const std::string of = std::string(" of ") + role_of(channel);
    set_scale(plan, records, channel, "accelerometer_scale_factor", "accelerometer_scale_factor_sd",
              ("scale factor" + of).c_str(), out, problems);
    if (!records[channel].present) continue;
    const bool x = channel == accelerometer_x;
    const double sd = plan.settings.number("accelerometer_misalignment_sd");
    add_prior(out, "misalignment" + of, x ? x_y : y_x, sd);
    add_prior(out, "misalignment" + of, x ? x_z : y_z, sd);
    out.bias_known[channel] = plan.settings.has("accelerometer_bias_sd");
    if (out.bias_known[channel])
      add_prior(out, "bias" + of, bias_of(channel), plan.settings.number("accelerometer_bias_sd"));
  }
  const double sd = plan.settings.number("gyro_misalignment_sd");
  add_prior(out, "misalignment of the gyro", gyro_y, sd);
  add_prior(out, "misalignment of the gyro", gyro_z, sd);
  const bool stated = plan.settings.has("latitude_sd");
  add_prior(out, "latitude", latitude, stated ? plan.settings.number("latitude_sd") : latitude_sd(*plan.site));
  refuse(problems);
  return out;
}

Instrument identified_instrument(const Plan& plan, const Records& records) {
  Instrument out = nominal_instrument(plan, records);
  const Estimate& result = *plan.calibration.result;
  Problems problems;
  const Used used = used_of(result, records, out, problems);
  if (used.quantities.empty() && problems.empty()) {
    std::vector<std::string> wanted;
    for (const auto& name : names) wanted.emplace_back(name.name);
    problems.push_back(say("the calibration {} ({}) has none of the parameters that north finding can use: {}",
                           plan.calibration.file, result.method, fmt::join(wanted, ", ")));
  }
  refuse(problems);
  out.priors.push_back(
      {"calibration", used.quantities, chosen_columns(chosen_rows(result.covariance, used.index), used.index)});
  return out;
}

}  // namespace tumble::north_finding

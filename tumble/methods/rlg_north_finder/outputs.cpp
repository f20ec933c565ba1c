#include "tumble/methods/rlg_north_finder/outputs.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/clocks/sampling_rate.hpp"
#include "tumble/units/error.hpp"

namespace tumble::rlg_north_finder {
namespace {

using Input::w_x, Input::w_y, Input::w_z, Input::f_x, Input::f_y, Input::f_z;

constexpr const char *gyro_prefix = "gyro_", *accelerometer_prefix = "accelerometer_";
constexpr const char* pulses_per_angle = "pulse/arcsec";
constexpr const char* per_velocity = "pulse/(m/s)";

}  // namespace

const std::array<Wanted, outputs * per_output>& wanted() {
  static const std::array<Wanted, outputs * per_output> all{{
      {gyro, "gyro.scale_factor", "K", pulses_per_angle, pulses_per_angle, "pulses for an angle about x", w_x},
      {gyro, "gyro.bias", "eps", "deg/h", "pulse/s", "of the gyro, as a rate", {}},
      {gyro, "gyro.misalignment_y", "gamma_y", "arcsec", pulses_per_angle, "of the gyro's axis towards y", w_y},
      {gyro, "gyro.misalignment_z", "gamma_z", "arcsec", pulses_per_angle, "of the gyro's axis towards z", w_z},
      {accelerometer_x, "accelerometer_x.scale_factor", "K_x", per_velocity, per_velocity,
       "pulses for a velocity along x", f_x},
      {accelerometer_x, "accelerometer_x.bias", "b_x", "ug", "pulse/s", "of the x accelerometer", {}},
      {accelerometer_x, "accelerometer_x.misalignment_y", "a_xy", "arcsec", per_velocity,
       "of the x accelerometer's axis towards y", f_y},
      {accelerometer_x, "accelerometer_x.misalignment_z", "a_xz", "arcsec", per_velocity,
       "of the x accelerometer's axis towards z", f_z},
      {accelerometer_y, "accelerometer_y.scale_factor", "K_y", per_velocity, per_velocity,
       "pulses for a velocity along y", f_y},
      {accelerometer_y, "accelerometer_y.bias", "b_y", "ug", "pulse/s", "of the y accelerometer", {}},
      {accelerometer_y, "accelerometer_y.misalignment_x", "a_yx", "arcsec", per_velocity,
       "of the y accelerometer's axis towards x", f_x},
      {accelerometer_y, "accelerometer_y.misalignment_z", "a_yz", "arcsec", per_velocity,
       "of the y accelerometer's axis towards z", f_z},
  }};
  return all;
}

Regressor regressor_of(const Wanted& parameter) {
  return parameter.input ? Regressor(*parameter.input) : Regressor(1.0);
}

const char* role_of(Which output) {
  return output == gyro ? "gyro" : output == accelerometer_x ? "accelerometer_x" : "accelerometer_y";
}

std::vector<Role> roles() {
  return {{"gyro", "", true, "counts of the ring laser gyro along x"},
          {"accelerometer_x", "", true, "counts of the accelerometer along x"},
          {"accelerometer_y", "", true, "counts of the accelerometer along y"},
          {"outer_angle", "deg", false, "recorded angle of the outer axis; absent: as commanded"},
          {"inner_angle", "deg", false, "recorded angle of the inner axis; absent: as commanded"}};
}

std::vector<Option> options() {
  return {word("estimator", {"least_squares", "closed_form"})
              .otherwise("least_squares")
              .says("all positions and rotations together with the errors of the table, or the formulas (2.1)-(2.7)"),
          quantity("settling", "s")
              .at_least(0)
              .otherwise("5 s")
              .says("time that is skipped in each stay after the table has settled"),
          quantity("averaging", "s")
              .above(0)
              .otherwise("10 s")
              .says("length of the averages that show the noise in a stay"),
          quantity("angle_tolerance", "deg")
              .above(0)
              .otherwise("0.1 deg")
              .says("difference between a recorded angle and the plan that is accepted without a warning"),
          quantity("dither_frequency", "Hz")
              .above(0)
              .says("frequency of the dither of the gyro: a finding names rotations near its multiples over the scale "
                    "factor; absent: not checked"),
          linear::bias_instability_option("deg/h", gyro_prefix),
          linear::bias_instability_option("ug", accelerometer_prefix)};
}

std::array<linear::Problem, outputs> problems_of(const Plan& plan) {
  std::array<linear::Problem, outputs> problems;
  const double gyro_instability = linear::stated_bias_instability(plan.settings, gyro_prefix);
  const double other_instability = linear::stated_bias_instability(plan.settings, accelerometer_prefix);
  for (const Which output : {gyro, accelerometer_x, accelerometer_y}) {
    linear::Problem& problem = problems[output];
    problem.role = role_of(output);
    problem.pulse = 1.0;
    problem.settling = plan.settings.number("settling");
    problem.averaging = plan.settings.number("averaging");
    problem.whole_moves = output == gyro;
    problem.rests_only = output != gyro;
    problem.bias_instability = output == gyro ? gyro_instability : other_instability;
    problem.stated_by = std::string(output == gyro ? gyro_prefix : accelerometer_prefix) + "bias_instability";
    problem.stated_per = wanted()[output * per_output].name;  // the scale factor
    problem.advice = {output == gyro ? "distinguish_gyro_by_path" : "distinguish_accelerometer_by_path"};
    for (const auto& parameter : wanted())
      if (parameter.output == output)
        problem.columns.push_back({parameter.name, parameter.symbol, parameter.coefficient_unit, parameter.description,
                                   regressor_of(parameter)});
  }
  return problems;
}

double per_second(const Channel& channel) {
  if (channel.unit.dimension() == Unit::parse("pulse/s").dimension()) return 1.0;
  if (!(channel.unit.dimension() == Unit::parse("pulse").dimension()))
    throw Error(Error::Kind::bad_data, say("channel '{}' is in {}: rlg_north_finder needs counts (pulse, or "
                                           "pulse/s)",
                                           channel.name, Name{channel.unit.text()}));
  return sampling_rate(channel);
}

namespace {

/// Counts of a sample become pulses a second.
void make_rate(const std::string& where, Channel& channel, Problems& problems) try {
  if (channel.unit.dimension() == Unit::parse("pulse/s").dimension()) return;
  const double rate = per_second(channel);
  for (double& v : channel.values) v *= rate;
  channel.unit = Unit::parse("pulse/s");
  channel.kind = QuantityKind::other;
} catch (const Error& error) {
  problems.push_back(say("{}{}", Name{where}, error.problems.front()));
}

}  // namespace

Prepared prepared(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "rlg_north_finder needs at least one recording");
  Evidence counted = evidence;
  Problems problems;
  for (auto& recording : counted.recordings)
    for (const Which output : {gyro, accelerometer_x, accelerometer_y}) try {
        const Channel& source = require_channel(evidence, recording, role_of(output));
        Channel& channel = recording.channels[static_cast<std::size_t>(&source - recording.channels.data())];
        make_rate(recording.origin.file.empty() ? "" : recording.origin.file + ": ", channel, problems);
        for (const double v : channel.values)
          if (std::isinf(v)) {
            problems.push_back(say("channel '{}' holds infinite samples", channel.name));
            break;
          }
      } catch (const Error& error) {
        problems.insert(problems.end(), error.problems.begin(), error.problems.end());
      }
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  Prepared out;
  const auto& settings = evidence.plan.settings;
  out.angles = table::with_recorded_angles(counted, settings.number("settling"), settings.number("angle_tolerance"));
  out.evidence = std::move(out.angles.evidence);
  out.angles.evidence = {};
  return out;
}

}  // namespace tumble::rlg_north_finder

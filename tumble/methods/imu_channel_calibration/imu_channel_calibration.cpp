#include <algorithm>
#include <iterator>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/imu_channel_calibration/compare.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: A compensated output, N pulses in a window H, K_m reference scale factor, dK scale errors, E
// installation errors, nabla bias.

namespace tumble::imu_channel_calibration {
namespace {

std::vector<Role> roles() {
  std::vector<Role> all;
  for (const char letter : letters)
    all.push_back(
        {std::string("accelerometer_") + letter, "", false,
         std::string("accelerometer along ") + letter + ", of the unit or alone: pulses, specific force, mA, V"});
  for (const char letter : letters)
    all.push_back({std::string("gyro_") + letter, "", false,
                   std::string("gyro along ") + letter + ", of the unit or alone: pulses or angular rate"});
  all.push_back({"temperature", "degC", false, "temperature of the unit, or of the channel alone"});
  return all;
}

Option tolerance(const char* name, const char* unit, const char* of) {
  return quantity(name, unit)
      .at_least(0)
      .otherwise(std::string("0 ") + unit)
      .says(std::string("difference of ") + of +
            " between whole unit and channel alone that is accepted in addition to "
            "twice its standard uncertainty");
}

std::vector<Option> options() {
  auto options = linear::options("2 s", "10 s");
  std::ranges::move(imu::scale_factor_options(), std::back_inserter(options));
  for (const auto& [kind, unit] : {std::pair{imu::Kind::gyro, "deg/h"}, {imu::Kind::accelerometer, "ug"}})
    options.push_back(linear::bias_instability_option(unit, imu::prefix_of(kind)));
  options.insert(
      options.end(),
      {word("order", {"auto", "0", "1", "2"})
           .otherwise("auto")
           .says("highest power of T where an accelerometer alone was tested at several temperatures"),
       quantity("same_temperature", "K")
           .at_least(0)
           .otherwise("2 K")
           .says("temperatures that differ by less than this are one temperature"),
       quantity("assembly_sd", "arcsec")
           .at_least(0)
           .otherwise("120 arcsec")
           .says(
               "standard uncertainty of each angle E of the channels after assembly; the method takes the angles as 0"),
       text("check").otherwise("check").says(
           "segments of the whole unit whose label begins with this are used only for the comparison"),
       tolerance("bias_tolerance", "ug", "biases of accelerometers"),
       tolerance("gyro_bias_tolerance", "deg/h", "biases of gyros"),
       tolerance("scale_factor_tolerance", "ppm", "scale factors"),
       tolerance("misalignment_tolerance", "arcsec", "angles")});
  return options;
}

/// A part of the evidence has a part of the segments: which of all are missing is for the checks to say.
void add(const Findings& findings, Estimate& estimate) {
  for (const Finding& finding : findings)
    if (finding.code != "not_recorded") estimate.findings.push_back(finding);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Sorted all = sorted(evidence);
  Estimate estimate;
  std::vector<Pair> pairs;
  for (const Kind kind : kinds) {
    if (kind == Kind::gyro && !all.gyros) continue;
    report(progress, 0.5 * static_cast<double>(pairs.size()), "calibrating");
    Pair pair{kind, whole_of(kind, all.whole), {}};
    pair.split = split_of(kind, all, pair.whole.temperature);
    add(pair.whole.findings, estimate);
    add(pair.split.findings, estimate);
    estimate.fit.observations += 2 * terms;
    pairs.push_back(std::move(pair));
  }
  add(all.findings, estimate);
  add_parameters(pairs, estimate);
  add_comparison(pairs, all, estimate);
  estimate.tables.insert(estimate.tables.end(), {side_by_side(pairs, estimate)});
  estimate.models = models_of(pairs, all.whole, estimate);
  add_agreement(pairs, evidence.plan.settings, estimate);
  return estimate;
}

}  // namespace

extern const Method imu_channel_calibration{
    .name = "imu_channel_calibration",
    .summary = "channels of an IMU calibrated alone before assembly, against the calibration of the whole unit",
    .source =
        "Lu Hanjie, Liu Yabin, Zhou Qiang, dynamic test of linear accelerometers based on INS pulse counting, 2019, "
        "eq. (3)-(8), figure 12, table 2",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .several_instruments = true,
    .takes_prior = true};

}  // namespace tumble::imu_channel_calibration

#include "tumble/earth/earth.hpp"
#include "tumble/methods/imu_channel_calibration/compare.hpp"
#include "tumble/methods/imu_channel_calibration/compensate.hpp"
#include "tumble/methods/imu_channel_calibration/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/units/error.hpp"

// Symbols of the source: A compensated output, N pulses in a window H, K_m reference scale factor, dK scale errors, E
// installation errors, nabla bias.

namespace tumble::imu_channel_calibration {
namespace {

std::vector<Role> roles() {
  std::vector<Role> all;
  for (const char* letter : {"x", "y", "z"})
    all.push_back(
        {std::string("accelerometer_") + letter, "", false,
         std::string("accelerometer along ") + letter + ", of the unit or alone: pulses, specific force, mA, V"});
  for (const char* letter : {"x", "y", "z"})
    all.push_back({std::string("gyro_") + letter, "", false,
                   std::string("gyro along ") + letter + ", of the unit or alone: pulses or angular rate"});
  all.push_back({"temperature", "degC", false, "temperature of the unit, or of the channel alone"});
  return all;
}

std::vector<Option> options() {
  using Type = Option::Type;
  auto options = linear::options("2 s", "10 s");
  const auto add = [&](const char* name, Type type, const char* unit, const char* fallback, const char* description) {
    options.push_back({name, type, unit, fallback, {}, description});
  };
  for (auto& option : imu::scale_factor_options()) options.push_back(std::move(option));
  for (const auto& [kind, unit] : {std::pair{imu::Kind::gyro, "deg/h"}, {imu::Kind::accelerometer, "ug"}})
    options.push_back(linear::bias_instability_option(unit, imu::prefix_of(kind)));
  options.push_back({"order",
                     Type::word,
                     "1",
                     "auto",
                     {"auto", "0", "1", "2"},
                     "highest power of T where an accelerometer alone was tested at several temperatures"});
  add("same_temperature", Type::quantity, "K", "2 K", "temperatures closer than this are one");
  add("assembly_sd", Type::quantity, "arcsec", "120 arcsec",
      "standard uncertainty of each angle E of the assembled channels, which are taken as 0");
  add("check", Type::text, "1", "check",
      "segments of the whole unit whose label begins so are for the comparison alone");
  add("bias_tolerance", Type::quantity, "ug", "0 ug", "by which biases of accelerometers may differ besides");
  add("gyro_bias_tolerance", Type::quantity, "deg/h", "0 deg/h", "by which biases of gyros may differ besides");
  add("scale_factor_tolerance", Type::quantity, "ppm", "0 ppm", "by which scale factors may differ besides");
  add("misalignment_tolerance", Type::quantity, "arcsec", "0 arcsec", "by which angles may differ besides");
  return options;
}

/// Gravity was measured once for all where every plan states the same.
bool same_gravity(const Evidence& evidence) {
  for (const auto& plan : evidence.plans)
    if (plan && (!plan->site || !evidence.plan.site || gravity(*plan->site) != gravity(*evidence.plan.site)))
      return false;
  return true;
}

void keep(const Findings& from, Estimate& estimate) {
  for (const auto& finding : from) estimate.findings.push_back(finding);
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Sorted all = sorted(evidence);
  Estimate estimate;
  estimate.method = "imu_channel_calibration";
  std::vector<Pair> pairs;
  for (const Kind kind : kinds) {
    if (kind == Kind::gyro && !all.gyros) continue;
    report(progress, 0.5 * static_cast<double>(pairs.size()), "calibrating");
    Pair pair{kind, whole_of(kind, all.whole), {}};
    pair.split = split_of(kind, all, pair.whole.temperature);
    keep(pair.whole.findings, estimate);
    keep(pair.split.findings, estimate);
    estimate.fit.observations += 2 * terms;
    pairs.push_back(std::move(pair));
  }
  keep(all.findings, estimate);
  add_parameters(pairs, same_gravity(evidence), estimate);
  estimate.tables = {comparison(pairs, all, estimate.findings), side_by_side(pairs, estimate), covered(pairs)};
  add_agreement(pairs, evidence.plan.settings, estimate);
  return estimate;
}

Compensation compensated(const Estimate& estimate, const Recording& recording, const Plan* plan) {
  return compensate(estimate, recording, plan, options());
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
    .trial = trial,
    .compensate = compensated,
    .predict = nullptr,
    .several_instruments = true};

}  // namespace tumble::imu_channel_calibration

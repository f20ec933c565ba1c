#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/methods/method.hpp"

namespace tumble::imu_turntable {
namespace {

std::vector<Role> roles() {
  std::vector<Role> all;
  for (const imu::Kind kind : {imu::Kind::gyro, imu::Kind::accelerometer})
    for (std::size_t axis = 0; axis < 3; ++axis)
      all.push_back({imu::role_of(kind, axis), "", false,
                     kind == imu::Kind::gyro
                         ? "gyro: angular rate, angle gained in each sample, or pulses"
                         : "accelerometer: specific force, velocity gained in each sample, or pulses"});
  return all;
}

std::vector<Option> options() {
  auto options = linear::options("2 s", "10 s");
  for (auto& option : imu::scale_factor_options()) options.push_back(std::move(option));
  for (const auto& [kind, unit] : {std::pair{imu::Kind::gyro, "deg/h"}, {imu::Kind::accelerometer, "ug"}})
    options.push_back(linear::bias_instability_option(unit, imu::prefix_of(kind)));
  return options;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  report(progress, 0.0, "looking at the segments");
  const auto task = task_of(evidence);
  auto faults = faults_of(evidence, task);
  report(progress, 0.2, "all outputs together");
  auto estimate = answer_of(task, linear::identify(evidence, task.problems));
  for (auto& fault : faults) estimate.findings.push_back(std::move(fault));
  return estimate;
}

Estimate predict(const Plan& plan) {
  const auto task = task_of(plan);
  std::vector<linear::Truth> truths;
  for (const auto& problem : task.problems) truths.push_back(linear::truth_of(plan, problem.role));
  return answer_of(task, linear::predict(plan, task.problems, truths));
}

}  // namespace

extern const Method imu_turntable{
    .name = "imu_turntable",
    .summary = "full calibration of an IMU on a one-, two- or three-axis table, from any schedule",
    .source =
        "linear sensor models as in Yan Gongmin, lecture on modelling gyros and accelerometers, NWPU, 2015; "
        "all outputs in one generalised least squares with the errors of the table as random effects",
    .needs_plan = true,
    .roles = roles,
    .options = options,
    .identify = identify,
    .compensates = true,
    .predict = predict,
    .takes_prior = true};

}  // namespace tumble::imu_turntable

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "tumble/earth/earth.hpp"
#include "tumble/methods/imu_multi_position/compensate.hpp"
#include "tumble/methods/imu_multi_position/describe.hpp"
#include "tumble/methods/imu_multi_position/faults.hpp"
#include "tumble/methods/imu_multi_position/guidance.hpp"
#include "tumble/methods/imu_multi_position/trial.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/linear/linear.hpp"
#include "tumble/reduce/rig_effects.hpp"
#include "tumble/rigs/error_names.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_multi_position {
namespace {

std::vector<Role> roles() {
  std::vector<Role> all;
  for (const char letter : letters)
    all.push_back({fmt::format("accelerometer_{}", letter), "",
                   false,  // not in every recording, if gyros have their own
                   fmt::format("accelerometer along {}: specific force, velocity increments or raw counts", letter)});
  for (const char letter : letters)
    all.push_back({fmt::format("gyro_{}", letter), "", false,
                   fmt::format("gyro along {}: angular rate, angle increments or raw counts", letter)});
  return all;
}

std::vector<Option> options() {
  using Type = Option::Type;
  return {
      {"gravity", Type::quantity, "m/s^2", "", {}, "where the test took place; absent: that of [site]"},
      {"gravity_sd",
       Type::quantity,
       "ug",
       "",
       {},
       "standard uncertainty of gravity; absent: as the rig by_hand has it, 30 ug without a rig"},
      {"latitude", Type::quantity, "deg", "", {}, "for the rotation of the Earth; absent: that of [site]"},
      {"window", Type::quantity, "s", "0.5 s", {}, "over which the variance is taken that tells rest from motion"},
      {"rest_least", Type::quantity, "s", "1 s", {}, "shortest rest that is used"},
      {"initial_rest",
       Type::quantity,
       "s",
       "",
       {},
       "time at the beginning known to be at rest, for the noise level; absent: the quietest fifth of the recording"},
      {"acceleration_sensitivity",
       Type::flag,
       "1",
       "true",
       {},
       "whether the drift of the gyros with the specific force is sought"},
      linear::bias_instability_option("deg/h", "gyro_"),
      linear::bias_instability_option("ug", "accelerometer_"),
      {"up",
       Type::word,
       "1",
       "unknown",
       {"unknown", "x", "-x", "y", "-y", "z", "-z"},
       "axis that points up at the first rest, to check the sign of the accelerometers; unknown: as a plan of by_hand "
       "says"},
  };
}

double or_else(const Settings& settings, const char* name, double otherwise) {
  return settings.has(name) ? settings.number(name) : otherwise;
}

Surroundings surroundings_of(const Plan& plan) {
  const Settings& settings = plan.settings;
  Surroundings around;
  std::vector<std::string> problems;
  if (settings.has("gravity")) {
    around.gravity = settings.number("gravity"), around.gravity_from = "as stated";
  } else if (plan.site) {
    around.gravity = gravity(*plan.site);
    around.gravity_from = plan.site->gravity ? "as stated for the site" : "normal gravity at the site";
  } else {
    problems.push_back(
        "gravity is what accelerometers are calibrated against: --set gravity=\"9.81 m/s^2\", or [site] in a plan");
  }
  const double of_rig = rig_sd(plan, error_names::gravity).value_or(si(30.0, "ug"));
  around.gravity_sd = or_else(settings, "gravity_sd", of_rig);
  if (settings.has("latitude"))
    around.latitude = settings.number("latitude");
  else if (plan.site)
    around.latitude = plan.site->latitude;
  if (!(around.gravity > 5.0 && around.gravity < 15.0))
    problems.push_back(fmt::format("gravity {:.4g} m/s^2 is not of this planet", around.gravity));
  around.gyro_instability = linear::stated_bias_instability(settings, "gyro_", problems);
  around.accelerometer_instability = linear::stated_bias_instability(settings, "accelerometer_", problems);
  if (around.gravity_sd < 0.0) problems.push_back("gravity_sd must not be negative");
  for (const char* name : {"window", "rest_least"})
    if (!(settings.number(name) > 0.0)) problems.push_back(fmt::format("{} must be positive", name));
  if (!problems.empty()) throw Error(Error::Kind::bad_input, std::move(problems));
  return around;
}

/// Too few rests, or too few ways up: with what to add.
void require_poses(const Rests& rests, double gravity) {
  std::vector<Vector3d> means, directions;
  for (const Rest& rest : rests.all)
    if (rest.used()) means.push_back(rest.force);
  const auto sphere = fit_sphere(means, gravity);
  constexpr std::size_t fewest = 12;
  if (sphere && means.size() >= fewest) return;
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  for (const auto& mean : means) low = low.cwiseMin(mean), high = high.cwiseMax(mean);
  for (const auto& mean : means) {
    const Vector3d from = sphere
                              ? Vector3d(sphere->accelerometer.matrix.inverse() * (mean - sphere->accelerometer.bias))
                          : means.size() < 4 ? mean
                                             : Vector3d(mean - 0.5 * (low + high));
    if (from.norm() > 0.0) directions.push_back(from.normalized());
  }
  const std::string lacking = missing(directions);
  throw Error(
      Error::Kind::bad_data,
      fmt::format("{} at rest {} found: nine coefficients of the accelerometers need 12 and more, with every axis up "
                  "and down{}; a rest lasts {:g} s or longer (rest_least) between moves",
                  means.size() == 1 ? "only one stretch" : fmt::format("{} stretches", means.size()),
                  means.size() == 1 ? "was" : "were", lacking.empty() ? "" : "; lay it also with these up: " + lacking,
                  1.0));
}

/// When the first rest of the plan is over [s]; without a plan, never.
double first_end(const Evidence& evidence) {
  const Recording& recording = evidence.recordings.front();
  if (recording.marks.size() > 1) return recording.marks[1].begin;
  return std::numeric_limits<double>::infinity();
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Surroundings around = surroundings_of(evidence.plan);
  const Settings& settings = evidence.plan.settings;
  const auto sessions = sessions_of(evidence);
  report(progress, 0.1, "looking for rests");
  RestOptions how{settings.number("window"), settings.number("rest_least"), or_else(settings, "initial_rest", 0.0)};
  Rests rests = find_rests(sessions, how, around.gravity);
  require_poses(rests, around.gravity);
  FitOptions options{.gravity = around.gravity};
  options.sensitivity = settings.flag("acceleration_sensitivity");
  options.latitude = around.latitude;
  report(progress, 0.3, "calibrating");
  const Fit fit = fit_all(sessions, rests, options);
  const auto planned = planned_up(evidence.plan);
  if (planned && rests.all[fit.chain.front()].begin < first_end(evidence)) check_up(fit.direction.front(), *planned);
  report(progress, 0.9, "describing");
  return describe(sessions, rests, fit, around);
}

Trial trial_of(std::uint64_t seed) { return imu_multi_position::trial(seed, options()); }

}  // namespace

extern const Method imu_multi_position{
    .name = "imu_multi_position",
    .summary = "IMU without a table, moved by hand between rests: bias, scale factor and misalignment of both triads",
    .source =
        "D. Tedaldi, A. Pretto, E. Menegatti, A robust and easy to implement method for IMU calibration without "
        "external equipments, ICRA 2014 (the procedure)",
    .needs_plan = false,
    .roles = roles,
    .options = options,
    .identify = identify,
    .trial = trial_of,
    .compensate = compensate,
    .predict = nullptr};

}  // namespace tumble::imu_multi_position

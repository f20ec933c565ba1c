#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <string_view>

#include "tumble/checks/check.hpp"
#include "tumble/earth/earth.hpp"
#include "tumble/language/say.hpp"
#include "tumble/methods/imu_multi_position/describe.hpp"
#include "tumble/methods/imu_multi_position/faults.hpp"
#include "tumble/methods/method.hpp"
#include "tumble/reduce/imu/sensors.hpp"
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
  return {
      quantity("gravity", "m/s^2").between(5, 15).says("local gravity; absent: that of [site]"),
      quantity("gravity_sd", "ug")
          .at_least(0)
          .says("standard uncertainty of gravity; absent: that of the rig by_hand or of [site], 30 ug where a setting "
                "states "
                "gravity"),
      quantity("latitude", "deg").between(-90, 90).says("for the rotation of the Earth; absent: that of [site]"),
      quantity("window", "s")
          .above(0)
          .otherwise("0.5 s")
          .says("time over which the variance is calculated that distinguishes rest from motion"),
      quantity("rest_least", "s").above(0).otherwise("1 s").says("shortest rest that is used"),
      quantity("initial_rest", "s")
          .at_least(0)
          .says("time at the beginning in which the unit is at rest: the noise level is calculated from it; absent: "
                "from the quietest fifth of the recording"),
      flag("acceleration_sensitivity")
          .otherwise("true")
          .says("whether the drift of the gyros with the specific force is estimated"),
      linear::bias_instability_option("deg/h", "gyro_"),
      linear::bias_instability_option("ug", "accelerometer_"),
      word("up", {"unknown", "x", "-x", "y", "-y", "z", "-z"})
          .otherwise("unknown")
          .says("axis that points up at the first rest, to check the sign of the accelerometers; unknown: the axis "
                "by the plan of the rig by_hand, if there is one")};
}

double or_else(const Settings& settings, const char* name, double otherwise) {
  return settings.has(name) ? settings.number(name) : otherwise;
}

/// Standard uncertainty of gravity [m/s^2] where no setting states it.
double sd_of_gravity(const Plan& plan) {
  if (plan.rig.has("gravity_sd")) return plan.rig.number("gravity_sd");
  if (plan.settings.has("gravity") || !plan.site) return si(30.0, "ug");
  return rig_sd(plan, error_names::gravity).value_or(gravity_sd(plan.site));
}

Surroundings surroundings_of(const Plan& plan) {
  const Settings& settings = plan.settings;
  Surroundings surroundings;
  Problems problems;
  if (settings.has("gravity")) {
    surroundings.gravity = settings.number("gravity"), surroundings.gravity_from = {"stated"};
  } else if (plan.site) {
    surroundings.gravity = gravity(*plan.site);
    surroundings.gravity_from = {plan.site->gravity ? "stated_for_the_site" : "normal_gravity_at_the_site"};
  } else {
    problems.emplace_back(
        "gravity is the reference of the accelerometers: state it, --set gravity=\"9.81 m/s^2\", or [site] in a plan");
  }
  surroundings.gravity_key = gravity_key(surroundings.gravity);
  surroundings.gravity_sd = or_else(settings, "gravity_sd", sd_of_gravity(plan));
  if (settings.has("latitude"))
    surroundings.latitude = settings.number("latitude");
  else if (plan.site)
    surroundings.latitude = plan.site->latitude, surroundings.latitude_sd = latitude_sd(*plan.site);
  surroundings.gyro_instability = linear::stated_bias_instability(settings, "gyro_");
  surroundings.accelerometer_instability = linear::stated_bias_instability(settings, "accelerometer_");
  if (!problems.empty()) throw Error(Error::Kind::bad_input, std::move(problems));
  return surroundings;
}

/// Directions up of these means at rest, approximate: without a calibration.
std::vector<Vector3> directions_of(const std::vector<Vector3>& means) {
  const Vector3 middle = means.size() < 4 ? Vector3{} : box_of(means).middle();
  std::vector<Vector3> directions;
  for (const Vector3& mean : means) {
    const Vector3 from = mean - middle;
    if (norm(from) > 0.0) directions.push_back(normalised(from));
  }
  return directions;
}

/// Refuses too few rests or too few directions, and names those to add. Given: gravity [m/s^2], least duration [s].
void require_poses(const Rests& rests, double gravity, double rest_least) {
  std::vector<Vector3> means;
  for (const Rest& rest : rests.all)
    if (rest.used()) means.push_back(rest.force);
  if (fit_sphere(means, gravity)) return;
  const std::string lacking = missing(directions_of(means)), least = say_seconds(rest_least);
  const Sentence lay = lacking.empty() ? Sentence() : say("; lay it also with these up: {}", Name{lacking});
  throw Error(Error::Kind::bad_data,
              means.size() == 1
                  ? say("only one stretch at rest was found: nine coefficients of the accelerometers need 12 and more, "
                        "with every axis up and down{}; a rest lasts {} or longer (rest_least) between moves",
                        lay, Name{least})
                  : say("{} stretches at rest were found: nine coefficients of the accelerometers need 12 and more, "
                        "with every axis up and down{}; a rest lasts {} or longer (rest_least) between moves",
                        means.size(), lay, Name{least}));
}

/// End of the first rest of the plan [s]; infinite without a plan.
double first_end(const Evidence& evidence) {
  const Recording& recording = evidence.recordings.front();
  if (recording.marks.size() > 1) return recording.marks[1].begin;
  return std::numeric_limits<double>::infinity();
}

/// Accelerometers whose steps are greater than their noise: each rest is off by a part of a step of its own, which the
/// scatter between rests shows. The bias of a gyro is that of one rest.
Findings about_rounding(const Evidence& evidence) {
  const auto check = std::ranges::find(check_catalogue(), std::string_view("coarse_steps"), &Check::name);
  Findings findings;
  for (const Recording& recording : evidence.recordings)
    for (const Finding& coarse : (*check)->run(recording, &evidence.plan))
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Channel* channel = channel_for(evidence, recording, imu::role_of(imu::Kind::accelerometer, axis));
        if (channel == nullptr || channel->name != coarse.where || channel->kind == QuantityKind::count) continue;
        const FindingValue& step = coarse.values.front();
        findings.push_back({Finding::Severity::info,
                            "rests_show_rounding",
                            {{"step", std::get<double>(step.value), step.unit}},
                            coarse.where});
      }
  return findings;
}

/// Stamps that contradict the rate that the plan states, where the scale factors of the gyros would differ by more than
/// what they are uncertain by: turns are rates over the time that the stamps show.
Findings about_clock(const Evidence& evidence, const Estimate& estimate) {
  constexpr double matters = 3.0;  // [sd] of the best known scale factor
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](const std::string& name, double one) {
    const Parameter* scale = find_parameter(estimate, name);
    if (scale == nullptr) return;
    const auto index = static_cast<std::size_t>(scale - estimate.parameters.data());
    least = std::min(least, standard_uncertainty(estimate, index) / std::abs(one + scale->value));
  };
  for (const char letter : letters) {
    take(fmt::format("gyro_{}_scale_factor_error", letter), 1.0);
    take(fmt::format("gyro_{}_scale_factor", letter), 0.0);
  }
  Findings findings;
  const double stated = evidence.plan.reading.rate.value_or(evidence.plan.sample_rate);
  if (!(stated > 0.0)) return findings;
  for (const Recording& recording : evidence.recordings)
    for (const Finding& rate : against_stated_rate(recording, stated)) {
      const double found = std::get<double>(rate.values[0].value), difference = found / stated - 1.0;
      if (std::abs(difference) > matters * least)
        findings.push_back({Finding::Severity::warning,
                            "clock_moves_scale_factors",
                            {{"rate", found, "Hz"},
                             {"stated", stated, "Hz"},
                             {"difference", difference, "ppm"},
                             {"times", std::abs(difference) / least}},
                            recording.origin.file});
    }
  return findings;
}

Estimate identify(const Evidence& evidence, const Progress& progress) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  const Surroundings surroundings = surroundings_of(evidence.plan);
  const Settings& settings = evidence.plan.settings;
  const auto sessions = sessions_of(evidence);
  report(progress, 0.1, "looking for rests");
  RestOptions how{settings.number("window"), settings.number("rest_least"), or_else(settings, "initial_rest", 0.0)};
  Rests rests = find_rests(sessions, how, surroundings.gravity);
  require_poses(rests, surroundings.gravity, how.least);
  FitOptions options{.gravity = surroundings.gravity};
  options.sensitivity = settings.flag("acceleration_sensitivity");
  options.latitude = surroundings.latitude;
  options.latitude_sd = surroundings.latitude_sd;
  report(progress, 0.3, "calibrating");
  const Fit fit = fit_all(sessions, rests, options);
  const auto planned = planned_up(evidence.plan);
  if (planned && rests.all[fit.chain.front()].begin < first_end(evidence)) check_up(fit.direction.front(), *planned);
  report(progress, 0.9, "describing");
  Estimate estimate = describe(sessions, rests, fit, surroundings);
  std::ranges::move(about_rounding(evidence), std::back_inserter(estimate.findings));
  std::ranges::move(about_clock(evidence, estimate), std::back_inserter(estimate.findings));
  return estimate;
}

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
    .compensates = true};

}  // namespace tumble::imu_multi_position

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tumble/math/golden_section.hpp"
#include "tumble/methods/imu_turntable/turntable.hpp"
#include "tumble/reduce/linear/rows.hpp"
#include "tumble/units/error.hpp"

namespace tumble::imu_turntable {
namespace {

using imu::letters;
using imu::role_of;

constexpr double greatest_condition = 1e4;  ///< axes known to 1e-4: a weaker combination is made of their errors

constexpr double even_within = 0.1;  ///< [1] of the mean, that the input of an even segment stays within

/// |w|^2 + |dw/dt| below which a lever of 1 m gives less than 0.1 mg.
constexpr double least_turning = 1e-3;
constexpr std::size_t instants = 24;  ///< in a segment that moves

double most(double so_far, double value) { return std::max(so_far, std::abs(value)); }

void widen(Vector3& by, Vector3 with) { by = {most(by.x, with.x), most(by.y, with.y), most(by.z, with.z)}; }

bool holds(const Segment& segment) {
  return std::ranges::all_of(segment.axes, [](const auto& axis) {
    return axis.second.kind == Motion::Kind::hold || axis.second.kind == Motion::Kind::dwell;
  });
}

/// Angle between the axes and the plan at the end of a segment by one standard deviation of their rate error [rad].
double run_away_in(const PowerUp& power_up, const Stretch& stretch) {
  const Settings& rig = power_up.plan->rig;
  if (!rig.has("rate_error_sd") || (rig.has("ideal") && rig.flag("ideal"))) return 0.0;
  double angle = 0.0;
  for (const auto& [name, motion] : power_up.rig.segments[stretch.segment].axes)
    if (motion.kind == Motion::Kind::rate) angle = std::max(angle, std::abs(motion.value));
  return angle * rig.number("rate_error_sd") * stretch.duration();
}

/// Adds a stretch by instants in it that are not in step with any motion.
void look_at(const PowerUp& power_up, const Stretch& stretch, Look& look) {
  const std::size_t count = stretch.steady ? 1 : instants;
  const double length = stretch.duration();
  std::array<Felt, instants> all;
  Vector3 rate, force;
  for (std::size_t k = 0; k < count; ++k) {
    Felt& felt = all[k];
    power_up.reference.felt(stretch.first + length * golden_fraction(k, 0.5), stretch.step, std::span(&felt, 1));
    rate = rate + felt.rate;
    force = force + felt.specific_force;
    look.turning = std::max(look.turning, dot(felt.rate, felt.rate) + norm(felt.angular_acceleration));
    widen(look.fastest, felt.rate);
    widen(look.strongest, felt.specific_force);
  }
  look.labels.push_back(stretch.label);
  look.places.push_back({stretch.recording, stretch.power_up, stretch.segment});
  rate = 1.0 / static_cast<double>(count) * rate;
  force = 1.0 / static_cast<double>(count) * force;
  const auto even = [&](Vector3 Felt::*field, Vector3 mean) {
    return std::ranges::all_of(std::span(all).first(count),
                               [&](const Felt& felt) { return norm(felt.*field - mean) <= even_within * norm(mean); });
  };
  look.even_rate.push_back(even(&Felt::rate, rate));
  look.even_force.push_back(even(&Felt::specific_force, force));
  if (!look.even_force.back()) look.run_away = std::max(look.run_away, run_away_in(power_up, stretch));
  look.rate.push_back(rate);
  look.force.push_back(force);
  look.at_rest.push_back(holds(power_up.rig.segments[stretch.segment]));
}

Look look_over(const ConductedTest& test) {
  Look look;
  for (const auto& stretch : test.stretches) look_at(test.power_ups[stretch.power_up], stretch, look);
  return look;
}

/// Columns of one output, and the order in which they are dropped where the schedule cannot distinguish all.
void set_terms(Kind kind, std::size_t axis, Task& task, linear::Problem& problem) {
  auto terms = terms_of(kind, axis);
  const bool levers = task.look.turning > least_turning;
  std::vector<std::string> names;
  for (const OutputTerm& term : terms)
    (levers || term.kind != TermKind::lever ? names : task.not_shown).push_back(term.name);
  problem.columns = linear::terms_of("imu", defaults(find_model("imu").constants()), names);
  std::erase_if(terms, [&](const OutputTerm& term) {
    return term.kind == TermKind::bias || (term.kind == TermKind::lever && !levers);
  });
  // a lever along the axis itself is what turning shows first
  std::ranges::stable_sort(terms, {}, [&](const OutputTerm& term) {
    return std::pair{term.kind, term.kind == TermKind::lever && term.axis == axis};
  });
  for (const OutputTerm& term : terms) problem.leave_out_first.push_back(term.name);
}

linear::Problem problem_of(Kind kind, std::size_t axis, const Settings& settings, const imu::Reading& reading) {
  linear::Problem problem;
  problem.role = role_of(kind, axis);
  problem.scale = reading.scale;
  problem.pulse = reading.pulse;
  problem.input = [=](const Felt& felt) { return imu::component(imu::field_of(kind, felt), axis); };
  problem.condition_limit = greatest_condition;
  problem.even_averages = true;
  linear::set_options(settings, problem, imu::prefix_of(kind));
  return problem;
}

void complete(Task& task) {
  std::size_t i = 0;
  for (const Kind kind : task.kinds)
    for (std::size_t axis = 0; axis < 3; ++axis) set_terms(kind, axis, task, task.problems[i++]);
}

/// The kinds that all recordings have in full.
std::vector<Kind> kinds_of(const Evidence& evidence) {
  std::vector<Kind> kinds;
  Problems problems;
  for (const Kind kind : {Kind::gyro, Kind::accelerometer}) {
    std::vector<std::string> missing;
    for (const auto& recording : evidence.recordings)
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (const auto role = role_of(kind, axis);
            !channel_for(evidence, recording, role) && std::ranges::find(missing, role) == missing.end())
          missing.push_back(role);
    if (missing.empty()) kinds.push_back(kind);
    if (!missing.empty() && missing.size() < 3)
      problems.push_back(say("no channel plays {}: a triad needs all three; name the column under [channels]",
                             fmt::join(missing, ", ")));
  }
  if (kinds.empty() && problems.empty())
    problems.push_back(
        "the recording has neither gyro_x, gyro_y, gyro_z nor accelerometer_x, accelerometer_y, "
        "accelerometer_z: name the columns under [channels]");
  if (!problems.empty()) throw Error(Error::Kind::bad_data, problems);
  return kinds;
}

/// A reading that no unit is needed for: all that a prediction must know is the pulse.
imu::Reading predicted_reading(Kind kind, const Settings& truth) {
  const std::string prefix = imu::prefix_of(kind);
  if (!truth.has(prefix + "output") || truth.word(prefix + "output") != "count") return {};
  if (!truth.has(prefix + "pulse_scale_factor") || truth.number(prefix + "pulse_scale_factor") == 0.0)
    throw Error(Error::Kind::bad_input,
                say("[truth] {0}output = \"count\" needs {0}pulse_scale_factor, not zero", Name{prefix}));
  return {1.0, 1.0 / std::abs(truth.number(prefix + "pulse_scale_factor"))};
}

}  // namespace

std::vector<OutputTerm> terms_of(Kind kind, std::size_t axis) {
  const std::string role = role_of(kind, axis);
  std::vector<OutputTerm> terms{{role + "_bias", TermKind::bias, axis},
                                {role + "_scale_factor_error", TermKind::scale_factor, axis}};
  const auto add_along = [&](const char* name, TermKind of, bool own_too) {
    for (std::size_t j = 0; j < 3; ++j)
      if (own_too || j != axis) terms.push_back({fmt::format("{}_{}_{}", role, name, letters[j]), of, j});
  };
  add_along("misalignment", TermKind::misalignment, false);
  if (kind == Kind::gyro) {
    add_along("acceleration_sensitivity", TermKind::sensitivity, true);
  } else {
    terms.push_back({role + "_second_order_coefficient", TermKind::second_order, axis});
    add_along("lever", TermKind::lever, true);
  }
  return terms;
}

Task task_of(const Evidence& evidence) {
  if (evidence.recordings.empty()) throw Error(Error::Kind::bad_data, "there is no recording to identify from");
  Task task;
  task.kinds = kinds_of(evidence);
  for (const Kind kind : task.kinds)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Channel& channel = require_channel(evidence, evidence.recordings.front(), role_of(kind, axis));
      task.problems.push_back(
          problem_of(kind, axis, evidence.plan.settings, imu::reading_of(kind, evidence.plan.settings, channel)));
    }
  task.look = look_over(linear::evidence_of(evidence, task.problems.front()).test);
  complete(task);
  return task;
}

Task task_of(const Plan& plan) {
  Task task;
  for (const Kind kind : {Kind::gyro, Kind::accelerometer}) {
    std::size_t matching = 0;
    for (const auto& output : find_model(plan.instrument_model).outputs(plan.truth))
      for (std::size_t axis = 0; axis < 3; ++axis) matching += output.channel == role_of(kind, axis);
    if (matching == 3) task.kinds.push_back(kind);
  }
  if (task.kinds.empty())
    throw Error(Error::Kind::bad_input, say("the model {} has neither three gyros nor three accelerometers: "
                                            "imu and triad do",
                                            Name{plan.instrument_model}));
  for (const Kind kind : task.kinds)
    for (std::size_t axis = 0; axis < 3; ++axis)
      task.problems.push_back(problem_of(kind, axis, plan.settings, predicted_reading(kind, plan.truth)));
  task.look = look_over(linear::evidence_of(plan, task.problems.front()).test);
  complete(task);
  return task;
}

}  // namespace tumble::imu_turntable

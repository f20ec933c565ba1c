#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "tumble/methods/dtg_centrifuge/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

// What the first trial holds at zero or ideal: both orientations of the spin axis and both senses of the arm, another
// site and radius, a capture loop that the plan does not state, samples that are means, both outputs, a level that is
// repeated, a gap, outliers; the sign of every coefficient is turned, and no term of a^2 is clearly there.
namespace tumble::dtg_centrifuge {
namespace {

constexpr double second_rates[] = {140, 205, 300, 410, 590};  // deg/s
constexpr double second_radius = 1.8, second_gravity = 9.797;
constexpr double loop_frequency = 40.0, loop_damping = 0.6;  // Hz
constexpr TruthValue drift_x[] = {
    {"D_F", -3, "deg/h"},          {"D_x", -4, "deg/h/g"},         {"D_y", 3.5, "deg/h/g"},
    {"D_xz", -0.2, "deg/h/g^2"},   {"D_yz", 0.1, "deg/h/g^2"},     {"D_xx", -0.03, "deg/h/g^2"},
    {"D_yy", 0.02, "deg/h/g^2"},   {"D_xy", -0.02, "deg/h/g^2"},   {"D_xxx", -1e-4, "deg/h/g^3"},
    {"D_xyy", -2e-4, "deg/h/g^3"}, {"D_yyy", 1.5e-4, "deg/h/g^3"}, {"D_yxx", -1e-4, "deg/h/g^3"}};
constexpr TruthValue drift_y[] = {
    {"y_D_F", 5, "deg/h"},        {"y_D_x", -3.5, "deg/h/g"},      {"y_D_y", -4, "deg/h/g"},
    {"y_D_xz", 0.1, "deg/h/g^2"}, {"y_D_yz", -0.2, "deg/h/g^2"},   {"y_D_xxx", 2e-4, "deg/h/g^3"},
    {"y_D_xyy", 0, "deg/h/g^3"},  {"y_D_yyy", -3e-4, "deg/h/g^3"}, {"y_D_yxx", 0, "deg/h/g^3"}};

Motion turned_by(Motion::Kind kind, double degrees) {
  Motion out;
  out.kind = kind;
  out.value = si(degrees, "deg");
  return out;
}

/// Runs 1 and 2 with the spin axis up, 3 and 4 with it down; the even ones turn the other way.
void add_runs(Plan& plan) {
  for (int run = 1; run <= 4; ++run) {
    const double sense = run % 2 == 0 ? -1.0 : 1.0;
    const Motion roll = turned_by(Motion::Kind::hold, run > 2 ? 180.0 : 0.0);
    const Motion still = turned_by(Motion::Kind::hold, 0.0);
    plan.schedule.push_back({"static", 10.0, run, {{"arm", still}, {"table", still}, {"mount_roll", roll}}});
    const auto spin = [&](const std::string& label, double rate) {
      plan.schedule.push_back({label,
                               40.0,
                               run,
                               {{"arm", turned_by(Motion::Kind::rate, sense * rate)},
                                {"table", turned_by(Motion::Kind::rate, sense * (50.0 - rate))},
                                {"mount_roll", roll}}});
    };
    for (const double rate : second_rates) spin(fmt::format("{:g} deg/s", rate), rate);
    if (run == 1) spin("410 deg/s again", 410.0);
  }
}

Plan second_plan(const std::vector<Option>& options) {
  Plan plan = trial_plan("dtg_centrifuge", options, "dynamically_tuned_gyro", "counter_rotating_centrifuge", 25.0);
  plan.site = Site{si(-33.9, "deg"), si(18.6, "deg"), 40.0, second_gravity};
  plan.rig.set_number("radius", second_radius, Unit::parse("m"));
  for (const char* name : {"arm_max_acceleration", "table_max_acceleration"})
    plan.rig.set_number(name, si(400.0, "deg/s^2"), Unit::parse("deg/s^2"));
  set_truth(plan, drift_x);
  set_truth(plan, drift_y);
  set_truth(plan, "angle_random_walk", 0.003, "deg/sqrt(h)");
  set_truth(plan, "natural_frequency", loop_frequency, "Hz");
  set_truth(plan, "damping_ratio", loop_damping, "1");
  plan.truth.set_integer("oversampling", 8);
  plan.channels["reference_gyro"] = {{"fog.gyro", {}}};
  Beside fog{"fog", "fiber_optic_gyro", defaults(truth_options(find_model("fiber_optic_gyro")))};
  fog.truth.set_number("scale_factor_error", si(-3000.0, "ppm"), Unit::parse("ppm"));
  fog.truth.set_number("gamma_y", si(-2.0, "deg"), Unit::parse("arcsec"));
  fog.truth.set_number("gamma_z", si(-0.1, "deg"), Unit::parse("arcsec"));
  fog.truth.set_number("angle_random_walk", si(0.001, "deg/sqrt(h)"), Unit::parse("deg/sqrt(h)"));
  plan.beside.push_back(std::move(fog));
  add_runs(plan);
  return plan;
}

/// Three seconds of the gyro are lost in run 2, and four samples of the reference are knocks.
void damage(Recording& recording) {
  Channel *gyro = nullptr, *reference = nullptr;
  for (Channel& channel : recording.channels) {
    if (channel.name == "gyro") gyro = &channel;
    if (channel.name == "fog.gyro") reference = &channel;
  }
  const std::size_t lost = index_at(*gyro, recording.marks[9].begin) + 500;
  for (std::size_t i = lost; i < lost + 75; ++i) gyro->values[i] = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < 4; ++k)
    reference->values[index_at(*reference, recording.marks[3 * k + 2].begin) + 700] += si(40.0, "deg/h");
}

double of(std::span<const TruthValue> drift, const std::string& name) {
  for (const TruthValue& one : drift)
    if (name == one.name) return one.value;
  return 0.0;
}

/// K [deg/h/g] at a [g] with the spin axis up (+1) or down (-1).
double sensitivity_at(double a, double spin) {
  const double along = spin * second_gravity / standard_gravity;
  const auto part = [&](const char* linear, const char* cross, const char* cubic, const char* mixed) {
    return of(drift_x, linear) + along * of(drift_x, cross) +
           (0.75 * of(drift_x, cubic) + 0.25 * of(drift_x, mixed)) * a * a;
  };
  return std::hypot(part("D_x", "D_xz", "D_xxx", "D_xyy"), part("D_y", "D_yz", "D_yyy", "D_yxx"));
}

void add_levels_truth(Trial& trial) {
  const auto force = [](double rate) { return std::pow(si(rate, "deg/s"), 2) * second_radius / standard_gravity; };
  std::size_t level = 1;
  for (const double spin : {1.0, -1.0})
    for (const double rate : second_rates) {
      const double K = sensitivity_at(force(rate), spin), first = sensitivity_at(force(second_rates[0]), spin);
      trial.truth.emplace_back(fmt::format("sensitive_term_{}", level), si(K, "deg/h/g"));
      if (rate != second_rates[0]) trial.truth.emplace_back(fmt::format("nonlinearity_{}", level), K / first - 1.0);
      ++level;
    }
}

}  // namespace

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  Trial out;
  out.evidence.plan = second_plan(options);
  Recording recording = simulate(out.evidence.plan, seed, {});
  damage(recording);
  out.evidence.recordings.push_back(std::move(recording));
  add_levels_truth(out);
  for (const auto& drift : {std::span<const TruthValue>(drift_x), std::span<const TruthValue>(drift_y)})
    for (const TruthValue& one : drift) {
      const std::string name = one.name;
      if (name.ends_with("D_F") || name.ends_with("D_xx") || name.ends_with("D_yy")) continue;
      out.truth.emplace_back(name, si(one.value, one.unit));
    }
  out.truth.emplace_back("D_xx_less_D_yy", si(of(drift_x, "D_xx") - of(drift_x, "D_yy"), "deg/h/g^2"));
  for (const char* name : {"p_4", "q_4", "y_p_4", "y_q_4"}) out.truth.emplace_back(name, 0.0);
  const double lag = 2.0 * loop_damping / (two_pi * loop_frequency);
  out.truth.emplace_back("loop_lag", lag);
  out.truth.emplace_back("y_loop_lag", lag);
  out.truth.emplace_back("reference_gain", std::hypot(0.997, si(2.0, "deg")));
  out.truth.emplace_back("reference_azimuth", -std::atan(si(2.0, "deg") / 0.997));
  return out;
}

}  // namespace tumble::dtg_centrifuge

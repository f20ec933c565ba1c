#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tumble/earth/earth.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/dtg_centrifuge/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"

namespace tumble::dtg_centrifuge {
namespace {

using tumble::set_truth;

constexpr int power_ups = 4;
constexpr double arm_rates[] = {114, 160, 254, 359, 508};  // deg/s
constexpr double radius = 2.5;                             // m
constexpr double repeatability = 0.01;                     // deg/h/g, of D_x and D_y each

struct Coefficient {
  const char* name;
  double value;
  const char* unit;
};
constexpr Coefficient drift[] = {
    {"D_F", 4.0, "deg/h"},        {"D_x", 6.0, "deg/h/g"},       {"D_y", -2.5, "deg/h/g"},
    {"D_xz", 0.15, "deg/h/g^2"},  {"D_yz", -0.05, "deg/h/g^2"},  {"D_xx", 0.02, "deg/h/g^2"},
    {"D_yy", -0.01, "deg/h/g^2"}, {"D_xy", 0.015, "deg/h/g^2"},  {"D_xxx", 8e-4, "deg/h/g^3"},
    {"D_xyy", 3e-4, "deg/h/g^3"}, {"D_yyy", -4e-4, "deg/h/g^3"}, {"D_yxx", 2e-4, "deg/h/g^3"}};

double drift_of(const char* name) {
  for (const auto& one : drift)
    if (std::string_view(one.name) == name) return one.value;
  return std::nan("");
}

Motion motion(Motion::Kind kind, double value) {
  Motion out;
  out.kind = kind;
  out.value = value;
  return out;
}

Plan plan_of_trial(const std::vector<Option>& options) {
  Plan plan = trial_plan("dtg_centrifuge", options, "dynamically_tuned_gyro", "counter_rotating_centrifuge", 20.0);
  plan.rig.set_number("radius", radius, Unit::parse("m"));
  plan.rig.set_number("arm_max_acceleration", si(200.0, "deg/s^2"), Unit::parse("deg/s^2"));
  plan.rig.set_number("table_max_acceleration", si(200.0, "deg/s^2"), Unit::parse("deg/s^2"));
  plan.truth.set_integer("oversampling", 4);                         // up to half a turn a sample
  plan.settings.set_number("time_constant", 0.0, Unit::parse("s"));  // there is no loop, and the plan says so
  for (const auto& one : drift) set_truth(plan, one.name, one.value, one.unit);
  set_truth(plan, "angle_random_walk", 0.003, "deg/sqrt(h)");
  plan.channels["reference_gyro"] = {{"fog.gyro", {}}};
  Beside fog{"fog", "fiber_optic_gyro", defaults(truth_options(find_model("fiber_optic_gyro")))};
  fog.truth.set_number("scale_factor_error", si(1000.0, "ppm"), Unit::parse("ppm"));
  fog.truth.set_number("gamma_y", si(1.0, "deg"), Unit::parse("arcsec"));
  fog.truth.set_number("gamma_z", si(0.05, "deg"), Unit::parse("arcsec"));
  fog.truth.set_number("angle_random_walk", si(0.001, "deg/sqrt(h)"), Unit::parse("deg/sqrt(h)"));
  plan.beside.push_back(std::move(fog));
  // for compensate: the specific force
  Beside triad{"triad", "triad", defaults(truth_options(find_model("triad")))};
  triad.truth.set_number("accelerometer_angle_random_walk", si(100.0, "ug/sqrt(Hz)"), Unit::parse("ug/sqrt(Hz)"));
  plan.beside.push_back(std::move(triad));
  for (int run = 1; run <= power_ups; ++run) {
    Segment rest{"static", 10.0, run, {}};
    rest.axes["arm"] = rest.axes["table"] = motion(Motion::Kind::hold, 0.0);
    plan.schedule.push_back(rest);
    int level = 1;
    for (const double rate : arm_rates) {
      Segment spin{fmt::format("spin {}", level++), 60.0, run, {}};
      spin.axes["arm"] = motion(Motion::Kind::rate, si(rate, "deg/s"));
      spin.axes["table"] = motion(Motion::Kind::rate, si(40.0 - rate, "deg/s"));
      plan.schedule.push_back(spin);
    }
  }
  return plan;
}

/// Specific force across the spin axis from the angles [m/s^2]: f_X, f_Y.
std::array<std::vector<double>, 2> specific_force(const Plan& plan, const Recording& recording) {
  const Channel& arm = *find_channel(recording, "arm_angle");
  const Channel& table = *find_channel(recording, "table_angle");
  const double r = plan.rig.number("radius"), rate = arm.timeline.rate;
  std::array<std::vector<double>, 2> out;
  for (auto& along : out) along.resize(arm.values.size());
  for (std::size_t i = 0; i < arm.values.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, arm.values.size() - 1);
    const double w = rate * (arm.values[after] - arm.values[before]) / static_cast<double>(after - before);
    // the arm's angle starts anew with each power-up
    const double a = std::abs(w) < si(2000.0, "deg/s") ? w * w * r : 0.0;
    out[0][i] = -a * std::cos(table.values[i]);
    out[1][i] = a * std::sin(table.values[i]);
  }
  return out;
}

/// Each power-up has its own D_x and D_y: what that adds to the output.
void add_turn_on(std::uint64_t seed, const std::array<std::vector<double>, 2>& force, Recording& recording) {
  Channel& gyro = recording.channels.front();
  const RandomStream random = RandomStream(seed).split("turn-on of the drift");
  const double unit = si(repeatability, "deg/h/g");
  for (std::size_t m = 0; m < recording.marks.size(); ++m) {
    const std::size_t begin = index_at(gyro, recording.marks[m].begin);
    const std::size_t end =
        m + 1 < recording.marks.size() ? index_at(gyro, recording.marks[m + 1].begin) : gyro.values.size();
    const auto draw = 2 * static_cast<std::uint64_t>(recording.marks[m].run);
    const double x = unit * random.normal(draw), y = unit * random.normal(draw + 1);
    for (std::size_t i = begin; i < end; ++i) gyro.values[i] += x * force[0][i] + y * force[1][i];
  }
}

double acceleration(double arm_rate) { return std::pow(si(arm_rate, "deg/s"), 2) * radius / si(1.0, "g"); }

/// K [deg/h/g] of the truth. Given: a and f_Z [g].
double K(double a, double along) {
  const double p =
      drift_of("D_x") + along * drift_of("D_xz") + (0.75 * drift_of("D_xxx") + 0.25 * drift_of("D_xyy")) * a * a;
  const double q =
      drift_of("D_y") + along * drift_of("D_yz") + (0.75 * drift_of("D_yyy") + 0.25 * drift_of("D_yxx")) * a * a;
  return std::hypot(p, q);
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  Trial out;
  out.evidence.plan = plan_of_trial(options);
  Recording recording = simulate(out.evidence.plan, seed, {});
  std::erase_if(recording.channels, [](const Channel& channel) { return channel.name == "gyro_y"; });
  add_turn_on(seed, specific_force(out.evidence.plan, recording), recording);
  out.evidence.recordings.push_back(std::move(recording));
  const double along = gravity(*out.evidence.plan.site) / si(1.0, "g"), first = K(acceleration(arm_rates[0]), along);
  int level = 1;
  for (const double rate : arm_rates) {
    const double here = K(acceleration(rate), along);
    out.truth.emplace_back(fmt::format("sensitive_term_{}", level), si(here, "deg/h/g"));
    if (level > 1) out.truth.emplace_back(fmt::format("nonlinearity_{}", level), here / first - 1.0);
    ++level;
  }
  out.truth.emplace_back("D_x", si(drift_of("D_x") + along * drift_of("D_xz"), "deg/h/g"));
  out.truth.emplace_back("D_y", si(drift_of("D_y") + along * drift_of("D_yz"), "deg/h/g"));
  for (const char* name : {"D_xxx", "D_xyy", "D_yyy", "D_yxx"})
    out.truth.emplace_back(name, si(drift_of(name), "deg/h/g^3"));
  out.truth.emplace_back("D_xx_less_D_yy", si(drift_of("D_xx") - drift_of("D_yy"), "deg/h/g^2"));
  out.truth.emplace_back("D_xy", si(drift_of("D_xy"), "deg/h/g^2"));
  out.truth.emplace_back("reference_gain", std::hypot(1.001, si(1.0, "deg")));
  out.truth.emplace_back("reference_azimuth", std::atan(si(1.0, "deg") / 1.001));
  out.truth.emplace_back("turn_on_repeatability", si(repeatability, "deg/h/g"));
  return out;
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("dtg_centrifuge").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("dtg_centrifuge").options()); }};

}  // namespace tumble::dtg_centrifuge

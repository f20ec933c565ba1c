#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <utility>

#include "tumble/methods/fog_thermal_bias/testing/trial.hpp"
#include "tumble/models/model.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/rigs/rig.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::fog_thermal_bias {
namespace {

Segment segment(int run, double duration, Motion motion) {
  return {fmt::format("run {}", run), duration, run, {{"chamber", motion}}};
}

Motion dwell(double celsius) { return {.kind = Motion::Kind::dwell, .value = si(celsius, "degC")}; }
Motion ramp(double kelvin_per_minute, double to_celsius) {
  return {.kind = Motion::Kind::ramp, .value = si(kelvin_per_minute, "K/min"), .to = si(to_celsius, "degC")};
}

Schedule schedule() {
  Schedule out;
  int run = 0;
  for (const double soak : {-20.0, 0.0, 20.0, 40.0, 60.0}) out.push_back(segment(++run, 2400.0, dwell(soak)));
  for (const double start : {-20.0, 10.0, 35.0, 60.0}) {
    ++run;
    out.push_back(segment(run, 900.0, dwell(start)));
    out.push_back(segment(run, hour, ramp(1.0, start < 20.0 ? 60.0 : -20.0)));
    out.push_back(segment(run, 1800.0, dwell(start < 20.0 ? 50.0 : -10.0)));
    out.push_back(segment(run, 2400.0, ramp(2.0, start < 20.0 ? -20.0 : 60.0)));
    out.push_back(segment(run, 1500.0, ramp(0.5, start)));
  }
  return out;
}

struct Coefficient {
  const char* name;
  double value;
  const char* unit;
};

constexpr Coefficient coefficients[] = {{"A1_0", 2e-3, "deg/h/K"},    {"A1_1", 2e-5, "deg/h/K^2"},
                                        {"A2_0", -3e-5, "deg/h/K^2"}, {"A2_1", 1e-7, "deg/h/K^3"},
                                        {"B1_0", 0.05, "deg/h/K"},    {"B1_1", 3e-4, "deg/h/K^2"},
                                        {"C1_0", 8.0, "deg/h/(K/s)"}, {"C1_1", 0.02, "deg/h/(K/s)/K"},
                                        {"bias_0", 0.3, "deg/h"},     {"bias_1", 1e-3, "deg/h/K"}};

constexpr Coefficient second_coefficients[] = {
    {"A1_0", -3e-3, "deg/h/K"},       {"A1_1", -4e-5, "deg/h/K^2"},          {"A2_0", 5e-5, "deg/h/K^2"},
    {"A2_1", -2e-7, "deg/h/K^3"},     {"A3_0", 4e-7, "deg/h/K^3"},           {"A3_1", -3e-9, "deg/h/K^4"},
    {"B1_0", -0.08, "deg/h/K"},       {"B1_1", -5e-4, "deg/h/K^2"},          {"C1_0", -12.0, "deg/h/(K/s)"},
    {"C1_1", -0.05, "deg/h/(K/s)/K"}, {"startup_transient", -0.05, "deg/h"}, {"bias_0", -0.6, "deg/h"},
    {"bias_1", -2e-3, "deg/h/K"}};

/// Soaks at six temperatures in no order, and two profiles from each of four start temperatures.
Schedule second_schedule() {
  Schedule out;
  int run = 0;
  for (const double soak : {55.0, -30.0, 5.0, 70.0, -10.0, 30.0}) out.push_back(segment(++run, 3000.0, dwell(soak)));
  for (const double start : {65.0, -25.0, 20.0, 45.0})
    for (const bool warmer : {true, false}) {
      const double far = warmer ? 70.0 : -30.0, back = warmer ? -20.0 : 60.0;
      ++run;
      out.push_back(segment(run, 1300.0, dwell(start)));
      out.push_back(segment(run, 3000.0, ramp(warmer ? 1.6 : 0.8, far)));
      out.push_back(segment(run, 1500.0, dwell(far)));
      out.push_back(segment(run, 3400.0, ramp(warmer ? 0.7 : 2.2, back)));
    }
  return out;
}

Plan plan_of(const char* title, Schedule schedule, double sensor_lag, const char* order) {
  const Model& model = find_model("fiber_optic_gyro");
  Plan plan;
  plan.title = title;
  plan.method = "fog_thermal_bias";
  plan.instrument_model = model.name;
  plan.sample_rate = 0.2;
  plan.rig_kind = "thermal_chamber";
  plan.rig = defaults(find_rig("thermal_chamber").options());
  plan.rig.set_number("sensor_lag", sensor_lag, Unit::parse("s"));
  plan.schedule = std::move(schedule);
  plan.truth = defaults(truth_options(model));
  plan.settings = defaults(find_method("fog_thermal_bias").options());
  plan.settings.set_word("order", order);
  plan.settings.set_word("gradient_order", "1");
  plan.settings.set_word("rate_order", "1");
  plan.settings.set_integer("start_temperature_power", 1);
  plan.settings.set_number("sensor_lag", sensor_lag, Unit::parse("s"));
  return plan;
}

/// The truth of the plan, and of the trial what is identified of it. Given: turn_on [deg/h].
void set_coefficients(std::span<const Coefficient> all, double turn_on, Plan& plan, Trial& trial) {
  for (const auto& c : all) {
    set_truth(plan, c.name, c.value, c.unit);
    trial.truth.emplace_back(c.name, si(c.value, c.unit));
  }
  set_truth(plan, "turn_on_repeatability", turn_on, "deg/h");
  trial.truth.emplace_back("turn_on_repeatability", si(turn_on, "deg/h"));
}

}  // namespace

Trial trial(std::uint64_t seed) {
  Plan plan = plan_of("trial of fog_thermal_bias", schedule(), 8.0, "2");
  Trial out;
  set_coefficients(coefficients, 0.01, plan, out);
  set_truth(plan, "angle_random_walk", 0.001, "deg/sqrt(h)");
  set_truth(plan, "bias_instability", 0.002, "deg/h");
  set_truth(plan, "rate_random_walk", 0.001, "deg/h/sqrt(h)");
  out.evidence.recordings.push_back(simulate(plan, seed, {}));
  out.evidence.plan = std::move(plan);
  return out;
}

Trial second_trial(std::uint64_t seed) {
  Plan plan = plan_of("second trial of fog_thermal_bias", second_schedule(), 12.0, "3");
  for (Settings* settings : {&plan.settings, &plan.truth}) {
    settings->set_number("start_temperature_reference", si(5.0, "degC"), Unit::parse("degC"));
    settings->set_number("startup_time", si(8.0, "min"), Unit::parse("min"));
  }
  // Slow samples of coarse sensors need a longer window: their noise would pull the coefficients towards zero.
  set_setting(plan, "smoothing", 90.0, "s");
  set_setting(plan, "averaging", 180.0, "s");
  plan.rig.set_number("sensor_quantum", 0.1, Unit::parse("K"));
  plan.rig.set_number("top_self_heating", -1.0, Unit::parse("K"));
  plan.rig.set_number("side_self_heating", 5.0, Unit::parse("K"));
  Trial out;
  set_coefficients(second_coefficients, 0.02, plan, out);
  set_truth(plan, "angle_random_walk", 0.003, "deg/sqrt(h)");
  set_truth(plan, "rate_random_walk", 0.004, "deg/h/sqrt(h)");
  set_truth(plan, "quantization_noise", 0.05, "arcsec");
  Recording recording = simulate(plan, seed, {});
  // The logger loses three stretches of the gyro and one of a sensor, and single samples of both.
  for (Channel& channel : recording.channels) {
    const bool gyro = channel.name == "gyro";
    for (std::size_t k = 0; k < channel.values.size(); ++k)
      if (k % (gyro ? 97 : 61) == 0 || (gyro && k % 4000 > 3900) || (!gyro && k > 9000 && k < 9030))
        channel.values[k] = std::nan("");
  }
  out.evidence.recordings.push_back(std::move(recording));
  out.evidence.plan = std::move(plan);
  return out;
}

extern const Trials trials{trial, second_trial};

}  // namespace tumble::fog_thermal_bias

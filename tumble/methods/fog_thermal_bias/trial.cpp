#include "tumble/methods/fog_thermal_bias/trial.hpp"

#include <fmt/format.h>

#include "tumble/models/model.hpp"
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

}  // namespace

Trial trial(std::uint64_t seed) {
  const Model& model = find_model("fiber_optic_gyro");
  Plan plan;
  plan.title = "trial of fog_thermal_bias";
  plan.method = "fog_thermal_bias";
  plan.instrument_model = model.name;
  plan.sample_rate = 0.2;
  plan.rig_kind = "thermal_chamber";
  plan.rig = defaults(find_rig("thermal_chamber").options());
  plan.rig.set_number("sensor_lag", 8.0, Unit::parse("s"));
  plan.schedule = schedule();
  plan.truth = defaults(truth_options(model));
  plan.settings = defaults(find_method("fog_thermal_bias").options());
  plan.settings.set_word("order", "2");
  plan.settings.set_word("gradient_order", "1");
  plan.settings.set_word("rate_order", "1");
  plan.settings.set_integer("start_temperature_power", 1);
  plan.settings.set_number("sensor_lag", 8.0, Unit::parse("s"));
  Trial out;
  for (const auto& c : coefficients) {
    const Unit unit = Unit::parse(c.unit);
    plan.truth.set_number(c.name, unit.to_si(c.value), unit);
    out.truth.emplace_back(c.name, unit.to_si(c.value));
  }
  const auto set = [&](const char* name, double value, const char* unit) {
    plan.truth.set_number(name, si(value, unit), Unit::parse(unit));
  };
  set("angle_random_walk", 0.001, "deg/sqrt(h)");
  set("bias_instability", 0.002, "deg/h");
  set("rate_random_walk", 0.001, "deg/h/sqrt(h)");
  set("turn_on_repeatability", 0.01, "deg/h");
  out.truth.emplace_back("turn_on_repeatability", si(0.01, "deg/h"));
  out.evidence.recordings.push_back(simulate(plan, seed, {}));
  out.evidence.plan = std::move(plan);
  return out;
}

}  // namespace tumble::fog_thermal_bias

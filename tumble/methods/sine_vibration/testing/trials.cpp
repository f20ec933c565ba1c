#include "tumble/methods/testing/trials.hpp"

#include <fmt/format.h>

#include <cmath>

#include "tumble/math/random.hpp"
#include "tumble/methods/sine_vibration/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

namespace tumble::sine_vibration {
namespace {

constexpr double natural = 400.0, damping = 0.7;
constexpr double frequencies[] = {10.0, 40.0, 80.0, 99.7, 130.0};

double gain_at(double f) {
  const double r = f / natural, a = 1.0 - r * r, b = 2.0 * damping * r;
  return 1.0 / std::sqrt(a * a + b * b);
}

void add_run(Plan& plan, int run, const char* way, double roll_over) {
  const auto add = [&](const std::string& label, double seconds, const Motion& motion) {
    Segment segment{label, seconds, run, {}};
    if (motion.kind != Motion::Kind::hold) segment.axes["shake"] = motion;
    segment.axes["mount_pitch"] = {.kind = Motion::Kind::hold, .value = roll_over};
    plan.schedule.push_back(std::move(segment));
  };
  add(fmt::format("rest 0 {}", way), 5.0, {});
  int n = 0;
  for (const double f : frequencies) {
    add(fmt::format("{} Hz {}", f, way), 6.5, {.kind = Motion::Kind::sine, .amplitude = si(3.0, "g"), .frequency = f});
    add(fmt::format("rest {} {}", ++n, way), 5.0, {});
  }
}

}  // namespace

Trial trial(std::uint64_t seed, const std::vector<Option>& options) {
  Plan plan = trial_plan("sine_vibration", options, "pendulous_accelerometer", "shaker", 200.0);
  const auto set = [&](const char* name, double value, const char* unit) { set_truth(plan, name, value, unit); };
  plan.truth.set_word("output", "count");
  set("pulse_scale_factor", 20000.0, "pulse/s/g");
  set("natural_frequency", natural, "Hz");
  set("damping_ratio", damping, "1");
  set("bias", 2.0, "mg");
  set("second_order_coefficient", 20.0, "ug/g^2");
  set("third_order_coefficient", 2.0, "ug/g^3");
  set("cross_coupling_ip", 20.0, "ug/g^2");
  set("cross_coupling_io", -20.0, "ug/g^2");
  set("angle_random_walk", 20.0, "ug/sqrt(Hz)");
  set("bias_instability", 5.0, "ug");
  plan.truth.set_integer("oversampling", 32);
  add_run(plan, 1, "up", 0.0);
  add_run(plan, 2, "down", pi);
  const double wrong = 1.0 + 1e-3 * RandomStream(seed).split("sine_vibration").normal(0);
  plan.settings.set_word("scale_factor", fmt::format("{:.6f} pulse/s/g", 20000.0 * wrong));
  Trial trial{{plan, {simulate(plan, seed, {})}}, {}};
  constexpr double g = 9.7955;  // at the site of the trial, to a millionth of a part that matters
  const double second = plan.truth.number("second_order_coefficient"),
               third = plan.truth.number("third_order_coefficient");
  trial.truth = {{"vibration_rectification_up", second + 3.0 * third * g},
                 {"vibration_rectification_down", second - 3.0 * third * g},
                 {"second_order_coefficient", second},
                 {"third_order_coefficient", third}};
  for (const double f : frequencies) {
    std::string name = fmt::format("gain_{}Hz", f);
    for (char& c : name)
      if (c == '.') c = '_';
    trial.truth.emplace_back(name, gain_at(f));
  }
  return trial;
}

extern const Trials trials{
    [](std::uint64_t seed) { return trial(seed, find_method("sine_vibration").options()); },
    [](std::uint64_t seed) { return second_trial(seed, find_method("sine_vibration").options()); }};

}  // namespace tumble::sine_vibration

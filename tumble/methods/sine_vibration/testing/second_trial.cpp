#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/sine_vibration/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

// Against the first trial: two units, of which each loses windows of its own and one loses pulses in some; loops that
// peak; coefficients and biases of the other sign; another site, another rate, other tones, phases and levels; one
// direction of the axis.

namespace tumble::sine_vibration {
namespace {

constexpr double windows_a_second = 250.0, missing_share = 0.005, lost_share = 0.003, lost_pulses = 12.0;
constexpr double second_tones[] = {15.0, 55.0, 90.0, 141.0};

/// A unit, in the units of its data sheet.
struct UnitKind {
  const char* prefix;
  double natural, damping, bias, second, third;
  double gain_at(double f) const {
    const double r = f / natural, a = 1.0 - r * r, b = 2.0 * damping * r;
    return 1.0 / std::sqrt(a * a + b * b);
  }
  double rectification(double a_0) const { return si(second, "ug/g^2") + 3.0 * si(third, "ug/g^3") * a_0; }
};
constexpr UnitKind unit_kinds[] = {{"accelerometer.", 250.0, 0.5, -4.0, -30.0, -1.5},
                                   {"S2.", 300.0, 0.4, 6.0, 45.0, 1.0}};

Settings truth_of(const UnitKind& unit, Settings truth) {
  const auto set = [&](const char* name, double value, const char* shown) {
    truth.set_number(name, si(value, shown), Unit::parse(shown));
  };
  truth.set_word("output", "count");
  truth.set_integer("oversampling", 32);
  set("pulse_scale_factor", 10000.0, "pulse/s/g");
  set("natural_frequency", unit.natural, "Hz");
  set("damping_ratio", unit.damping, "1");
  set("bias", unit.bias, "mg");
  set("second_order_coefficient", unit.second, "ug/g^2");
  set("third_order_coefficient", unit.third, "ug/g^3");
  set("cross_coupling_ip", -20.0, "ug/g^2");
  set("cross_coupling_io", 20.0, "ug/g^2");
  set("angle_random_walk", 30.0, "ug/sqrt(Hz)");
  set("bias_instability", 8.0, "ug");
  return truth;
}

Plan second_plan(const std::vector<Option>& options, const RandomStream& random) {
  Plan plan = trial_plan("sine_vibration", options, "pendulous_accelerometer", "shaker", windows_a_second);
  plan.site->latitude = si(-55.0, "deg");
  plan.site->height = 1800.0;
  plan.settings.set_word("scale_factor", fmt::format("accelerometer: {:.6f} pulse/s/g, S2: {:.6f} pulse/s/g",
                                                     10000.0 * (1.0 + 1e-3 * random.normal(0)),
                                                     10000.0 * (1.0 + 1e-3 * random.normal(1))));
  plan.truth = truth_of(unit_kinds[0], plan.truth);
  plan.beside = {{"S2", plan.instrument_model, truth_of(unit_kinds[1], plan.truth)}};
  int n = 0;
  const auto rest = [&] { plan.schedule.push_back({fmt::format("rest {}", n++), 6.0, 1, {}}); };
  rest();
  for (const double f : second_tones) {
    Segment segment{fmt::format("{} Hz", f), 8.5, 1, {}};
    segment.axes["shake"] = {
        .kind = Motion::Kind::sine, .amplitude = si(f < 50.0 ? 4.0 : 5.0, "g"), .frequency = f, .phase = 0.3 * n};
    plan.schedule.push_back(std::move(segment));
    rest();
  }
  return plan;
}

/// Windows that the unit lacks, and pulses that the counter of the second unit loses.
void spoil(const RandomStream& random, Recording& recording) {
  for (Channel& channel : recording.channels) {
    if (channel.kind != QuantityKind::count) continue;
    const RandomStream own = random.split(channel.name);
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      if (channel.name.starts_with("S2") && own.split("pulses").uniform(i) < lost_share)
        channel.values[i] -= lost_pulses;
      if (own.split("windows").uniform(i) < missing_share) channel.values[i] = std::nan("");
    }
  }
}

}  // namespace

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  const RandomStream random = RandomStream(seed).split("sine_vibration, second");
  Trial trial;
  trial.evidence.plan = second_plan(options, random);
  trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {})};
  spoil(random, trial.evidence.recordings[0]);
  const Site& site = *trial.evidence.plan.site;
  const double a_0 = normal_gravity(site.latitude, site.height.value_or(0.0));
  double log_ratio = 0.0;
  for (const UnitKind& unit : unit_kinds) {
    trial.truth.emplace_back(std::string(unit.prefix) + "vibration_rectification", unit.rectification(a_0));
    for (const double f : second_tones)
      trial.truth.emplace_back(fmt::format("{}gain_{}Hz", unit.prefix, f), unit.gain_at(f));
  }
  for (const double f : second_tones)
    log_ratio += std::log(unit_kinds[1].gain_at(f) / unit_kinds[0].gain_at(f)) / std::size(second_tones);
  trial.truth.emplace_back("S2.gain_ratio", std::exp(log_ratio));
  trial.truth.emplace_back("S2.rectification_difference",
                           unit_kinds[1].rectification(a_0) - unit_kinds[0].rectification(a_0));
  return trial;
}

}  // namespace tumble::sine_vibration

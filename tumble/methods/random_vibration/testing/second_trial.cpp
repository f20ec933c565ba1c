#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "tumble/earth/earth.hpp"
#include "tumble/math/random.hpp"
#include "tumble/methods/random_vibration/spectrum.hpp"
#include "tumble/methods/random_vibration/testing/trial.hpp"
#include "tumble/reduce/testing/trial_plan.hpp"
#include "tumble/reduce/vibration/vibration.hpp"
#include "tumble/sim/simulate.hpp"
#include "tumble/units/constants.hpp"

// Against the first trial: the axis points down; each unit lacks windows of its own, and one loses pulses in some;
// coefficients and biases of the other sign; another site, another density, other times.

namespace tumble::random_vibration {
namespace {

constexpr double windows_a_second = 250.0, rest_before = 25.0, in_vibration = 50.0, rest_after = 15.0, wait = 0.5;
constexpr double missing_share = 0.004, lost_share = 0.002, lost_pulses = 15.0;
constexpr int steps = 24;

/// A unit, in the units of its data sheet.
struct Part {
  const char* prefix;
  double bias, second, third, walk;
  double rectification(double a_0) const { return si(second, "ug/g^2") + 3.0 * si(third, "ug/g^3") * a_0; }
};
constexpr double pulses_a_second = 4000.0;
constexpr Part one{"accelerometer.", -4.0, -160.0, -2.0, 90.0}, two{"Q2.", 6.0, -450.0, 3.0, 60.0};

Settings truth_of(const Part& part, Settings truth) {
  const auto set = [&](const char* name, double value, const char* shown) {
    truth.set_number(name, si(value, shown), Unit::parse(shown));
  };
  truth.set_word("output", "count");
  truth.set_integer("oversampling", steps);
  set("pulse_scale_factor", pulses_a_second, "pulse/s/g");
  set("bias", part.bias, "mg");
  set("second_order_coefficient", part.second, "ug/g^2");
  set("third_order_coefficient", part.third, "ug/g^3");
  set("cross_coupling_ip", -20.0, "ug/g^2");
  set("cross_coupling_io", 20.0, "ug/g^2");
  set("angle_random_walk", part.walk, "ug/sqrt(Hz)");
  set("bias_instability", 4.0, "ug");
  return truth;
}

SpectralDensity second_density() {
  const double s = si(0.04, "g^2/Hz");
  return {{30.0, 31.0, 300.0, 1500.0}, {s, s, 2.0 * s, s}};
}

Plan second_plan(const std::vector<Option>& options, const RandomStream& random) {
  Plan plan = trial_plan("random_vibration", options, "pendulous_accelerometer", "shaker", windows_a_second);
  plan.site->latitude = si(61.0, "deg");
  plan.site->height = 900.0;
  constexpr double scale_sd = 5e-4;
  plan.settings.set_word("scale_factor", fmt::format("accelerometer: {:.6f} pulse/s/g, Q2: {:.6f} pulse/s/g",
                                                     pulses_a_second * (1.0 + scale_sd * random.normal(0)),
                                                     pulses_a_second * (1.0 + scale_sd * random.normal(1))));
  plan.settings.set_number("scale_factor_sd", scale_sd, Unit::parse("%"));
  plan.settings.set_number("settling", wait, Unit::parse("s"));
  plan.rig.set_number("amplitude_sd", 1e-3, Unit::parse("%"));
  const auto psd = second_density();
  const Motion down{.kind = Motion::Kind::hold, .value = pi};
  const Motion shaken{.kind = Motion::Kind::random, .psd_frequency = psd.frequency, .psd = psd.density};
  plan.schedule = {{"cold", rest_before, 1, {{"shake", Motion{}}, {"mount_pitch", down}}},
                   {"shaken", in_vibration, 1, {{"shake", shaken}, {"mount_pitch", down}}},
                   {"warm", rest_after, 1, {{"shake", Motion{}}, {"mount_pitch", down}}}};
  plan.truth = truth_of(one, plan.truth);
  plan.beside = {{"Q2", plan.instrument_model, truth_of(two, plan.truth)}};
  return plan;
}

/// Windows that each unit lacks, and pulses that the counter of the second loses.
void spoil(const RandomStream& random, Recording& recording) {
  for (Channel& channel : recording.channels) {
    if (channel.kind != QuantityKind::count) continue;
    const RandomStream windows = random.split(channel.name), pulses = windows.split("pulses");
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      if (channel.name.starts_with("Q2") && pulses.uniform(i) < lost_share) channel.values[i] -= lost_pulses;
      if (windows.uniform(i) < missing_share) channel.values[i] = std::nan("");
    }
  }
}

/// Variance of the simulated windows, which are means of steps.
double variance_of_second_windows(const SpectralDensity& psd) {
  constexpr int points = 100000;
  const double low = psd.frequency.front(), step = (psd.frequency.back() - low) / points;
  double sum = 0.0;
  for (int i = 0; i < points; ++i) {
    const double f = low + (i + 0.5) * step;
    const double gain = vibration::sinc(f / windows_a_second) / vibration::sinc(f / windows_a_second / steps);
    sum += density_at(psd, f) * gain * gain * step;
  }
  return sum;
}

}  // namespace

Trial second_trial(std::uint64_t seed, const std::vector<Option>& options) {
  static const double of_windows = variance_of_second_windows(second_density());
  Trial trial;
  const RandomStream random = RandomStream(seed).split("random_vibration, second");
  trial.evidence.plan = second_plan(options, random);
  trial.evidence.recordings = {simulate(trial.evidence.plan, seed, {})};
  spoil(random, trial.evidence.recordings[0]);
  const Site& site = *trial.evidence.plan.site;
  const double a_0 = -normal_gravity(site.latitude, site.height.value_or(0.0)), square = variance(second_density());
  const double per_force = si(pulses_a_second, "pulse/s/g") / windows_a_second;
  // A missing window takes both neighbours with it, and a lost pulse the window from both units.
  const double present = std::pow(1.0 - missing_share, 3) * (1.0 - lost_share);
  const double peaks = 2.0 * greatest_of((in_vibration - wait) * windows_a_second * present).mean;
  const auto sd_of = [&](const Part& part) {
    const double walk = si(part.walk, "ug/sqrt(Hz)");
    const double slope =
        1.0 + 2.0 * si(part.second, "ug/g^2") * a_0 + 3.0 * si(part.third, "ug/g^3") * (a_0 * a_0 + square);
    return std::sqrt(slope * slope * of_windows + walk * walk * windows_a_second + 1.0 / 6.0 / (per_force * per_force));
  };
  for (const Part& part : {one, two}) {
    const std::string prefix = part.prefix;
    trial.truth.emplace_back(prefix + "pulse_error_mean", per_force * part.rectification(a_0) * square);
    trial.truth.emplace_back(prefix + "pulse_error_sd", per_force * sd_of(part));
    trial.truth.emplace_back(prefix + "pulse_error_peak_to_peak", peaks * per_force * sd_of(part));
    trial.truth.emplace_back(prefix + "vibration_rectification", part.rectification(a_0));
  }
  const std::string over = "accelerometer_over_Q2.";
  trial.truth.emplace_back(over + "mean_ratio", one.rectification(a_0) / two.rectification(a_0));
  trial.truth.emplace_back(over + "sd_ratio", sd_of(one) / sd_of(two));
  trial.truth.emplace_back(over + "peak_to_peak_ratio", sd_of(one) / sd_of(two));
  return trial;
}

}  // namespace tumble::random_vibration
